"""What another package adds by entry points: used by its name, and named and left out where it is broken."""

import importlib
import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from topple.planner.cli.main import main
from topple.planner.errors import NoSafePlan
from topple.planner.execution.run import run
from topple.planner.export import EXPORTERS, export
from topple.planner.grasp.foreign import GRASP_READERS, read_grasps
from topple.planner.grasp.rank import rank_grasps
from topple.planner.grasp.shape import GRIPPERS
from topple.planner.planning.order import cautious, ordered
from topple.planner.planning.plan import plan
from topple.planner.planning.plan_format import Plan, plan_from_json, plan_to_json
from topple.planner.planning.step import ORDERERS
from topple.robots import scenario
from topple.robots.catalog import ROBOTS, names, robot
from topple.robots.scenarios import SCENARIOS
from topple.robots.shapes.boxes import block, can
from topple.topology import InvalidInput, load_scene
from topple.topology.base.plugins import Table
from topple.topology.io.load import READERS
from topple.topology.relations.relate import RULES, relate, relate_all
from topple.topology.scene.scene import Scene

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

KITCHEN = Path(__file__).parent / "kitchen"
PAGE = Path(__file__).parents[2] / "docs" / "plugins.md"
TABLES: tuple[Table[Any], ...] = (
    RULES, ORDERERS, READERS, GRASP_READERS, ROBOTS, EXPORTERS, SCENARIOS, GRIPPERS,
)  # fmt: skip
STACK = {
    name: np.random.default_rng(1).uniform([0, 0, low], [0.1, 0.1, low + 0.1], (300, 3))
    for name, low in (("lower", 0.0), ("upper", 0.1))
}
"""Two boxes, and a third beside them that is higher than the lower."""
STACK["beside"] = STACK["lower"] * [1, 1, 1.5] + [0.2, 0, 0]


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder in which the package lies as an installer leaves it: modules and metadata."""
    place = tmp_path_factory.mktemp("site-packages")
    shutil.copytree(KITCHEN / "topple_kitchen", place / "topple_kitchen")
    project = tomllib.loads((KITCHEN / "pyproject.toml").read_text())["project"]
    about = place / "topple_kitchen-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: 1.0\n")
    lines = [
        line
        for group, entries in project["entry-points"].items()
        for line in (f"[{group}]", *(f"{name} = {value}" for name, value in entries.items()))
    ]
    (about / "entry_points.txt").write_text("\n".join(lines) + "\n")
    return place


@pytest.fixture
def kitchen(installed: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """The package can be imported, and topple has not looked for packages yet."""
    monkeypatch.syspath_prepend(str(installed))
    importlib.invalidate_caches()
    for table in TABLES:
        table.__dict__.pop("_entries", None)
    yield
    for table in TABLES:
        table.__dict__.pop("_entries", None)


def _scene() -> Scene:
    table = np.random.default_rng(0).uniform([-0.3, -0.3, -0.01], [0.7, 0.4, 0.0], (4000, 3))
    return Scene({"table": table, **STACK}, fixed=["table"], up=[0, 0, 1])


@pytest.mark.parametrize("table", TABLES, ids=lambda table: table.group)
def test_topples_own_are_found_by_name(table):
    assert len(list(table)) >= 2
    for name in table:
        assert table[name] is not None
    with pytest.raises(InvalidInput, match=f"there is no {table.role} 'x': expected "):
        _ = table["x"]


def test_every_group_of_the_page_is_one_of_topple_and_its_code_is_what_is_tested():
    page = PAGE.read_text(encoding="utf-8")
    project = tomllib.loads((KITCHEN / "pyproject.toml").read_text())["project"]
    assert set(re.findall(r"`(topple\.\w+)` \|", page)) == {table.group for table in TABLES}
    assert set(project["entry-points"]) == {table.group for table in TABLES}
    blocks = re.findall(r"^```py\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)
    files = {path: path.read_text() for path in sorted((KITCHEN / "topple_kitchen").glob("*.py"))}
    shown = [text for path, text in files.items() if path.stem not in ("__init__", "failing", "magnet")]
    assert sorted(blocks) == sorted(shown) and len(shown) == len(TABLES) - 1
    magnet = (KITCHEN / "topple_kitchen" / "magnet.py").read_text()
    for text, most in (*((text, 14) for text in shown), (magnet, 60)):
        assert len([line for line in text.splitlines() if line]) <= most, text


@pytest.mark.usefixtures("kitchen")
def test_a_rule_of_another_package_relates():
    scene = _scene()
    assert relate(scene, rule="boxes").between("lower", "beside").relation == "disjoint"
    assert relate(scene, rule="boxes").between("lower", "upper").relation == "touch"
    assert relate(scene, 0.12, rule="boxes").between("lower", "beside").relation == "touch"
    assert relate_all([scene], rule="boxes") == [relate(scene, rule="boxes")]


def test_the_names_of_topples_own_rules_are_what_the_arguments_were():
    scene = _scene()
    assert relate(scene, rule="plain") == relate(scene, plain=True)
    assert relate(scene, rule="robust") == relate(scene)
    with pytest.raises(InvalidInput, match="the rule is plain and 'robust'"):
        relate(scene, plain=True, rule="robust")
    assert ORDERERS["fewest"] is ordered and ORDERERS["cautious"] is cautious


@pytest.mark.usefixtures("kitchen")
def test_what_is_broken_is_named(tmp_path, caplog):
    with pytest.raises(InvalidInput, match=r"rule 'broken' of package topple-kitchen 1.0 .* failed: ModuleN"):
        relate(_scene(), rule="broken")
    with pytest.raises(InvalidInput, match=r"rule 'failing' .* failed: ValueError: no rule for 4 objects$"):
        relate(_scene(), rule="failing")
    with pytest.raises(InvalidInput, match=r"orderer 'failing' .*: it gave list, expected Order"):
        ORDERERS["failing"](_scene(), ["lower"])
    np.savez(tmp_path / "scene.npz", **STACK)
    assert len(load_scene(tmp_path / "scene.npz").names) == 3  # the reader that is broken is left out
    assert [record.message for record in caplog.records] == [
        "reader of scenes 'broken' of package topple-kitchen 1.0 (topple_kitchen.nowhere) failed: "
        "ModuleNotFoundError: No module named 'topple_kitchen.nowhere'; it is left out"
    ]
    assert load_scene(tmp_path / "scene.npz") and len(caplog.records) == 1  # and said once


@pytest.mark.usefixtures("kitchen")
def test_a_name_of_topples_own_is_not_taken_over(caplog):
    assert "kitchen-arm" in names() and names().count("panda") == 1
    assert "robot 'panda' of package topple-kitchen 1.0" in caplog.text
    assert "there is one of that name" in caplog.text


@pytest.mark.usefixtures("kitchen")
def test_files_of_other_formats_are_read(tmp_path):
    lines = [f"{name},{','.join(map(str, point))}" for name, cloud in STACK.items() for point in cloud]
    (tmp_path / "scene.csv").write_text("\n".join(lines))
    scene = load_scene(tmp_path / "scene.csv", fixed=["beside"])
    assert scene.names == tuple(STACK) and scene.fixed == {"beside"} and scene.up is not None
    assert scene.clouds["upper"] == pytest.approx(STACK["upper"])
    (tmp_path / "broken.csv").write_text("cup,1,2,three\n")
    with pytest.raises(
        InvalidInput, match=r"broken\.csv: reader of scenes 'csv' of package .* could not conv"
    ):
        load_scene(tmp_path / "broken.csv")
    (tmp_path / "grasps.csv").write_text("0.1,0.2,0.3,0.05\n")
    grasps = read_grasps(tmp_path / "grasps.csv")
    assert grasps.widths.tolist() == [0.05] and grasps.poses_tool_to_source[0, :3, 3].tolist() == [
        0.1,
        0.2,
        0.3,
    ]


@pytest.mark.usefixtures("kitchen")
def test_an_arm_and_a_scene_of_another_package_are_known_by_name():
    arm = robot("kitchen-arm")
    assert arm.name == "kitchen-arm" and arm.tools and arm.catalog
    with scenario("cups", 3) as stage:
        assert stage.goal == "free low" and set(stage.world.movable) == {"low", "high"}


@pytest.mark.slow
@pytest.mark.usefixtures("kitchen")
def test_an_arm_a_scene_an_orderer_and_an_exporter_of_another_package_plan_together():
    with scenario("cups", 3) as stage:
        images = [eye.look(stage.world) for eye in stage.cameras]
        seen = Scene.from_images(images, fixed=stage.fixed, up=stage.up)
        base = stage.pose_base_to_world
    arm = robot("kitchen-arm")
    found: Plan = plan(seen, stage.goal, arm, pose_base_to_world=base, orderer=ORDERERS["highest"])
    assert export(found, "list") == "1. remove high\n2. free low\n"
    assert plan_from_json(plan_to_json(found)) == found  # whose arm is found again by its name


def _tin() -> Scene:
    """A can of steel and a block of wood on a table."""
    rng = np.random.default_rng(0)
    table = rng.uniform(-0.6, 0.6, (5000, 3)) * [1, 1, 0]
    wood = block("wood").surface(3000, rng) + np.array([0.0, 0.15, 0.0])
    clouds = {"table": table, "steel_can": can().surface(4000, rng), "wood": wood}
    return Scene(clouds, fixed=["table"], up=[0, 0, 1])


@pytest.mark.usefixtures("kitchen")
def test_a_gripper_of_another_package_plans_verifies_and_runs():
    scene, arm, base = _tin(), robot("magnet-iiwa"), np.eye(4)
    base[0, 3] = -0.55
    found = plan(scene, ["steel_can"], arm, pose_base_to_world=base)
    (step,) = found.steps
    assert (step.grasp.kind, {part.tool for part in step.segments}) == ("magnet", {"magnet"})
    assert found.verify(scene).ok
    assert plan_from_json(plan_to_json(found)) == found
    told = rank_grasps(scene, np.array([step.grasp.pose_tool_to_world]), arm)
    assert [(entry.grasp.object, entry.why) for entry in told] == [("steel_can", None)]
    assert run(scene, ["steel_can"], arm, pose_base_to_world=base).success
    with pytest.raises(NoSafePlan, match="no steel, which the magnet wants"):
        plan(scene, ["wood"], arm, pose_base_to_world=base)


@pytest.mark.usefixtures("kitchen")
def test_commands_take_them_by_name(tmp_path, monkeypatch, capsys, typed):
    monkeypatch.chdir(tmp_path)
    np.savez("scene.npz", up=[0, 0, 1], fixed=["table"], **dict(_scene().clouds))
    assert (
        main(["order", "scene.npz", "--rule", "boxes", "--orderer", "highest", "--target", "lower", "--json"])
        == 0
    )
    assert json.loads(capsys.readouterr().out)["order"] == ["upper", "beside", "lower"]
    said = typed("relate", "scene.npz", "--rule", "broken", code=2)
    assert said.out == "" and said.err.startswith("topple: rule 'broken' of package topple-kitchen 1.0 (")
    err = typed("order", "scene.npz", "--orderer", "x", code=2).err
    assert "there is no orderer 'x': expected fewest, cautious, highest, failing\n" in err


@pytest.mark.usefixtures("kitchen")
def test_grasps_are_ranked_by_the_order_of_another_package(tmp_path, monkeypatch, typed):
    monkeypatch.chdir(tmp_path)
    np.savez("scene.npz", up=[0, 0, 1], fixed=["table"], **dict(_scene().clouds))
    Path("grasps.csv").write_text("0.25,0.05,0.08,0.08\n")  # of beside, which nothing touches
    waits = {}
    for options in ([], ["--orderer", "highest"], ["--rule", "boxes"]):
        (grasp,) = typed("rank", "scene.npz", "grasps.csv", *options, "--json").document["grasps"]
        assert grasp["object"] == "beside"
        waits["".join(options)] = grasp["before"]
    assert waits == {"": [], "--orderer" + "highest": ["upper"], "--rule" + "boxes": []}


COMMANDS = [
    ["relate", "scene.npz"],
    ["order", "scene.npz"],
    ["plan", "scene.npz", "--target", "lower"],
    ["run", "scene.npz", "--target", "lower"],
    ["rank", "scene.npz", "grasps.csv"],
    ["score", "scene.npz"],
    ["show", "scene.npz"],
    ["view", "scene.npz"],
    ["demo", "tower"],
]


@pytest.mark.parametrize("command", COMMANDS, ids=lambda command: command[0])
def test_every_command_that_relates_and_orders_takes_both(command, tmp_path, monkeypatch, typed):
    monkeypatch.chdir(tmp_path)
    np.savez("scene.npz", up=[0, 0, 1], fixed=["table"], **dict(_scene().clouds))
    for option in ("--rule", "--orderer")[: 1 if command[0] == "relate" else 2]:
        assert f"there is no {option[2:]} 'x': expected " in typed(*command, option, "x", code=2).err


@pytest.mark.slow
@pytest.mark.usefixtures("kitchen")
def test_a_plan_is_written_in_the_format_of_another_package(tmp_path, capsys, typed):
    with scenario("cups", 3) as stage:
        seen = Scene.from_images([eye.look(stage.world) for eye in stage.cameras], fixed=stage.fixed)
        found = plan(seen.with_up([0, 0, 1]).with_base(stage.pose_base_to_world), stage.goal, "panda")
    (tmp_path / "plan.json").write_bytes(plan_to_json(found))
    assert main(["export", str(tmp_path / "plan.json"), "--to", "list", "-o", str(tmp_path / "list")]) == 0
    assert (tmp_path / "list").read_text().endswith(". free low\n")
    capsys.readouterr()
    err = typed("export", tmp_path / "plan.json", "--to", "x", code=2).err
    assert "expected dot, graphml, pddl, bt, moveit, ros2, list" in err


@pytest.mark.slow
def test_an_installed_package_is_found_by_the_command(installed, tmp_path):
    np.savez(tmp_path / "scene.npz", **STACK)
    done = subprocess.run(
        [sys.executable, "-m", "topple.planner.cli.main", "relate", "scene.npz", "--rule", "boxes"],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(installed), "OMP_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
        check=True,
    )
    assert re.search(r"^lower +touch +upper", done.stdout, re.MULTILINE)
    assert done.stderr.startswith("topple: reader of scenes 'broken' of package topple-kitchen 1.0 (")
    assert len(done.stderr.splitlines()) == 1
