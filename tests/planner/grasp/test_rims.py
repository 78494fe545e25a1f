"""A plate is pinched by its rim where that stands high enough off the ground, and lifted by friction."""

import re

import numpy as np
import pytest
from moving import at, straight
from on_table import on_table

from topple.planner.grasp import Grasp, grasp_candidates
from topple.planner.grasp.jaw import hand_shape
from topple.planner.grasp.surroundings import Dropped
from topple.robots.arm.arm import Arm
from topple.robots.arm.tolerances import PRESS
from topple.robots.catalog import robot
from topple.robots.poses import angle_between
from topple.robots.shapes.boxes import box
from topple.robots.shapes.tableware import plate
from topple.robots.world.simulated_arm import SimulatedArm
from topple.robots.world.world import World
from topple.topology.base.arrays import FloatArray
from topple.topology.scene.scene import Scene

MIDDLE = (0.55, 0.0)


def raised(height: float) -> Scene:
    """A plate on a block, or flat on the table where the height is nothing."""
    block = ((box("block", (0.08, 0.08, height)), (*MIDDLE, 0.0)),) if height > 0.0 else ()
    return on_table((plate(), (*MIDDLE, height)), *block, points=6000, half=0.4, x=MIDDLE[0])


def reached(arm: Arm, grasps: list[Grasp], back: FloatArray) -> tuple[Grasp, FloatArray]:
    """The first grasp, and joint values before it, from which the arm gets to it."""
    for grasp in [way for one in grasps for way in (one, one.turn())]:
        for q in arm.inverse(grasp.pose_tool_to_world @ back, "fingers")[0]:
            if len(arm.inverse(grasp.pose_tool_to_world, "fingers", near=q)[0]):
                return grasp, q
    raise AssertionError("no grasp is within reach")


@pytest.mark.parametrize(("name", "height"), [("panda", 0.12), ("iiwa", 0.05)])
def test_a_plate_is_held_by_its_rim_and_lifted(name, height):
    arm = robot(name)
    grasps = grasp_candidates("plate", raised(height), arm)
    assert {grasp.kind for grasp in grasps} == {"rim"}
    back = at(0.0, 0.0, -0.08)
    grasp, q = reached(arm, grasps, back)
    with World() as world:
        world.add_table()
        if height > 0.0:
            world.add(box("block", (0.08, 0.08, height)), at(*MIDDLE, 0.0))
        world.add(plate("plate"), at(*MIDDLE, height))
        world.settle()
        hand = SimulatedArm(world, arm, np.eye(4), q=q)
        pose = grasp.pose_tool_to_world
        hand.open(grasp.opening)
        straight(hand, pose @ back, pose)
        before = world.pose("plate")
        assert arm.jaw is not None
        hand.close(PRESS * arm.jaw.force)
        straight(hand, pose, at(0.0, 0.0, 0.05) @ pose)
        hand.wait(0.3)
        after = world.pose("plate")
        assert hand.holding
        assert after[2, 3] - before[2, 3] > 0.04
        assert np.degrees(angle_between(before, after)) < 5.0


def test_a_rim_too_close_to_the_table_says_how_much_room_a_finger_and_the_hand_need():
    dropped = Dropped()
    panda = robot("panda")
    assert grasp_candidates("plate", raised(0.0), panda, dropped=dropped) == []
    (words,) = [reason for reason in dropped.reasons if "its rim is" in reason]
    height, needed = (int(number) for number in re.findall(r"(\d+) mm", words))
    assert 18 <= height <= 23 < 1e3 * hand_shape(panda).finger[0].y[1] + 8 < needed
