"""A plan for two arms: what is held, by which arm, and that no motion meets the other arm."""

from collections.abc import Iterator

import numpy as np
import pytest

from topple.planner.execution.look import Observer
from topple.planner.motion.collision import Checker
from topple.planner.motion.other_arm import arm_bodies, surface_points
from topple.planner.motion.tolerances import GIVES_WAY, SPREAD
from topple.planner.planning.step import NextStep
from topple.planner.planning.two_handed import plan_two_handed
from topple.planner.transfer.transfer import Transfer
from topple.robots import robot as robot_named
from topple.robots import scenario
from topple.robots.scenarios.scenario import pose_at
from topple.topology.base.arrays import FloatArray


def test_an_arm_that_stands_by_is_in_the_way_with_a_margin():
    arm = robot_named("panda")
    bodies = arm_bodies("the other's", arm, pose_at(0.9, 0.0, 0.0), arm.home, (arm.open_hand,))
    assert "the other's panda_hand" in bodies
    poses = arm.forward(arm.home, arm.open_hand)[0]
    index = arm.links.index("panda_hand")
    hand = np.concatenate(arm.parts[index]) @ poses[index, :3, :3].T + poses[index, :3, 3] + [0.9, 0.0, 0.0]
    grown = np.concatenate(bodies["the other's panda_hand"])
    assert grown.max(axis=0) == pytest.approx(hand.max(axis=0) + GIVES_WAY)
    assert grown.min(axis=0) == pytest.approx(hand.min(axis=0) - GIVES_WAY)
    assert Checker(arm, np.eye(4), bodies).free(arm.home)[0]
    near = arm_bodies("the other's", arm, pose_at(0.1, 0.0, 0.0), arm.home, (arm.open_hand,))
    assert not Checker(arm, np.eye(4), near).free(arm.home)[0]


def test_points_of_an_arm_lie_on_its_links_in_every_state():
    arm, base = robot_named("panda"), pose_at(0.9, 0.0, 0.0)
    other = np.asarray(arm.home) + 0.2
    points = surface_points(arm, base, np.array([arm.home, other]))
    for row, q in zip(points, (arm.home, other), strict=True):
        poses = base @ arm.forward(q)[0]
        linked = [(pose, part) for pose, parts in zip(poses, arm.parts, strict=True) for part in parts]
        corners = np.concatenate([part @ pose[:3, :3].T + pose[:3, 3] for pose, part in linked])
        assert (row.min(axis=0) > corners.min(axis=0) - 1e-6).all()
        assert (row.max(axis=0) < corners.max(axis=0) + 1e-6).all()
        assert np.abs(row.max(axis=0) - corners.max(axis=0)).max() < SPREAD
    assert surface_points(arm, base, np.empty((0, len(arm.joints)))).shape[0] == 0


def _done_by(step: NextStep) -> Iterator[tuple[bool, Transfer]]:
    """What the arms do for a step in turn, each with whether the second does it."""
    if step.grip is not None:
        yield not step.by_second, step.grip
    yield step.by_second, step.transfer
    if step.let_go is not None:
        yield not step.by_second, step.let_go


@pytest.mark.slow
def test_a_hold_is_planned_whole_and_each_motion_keeps_clear_of_the_other_arm():
    arm = robot_named("panda")
    with scenario("hold", 1) as stage:
        scene = Observer(stage.world, stage.cameras, np.random.default_rng(1), stage.fixed).look().scene
        bases: tuple[FloatArray, ...] = (stage.pose_base_to_world, np.asarray(stage.pose_second_to_world))
        both = dict(zip(("pose_base_to_world", "pose_second_to_world"), bases, strict=True))
        steps = plan_two_handed(scene, stage.goal, arm, **both)
    assert steps[-1].transfer.object == "plank"
    assert [step.grip is not None for step in steps].count(True) == 1
    stand = [np.asarray(arm.home), np.asarray(arm.home)]
    for step in steps:
        for second, transfer in _done_by(step):
            other = arm_bodies("the other's", arm, bases[not second], stand[not second], (arm.open_hand,))
            links = {name: parts for name, parts in other.items() if "finger" not in name}
            checker = Checker(arm, bases[second], links)
            for segment in transfer.segments:
                if segment.motion is not None:
                    assert segment.certified
                    assert checker.free(segment.motion.positions).all()
            stand[second] = transfer.q_end if transfer is step.grip else np.asarray(arm.home)
