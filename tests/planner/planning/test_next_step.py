"""The next step in scenes of a few clouds: how what one camera saw of a thing is put down again."""

import numpy as np

from topple.planner.decide.goal import parse_goal
from topple.planner.planning.next_step import StepChooser
from topple.planner.planning.step import Station
from topple.robots.catalog import robot
from topple.robots.scenarios.scenario import pose_at
from topple.topology.scene import Scene

PANDA = robot("panda")


def test_a_box_seen_from_one_side_is_not_put_onto_its_open_side() -> None:
    rng = np.random.default_rng(0)
    side = np.array([0.05, 0.06, 0.1])
    faces = rng.uniform(0.0, 1.0, (2, 1500, 3))
    faces[0, :, 2] = 1.0  # the top
    faces[1, :, 0] = 0.0  # the side towards the camera
    seen = (faces.reshape(-1, 3) - [0.5, 0.5, 0.0]) * side
    grid = np.stack(np.meshgrid(np.arange(-0.6, 0.6, 0.008), np.arange(-0.6, 0.6, 0.008)), -1).reshape(-1, 2)
    behind = (grid[:, 0] > -0.03) & (grid[:, 0] < 0.1) & (np.abs(grid[:, 1]) < 0.03)
    table = np.column_stack([grid[~behind], np.zeros((~behind).sum())])
    scene = Scene({"box": seen, "table": table}, fixed=["table"], up=(0, 0, 1), viewpoints=[[-0.6, 0.0, 0.6]])
    station = Station(PANDA, pose_at(-0.5, 0.0, 0.0), np.asarray(PANDA.home))
    step = StepChooser(scene, parse_goal("free box", scene), station).choose()
    assert step is not None
    assert np.degrees(step.transfer.placement.tilt(np.array([0.0, 0.0, 1.0]))) < 10.0
