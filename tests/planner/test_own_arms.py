"""Arms of others, from URDF to a plan and a run that hold: a UR5e with a cup and with a 2F-85, a Panda."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest
from moving import at

from topple.planner.cli.main import main
from topple.planner.execution.run import run
from topple.planner.planning.plan import plan
from topple.planner.planning.plan_format import plan_from_json, plan_to_json
from topple.robots.catalog import data_path, robot
from topple.topology.base.errors import InvalidInput
from topple.topology.scene.scene import Scene

PANDA = data_path() / "franka_panda" / "panda.urdf"
CUP = 'cup = {link = "tool0", offset = [0, 0, 0.1], radius = 0.015}'


@pytest.fixture(scope="module")
def scene() -> Scene:
    """A cube on a table."""
    rng = np.random.default_rng(1)
    cube = rng.uniform(-0.025, 0.025, (1500, 3))
    cube[np.arange(1500), rng.integers(3, size=1500)] = rng.choice([-0.025, 0.025], 1500)
    table = rng.uniform(-0.6, 0.6, (5000, 3)) * [1, 1, 0]
    return Scene({"table": table, "cube": cube + np.array([0, 0, 0.025])}, fixed=["table"], up=(0, 0, 1))


@pytest.fixture
def options(request: pytest.FixtureRequest, tmp_path: Path) -> tuple[Path, Path | None]:
    """URDF and gripper file."""
    if request.param == "panda":
        return PANDA, None
    found = importlib.util.find_spec("airo_models")  # its own __init__ wants more than the files
    if found is None or not found.submodule_search_locations:
        pytest.skip("airo-models, which carries the URDF of a UR5e, is not installed")
    (tmp_path / "cup.toml").write_text(CUP)
    place = Path(next(iter(found.submodule_search_locations)))
    hand = place / "grippers" / "robotiq_2f_85" / "urdf" / "robotiq_2f_85.urdf"
    return place / "arms" / "ur5e" / "ur5e.urdf", hand if request.param == "2f-85" else tmp_path / "cup.toml"


@pytest.mark.slow
@pytest.mark.parametrize("options", ["panda", "ur5e", "2f-85"], indirect=True)
def test_a_plan_holds_and_finds_its_arm_again(scene, options):
    base = at(-0.45, 0.0, 0.0)
    found = plan(scene, ["cube"], robot(options[0], gripper=options[1]), pose_base_to_world=base)
    again = plan_from_json(plan_to_json(found))
    assert again == found
    assert again.arm is not None and not again.arm.catalog
    assert ":" in again.arm.urdf  # the file of an installed package: another machine finds it
    checked = again.verify(scene)  # the arm is made from what the plan says
    assert checked.ok, [(bad.name, bad.value, bad.witness) for bad in checked.residuals if not bad.ok]
    assert any("accelerations" in words for words in found.assumptions)


@pytest.mark.slow
@pytest.mark.parametrize("options", ["panda", "ur5e", "2f-85"], indirect=True)
def test_a_run_in_pybullet_succeeds(scene, options):
    base = at(-0.45, 0.0, 0.0)
    record = run(scene, ["cube"], robot(options[0], gripper=options[1]), pose_base_to_world=base)
    assert record.success, record.violations


def saved(scene: Scene, folder: Path) -> str:
    np.savez(folder / "scene.npz", **{name: np.asarray(cloud) for name, cloud in scene.clouds.items()})
    return str(folder / "scene.npz")


def test_the_commands_take_a_urdf(scene, tmp_path, typed):
    path, place = saved(scene, tmp_path), tmp_path / "plan.json"
    target = ["--target", "cube", "--robot", str(PANDA)]
    out = typed("plan", path, *target, "--base", "-0.45", "0", "0", "0", "--verify", "-o", place).out
    assert "every residual at most 0" in out
    assert main(["export", str(place), "--to", "moveit"]) == 0
    assert main(["order", path, *target]) == 0


@pytest.mark.parametrize("command", ["order", "plan", "run"])
def test_an_arm_without_a_tool_is_told_what_to_write(scene, tmp_path, capsys, command):
    """The iiwa of pybullet_data ends in a bare flange."""
    path = saved(scene, tmp_path)
    flange = str(data_path() / "kuka_iiwa" / "model.urdf")
    capsys.readouterr()
    for more in ([], ["--base", "-0.45", "0", "0", "0"] if command != "order" else []):
        assert main([command, path, "--target", "cube", "--robot", flange, *more]) == 2
        lines = [line for line in capsys.readouterr().err.splitlines() if "nothing to take hold with" in line]
        assert len(lines) == 1
        assert 'cup = {link = "lbr_iiwa_link_7"' in lines[0] and "--gripper FILE.toml" in lines[0]


def test_a_gripper_needs_a_robot_of_ones_own(scene, tmp_path, typed):
    path = saved(scene, tmp_path)
    (tmp_path / "cup.toml").write_text(CUP)
    gripper = ["--gripper", str(tmp_path / "cup.toml")]
    assert "--gripper is what the robot holds with" in typed("order", path, *gripper, code=2).err
    assert "panda has a hand of its own" in typed("plan", path, "--target", "cube", *gripper, code=2).err


def test_in_python_the_same_words(scene):
    with pytest.raises(InvalidInput, match="nothing to take hold with"):
        plan(scene, ["cube"], robot(data_path() / "kuka_iiwa" / "model.urdf"))
