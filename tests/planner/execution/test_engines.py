"""The same decisions in a world on MuJoCo: to the goal, judged by true poses and forces."""

import numpy as np
import pytest
from on_table import on_table

pytest.importorskip("mujoco", reason="MuJoCo is not installed: pip install '.[mujoco]'")

from topple.planner.cli.main import main
from topple.planner.execution.demo import loop_in
from topple.planner.execution.run import run
from topple.planner.execution.trial import trial
from topple.robots import scenario
from topple.robots.catalog import robot
from topple.robots.mujoco.acting import MujocoArm
from topple.robots.mujoco.world import MujocoWorld
from topple.robots.shapes import plate


@pytest.mark.slow
def test_a_tower_is_built_on_mujoco():
    with scenario("tower", 0, "mujoco") as stage:
        assert isinstance(stage.world, MujocoWorld)
        loop = loop_in(stage)
        assert isinstance(loop.robot, MujocoArm)
        record = loop.run()
        assert record.success, record.violations
        middles = np.array(
            [
                stage.world.pose(name)[:3, :3] @ stage.world.body(name).centre_of_mass
                + stage.world.pose(name)[:3, 3]
                for name in ("blue", "green", "red")
            ]
        )
        touched = {frozenset((contact.a, contact.b)) for contact in stage.world.contacts()}
    np.testing.assert_allclose(middles[:, 2], [0.025, 0.075, 0.125], atol=0.005)
    assert np.ptp(middles[:, :2], axis=0).max() < 0.025
    assert {frozenset(("blue", "green")), frozenset(("green", "red"))} <= touched
    assert all(step.slip is None or step.slip[0] < 0.01 for step in record.steps)


@pytest.mark.slow
def test_a_scene_is_rebuilt_and_cleared_on_mujoco():
    arm = robot("panda")
    tried = trial(arm, "fingers")
    assert tried is not None
    record = run(tried.scene(), [tried.name], arm, pose_base_to_world=np.eye(4), engine="mujoco")
    assert record.success, record.violations


@pytest.mark.slow
def test_a_plate_is_lifted_by_a_cup_on_mujoco():
    record = run(on_table((plate("plate"), (0, 0, 0))), ["plate"], "panda-suction", engine="mujoco")
    assert record.success, record.violations


def test_what_mujoco_does_not_play_is_refused_in_one_line(tmp_path, capsys):
    play = ["demo", "hold", "--seed", "0", "--engine", "mujoco", "-o", str(tmp_path / "out")]
    assert main(play) == 2
    said = [line for line in capsys.readouterr().err.splitlines() if line.startswith("topple: ")]
    assert len(said) == 1 and "two arms act in a world on bullet alone" in said[0]
