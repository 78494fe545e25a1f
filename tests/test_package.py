import ast
import re
import subprocess
import sys
from importlib.metadata import metadata, requires, version
from pathlib import Path

import pytest
from packaging.requirements import Requirement

import topple
from topple.topology.errors import DISTRIBUTION, InvalidInput, NotInstalled

ROOT = Path(__file__).resolve().parents[1]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]
CODE = [
    path
    for folder in ("topology", "robots", "planner", "examples")
    for path in sorted((ROOT / folder).rglob("*.py"))
]
TEXTS = {path: path.read_text(encoding="utf-8") for path in (*PAGES, *CODE)}


def _printed(code: str) -> tuple[str, str]:
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return done.stdout, done.stderr


def test_the_distribution_is_not_the_other_topple_of_pypi() -> None:
    assert DISTRIBUTION == "topple-planner"
    assert topple.__version__ == version("topple-planner")


def test_no_text_installs_the_other_topple() -> None:
    assert {"README.md", "CONTRIBUTING.md"} <= {path.name for path in TEXTS}
    for path, text in TEXTS.items():
        assert not re.findall(r"pip install [^`\n]*\btopple(?!-planner)\b[\['\" `]", text), path


def test_every_public_name_of_the_front_door_is_there() -> None:
    for name in topple.__all__:
        assert getattr(topple, name) is not None
    with pytest.raises(AttributeError, match="'topple' has no attribute 'pile'"):
        _ = topple.pile


def test_the_front_door_is_light() -> None:
    heavy = "{'numpy', 'scipy', 'pybullet'}"
    assert _printed(f"import sys, topple; print(sorted({heavy} & set(sys.modules)))") == ("[]\n", "")


def test_the_engine_comes_without_its_greeting() -> None:
    pytest.importorskip("pybullet")
    assert _printed("import topple.robots.world.world") == ("", "")


def test_a_missing_part_is_wrong_use_that_names_its_extra() -> None:
    required = " ".join(requires("topple-planner") or ())
    extras = set(re.findall(r"extra == ['\"](\w+)", required))
    named = {
        extra
        for text in TEXTS.values()
        for groups in re.findall(r"NotInstalled\(\s*\"[^\"]+\",\s*\"(\w+)\"|topple-planner\[(\w+)\]", text)
        for extra in groups
        if extra
    }
    assert {"sim", "video", "rerun"} <= named <= extras
    error = NotInstalled("films need PyAV", "video")
    assert isinstance(error, InvalidInput)
    assert str(error) == "films need PyAV: pip install 'topple-planner[video]' (in a checkout '.[video]')"


@pytest.mark.parametrize(
    ("python", "machine", "expected"),
    [
        ("3.10", "x86_64", True),
        ("3.11", "x86_64", True),
        ("3.12", "x86_64", False),
        ("3.13", "x86_64", False),
        ("3.11", "aarch64", False),
    ],
)
def test_pybullet_is_required_where_it_has_a_wheel_and_nowhere_else(
    python: str, machine: str, expected: bool
) -> None:
    needed = map(Requirement, requires("topple-planner") or ())
    (marker,) = (r.marker for r in needed if r.name == "pybullet" and "extra" not in str(r.marker))
    assert marker is not None
    platform = {"platform_system": "Linux", "platform_machine": machine, "implementation_name": "cpython"}
    assert marker.evaluate({**platform, "python_version": python}) == expected


def test_the_badges_say_what_is_stated() -> None:
    badges = re.findall(r"<text [^>]*>([^<]+)</text>", (ROOT / "docs/figures/badges.svg").read_text("utf-8"))
    said = dict(zip(badges[::2], badges[1::2], strict=True))
    about = metadata("topple-planner")
    classifiers = about.get_all("Classifier")
    pythons = [last for text in classifiers if re.fullmatch(r"3\.\d+", last := text.rpartition(" ")[2])]
    assert said["python"].split(" | ") == pythons
    assert said["licence"] == about["License-Expression"]
    assert f"Development Status :: 4 - {said['status'].title()}" in classifiers
    assert said["types"] == "checked, shipped" and (ROOT / "topology" / "py.typed").exists()
    assert f"Python {pythons[0]} to {pythons[-1]}, {said['licence']} licence" in TEXTS[ROOT / "README.md"]


def test_the_floor_plan_names_every_room() -> None:
    drawn = re.findall(r"class='name'>(\w+)/<", (ROOT / "docs/figures/floor_plan.svg").read_text("utf-8"))
    layers = ("topology", "robots", "planner")
    rooms = [room.parent.name for layer in layers for room in (ROOT / layer).glob("*/__init__.py")]
    assert len(rooms) > 20 and sorted(drawn) == sorted(rooms)


@pytest.mark.parametrize(("layer", "most"), [("topology", 36), ("robots", 49), ("planner", 69)])
def test_thresholds_stand_in_the_tolerances(layer: str, most: int) -> None:
    files = [path for path in (ROOT / layer).rglob("*.py") if path.name != "tolerances.py"]
    found = [f"{path.relative_to(ROOT)}: {name}" for path in files for name in _numbers(TEXTS[path])]
    assert len(found) <= most, "\n".join(["move to the tolerances what decides anything:", *found])


def _numbers(code: str) -> list[str]:
    """The constants of a module that are a number or several: sizes of blocks, data sheets, colours."""
    given = [node for node in ast.parse(code).body if isinstance(node, (ast.Assign, ast.AnnAssign))]
    named = [(target, node.value) for node in given for target in _targets(node) if node.value is not None]
    return [target.id for target, value in named if target.id.isupper() and _is_number(value)]


def _targets(node: ast.Assign | ast.AnnAssign) -> list[ast.Name]:
    targets = node.targets if isinstance(node, ast.Assign) else [node.target]
    return [target for target in targets if isinstance(target, ast.Name)]


def _is_number(value: ast.expr) -> bool:
    if isinstance(value, ast.Tuple):
        return any(map(_is_number, value.elts))
    if isinstance(value, ast.BinOp):
        return _is_number(value.left) or _is_number(value.right)
    if isinstance(value, ast.UnaryOp):
        return _is_number(value.operand)
    return isinstance(value, ast.Constant) and type(value.value) in (int, float)
