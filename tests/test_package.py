import ast
import re
import subprocess
import sys
from importlib.metadata import metadata, requires, version
from pathlib import Path

import numpy as np
import pytest
from packaging.requirements import Requirement

import topple.planner
import topple.robots
from topple.topology.base.errors import DISTRIBUTION, InvalidInput, NotInstalled
from topple.topology.kernels.compiled import path_in_words

ROOT = Path(__file__).resolve().parents[1]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
CODE = [
    path
    for folder in ("topology", "robots", "planner", "examples")
    for path in sorted((ROOT / folder).rglob("*.py"))
]
TEXTS = {path: path.read_text(encoding="utf-8") for path in (*PAGES, *CODE)}

PROGRAM = """
import topple
from topple.planner import ClosedLoop, Look, Perception
from topple.robots import Driver, ToolState, around
from topple.topology import DepthImage, Situation, Scene


class Eyes:
    def __init__(self, scene: Scene) -> None:
        self.scene = scene

    def look(self, expected: Scene | None = None, more: object = ()) -> Look:
        return Look((), Situation(self.scene), None)


def decide(path: str, robot: str) -> list[str]:
    scene = topple.load_scene(path)
    relations: topple.Relations = topple.relate(scene)
    print(relations.between("a", "b").relation)
    found: topple.Order = topple.order(scene, "a")
    made: topple.Plan = topple.plan(scene, "free a", robot)
    made.save("plan.json")
    again = topple.Plan.load("plan.json")
    same = topple.Plan.from_json(again.to_json())
    scene.save("again.npz")
    print(same.verify(scene).ok, found.explanation)
    return [step.object for step in made.steps]


def drive(driver: Driver, eyes: Perception, images: list[DepthImage]) -> ToolState:
    seen = eyes.look(more=images)
    print(seen.relations, len(around((0.0, 0.0, 0.0))))
    record: topple.RunRecord = topple.run(seen.scene, "free a", "panda")
    print(record.success, topple.__version__, ClosedLoop)
    return driver.tool_state


drive_with: Perception = Eyes(topple.Scene({"a": [[0.0, 0.0, 0.0]]}))
"""


def _printed(code: str) -> tuple[str, str]:
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return done.stdout, done.stderr


def test_the_distribution_is_not_the_other_topple_of_pypi():
    assert DISTRIBUTION == "topple-planner"
    assert topple.__version__ == version("topple-planner")


def test_no_text_asks_a_package_index_for_topple():
    assert {"README.md", "CONTRIBUTING.md", "install.md", "ros.md"} <= {path.name for path in TEXTS}
    for path, text in TEXTS.items():
        asked = re.findall(r"pip install [^`\n]*\btopple[-_][^`\n]*|topple-planner\[[^`\n]*", text)
        assert all(".whl" in each for each in asked), path
        assert not re.findall(r"pip install [^`\n]*\btopple\b(?![-_])", text), path


def test_every_public_name_of_the_front_door_is_there():
    for name in topple.__all__:
        assert getattr(topple, name) is not None
    with pytest.raises(AttributeError, match="'topple' has no attribute 'pile'"):
        _ = topple.pile


STABLE = {
    topple: "Scene load_scene scene_from_rgbd scene_from_world relate order plan run rearrange build_order "
    "next_view rank_grasps check robot NoSafePlan InvalidInput ToppleError Plan Order Relations RunRecord",
    topple.topology: "DepthImage Relation Relations Scene Situation scene_from_objects scene_from_points "
    "scene_from_coco merge_views relate_all",
    topple.robots: "World Body Camera SimulatedArm Driver robot around scenario",
    topple.planner: "ClosedLoop plan order dependencies verify Plan",
}
"""Names that programs of others import: they stay whatever lies behind them."""


def test_names_that_others_import_stay():
    for package, names in STABLE.items():
        for name in names.split():
            assert callable(getattr(package, name)), name


@pytest.mark.parametrize("checker", ["ty", pytest.param("mypy", marks=pytest.mark.slow)])
def test_what_a_program_uses_is_listed_and_typed(checker, tmp_path):
    packages = (topple, topple.topology, topple.robots, topple.planner)
    for package in packages:
        assert set(package.__all__) <= set(dir(package))
    modules = "".join(f"import {package.__name__}\n" for package in packages[1:])
    names = [f"{package.__name__}.{name}" for package in packages for name in package.__all__]
    assert len(names) >= 100
    program = tmp_path / "program.py"
    every = f"every: list[object] = [{', '.join(names)}]"
    program.write_text(f"{modules}{PROGRAM}\n{every}\n", encoding="utf-8")
    source = ["--config-file", "", "--cache-dir", str(tmp_path), "--follow-imports", "silent"]
    argv = {"mypy": ["--strict", *source], "ty": ["check", "--python", sys.executable]}[checker]
    done = subprocess.run(
        [sys.executable, "-m", checker, *argv, str(program)], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_plans_and_scenes_come_back_from_their_files(tmp_path):
    grid = np.stack(np.meshgrid(*[np.linspace(-0.3, 0.3, 40)] * 2, [0.0]), axis=-1).reshape(-1, 3)
    ball = np.random.default_rng(0).normal(size=(600, 3))
    ball = 0.03 * ball / np.linalg.norm(ball, axis=1, keepdims=True) + [0.0, 0.0, 0.03]
    scene = topple.Scene(
        {"table": grid, "ball/1": ball}, fixed=["table"], up=[0, 0, 1], masses={"ball/1": 0.2},
        friction={"table": 0.5}, viewpoints=[[0.5, 0.0, 0.6]], robot_base=np.eye(4),
    )  # fmt: skip
    scene.save(tmp_path / "scene.npz")
    assert topple.load_scene(tmp_path / "scene.npz") == scene
    with pytest.raises(InvalidInput, match="an object is called 'up'"):
        topple.Scene({"up": ball}).save(tmp_path / "other.npz")
    with pytest.raises(InvalidInput, match=r"nowhere/scene.npz: cannot be written"):
        scene.save(tmp_path / "nowhere" / "scene.npz")
    with pytest.raises(InvalidInput, match=r"nowhere.json: cannot be read"):
        topple.Plan.load(tmp_path / "nowhere.json")


def test_the_package_is_a_command():
    done = subprocess.run([sys.executable, "-m", "topple", "--version"], capture_output=True, text=True)
    assert done.stdout == f"topple {topple.__version__}, {path_in_words()}\n"


def test_the_front_door_is_light():
    heavy = "{'numpy', 'scipy', 'pybullet'}"
    assert _printed(f"import sys, topple; print(sorted({heavy} & set(sys.modules)))") == ("[]\n", "")
    asked = "import sys, topple; topple.order, topple.relate, topple.load_scene"
    heavy = "{'topple.robots', 'pybullet', 'trimesh', 'fcl', 'PIL'}"
    assert _printed(f"{asked}; print(sorted({heavy} & set(sys.modules)))") == ("[]\n", "")


def test_the_engine_comes_without_its_greeting():
    pytest.importorskip("pybullet")
    assert _printed("import topple.robots.world.world") == ("", "")


def test_a_missing_part_is_wrong_use_that_names_its_packages():
    required = " ".join(requires("topple-planner") or ())
    extras = set(re.findall(r"extra == ['\"](\w+)", required))
    named = {
        extra
        for text in TEXTS.values()
        for groups in re.findall(r"NotInstalled\(\s*\"[^\"]+\",\s*\"(\w+)\"|pip install '\.\[(\w+)\]", text)
        for extra in groups
        if extra
    }
    assert {"sim", "video", "view"} <= named <= extras
    error = NotInstalled("films need PyAV", "video")
    assert isinstance(error, InvalidInput)
    assert str(error) == "films need PyAV: pip install 'av>=12'"


@pytest.mark.parametrize(
    ("python", "machine", "expected"),
    [
        ("3.10", "x86_64", True),
        ("3.11", "x86_64", True),
        ("3.12", "x86_64", True),
        ("3.13", "x86_64", True),
        ("3.14", "x86_64", False),
        ("3.11", "aarch64", False),
    ],
)
def test_pybullet_is_required_where_it_has_a_wheel_and_nowhere_else(python, machine, expected):
    needed = map(Requirement, requires("topple-planner") or ())
    markers = [r.marker for r in needed if "pybullet" in r.name and "extra" not in str(r.marker)]
    platform = {"platform_system": "Linux", "platform_machine": machine, "implementation_name": "cpython"}
    here = {**platform, "python_version": python}
    assert sum(marker is not None and marker.evaluate(here) for marker in markers) == expected


def test_the_badges_say_what_is_stated():
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


def test_the_floor_plan_names_every_room():
    drawn = re.findall(r"class='name'>(\w+)/<", (ROOT / "docs/figures/floor_plan.svg").read_text("utf-8"))
    layers = ("topology", "robots", "planner")
    rooms = [room.parent.name for layer in layers for room in (ROOT / layer).glob("*/__init__.py")]
    assert len(rooms) > 20 and sorted(drawn) == sorted(rooms)


@pytest.mark.parametrize(("layer", "most"), [("topology", 36), ("robots", 49), ("planner", 69)])
def test_thresholds_stand_in_the_tolerances(layer, most):
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
