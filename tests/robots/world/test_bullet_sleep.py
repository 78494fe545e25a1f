"""What rests sleeps while an arm passes by, wakes as it is touched, and falls as if it had never slept."""

from collections.abc import Iterator

import numpy as np
import pytest
from moving import at, down, go, straight

from topple.robots import shapes
from topple.robots.catalog import robot
from topple.robots.world.simulated_arm import SimulatedArm
from topple.robots.world.tolerances import ASLEEP_AFTER
from topple.robots.world.world import World


@pytest.fixture
def world() -> Iterator[World]:
    with World() as world:
        world.add_table()
        yield world


def asleep(arm: SimulatedArm) -> bool:
    """Whether nothing moves by a bit in a tenth of a second; what is awake trembles."""
    before = arm.world.poses()
    arm.wait(0.1)
    return all(np.array_equal(pose, before[name]) for name, pose in arm.world.poses().items())


def test_what_rests_sleeps_and_a_step_of_the_world_wakes_it(world):
    world.add(shapes.mug("mug"), at(0.5, 0.0, 0.0))
    world.settle()
    arm = SimulatedArm(world, robot("panda"), np.eye(4))
    arm.wait(2 * ASLEEP_AFTER)
    assert asleep(arm)
    world.place("mug", at(0.5, 0.0, 0.1))
    arm.wait(0.5)
    assert world.pose("mug")[2, 3] == pytest.approx(0.0, abs=2e-3)  # it fell


def test_a_hand_moves_what_slept(world):
    world.add(shapes.can("can"), at(0.5, 0.1, 0.0))
    world.settle()
    arm = SimulatedArm(world, robot("panda"), np.eye(4))
    go(arm, down(0.5, -0.1, 0.06), "fingers")
    assert asleep(arm)
    straight(arm, down(0.5, -0.1, 0.06), down(0.5, 0.1, 0.06))
    assert abs(world.pose("can")[1, 3] - 0.1) > 0.05 or world.pose("can")[2, 2] < 0.5


def test_what_stood_on_a_thing_falls_as_that_is_taken_away(world):
    world.add(shapes.can("can"), at(0.5, 0.0, 0.0))
    world.add(shapes.box("board", (0.16, 0.16, 0.01), mass=0.1), at(0.5, 0.0, 0.101))
    world.add(shapes.block("far"), at(0.3, 0.4, 0.0))
    world.settle()
    arm = SimulatedArm(world, robot("panda"), np.eye(4))
    go(arm, down(0.56, -0.3, 0.106), "fingers")
    assert asleep(arm)
    far = world.pose("far")
    straight(arm, down(0.56, -0.3, 0.106), down(0.56, 0.15, 0.106))  # sweeps the board off the can
    arm.wait(1.0)
    assert world.pose("board")[2, 3] < 0.09
    assert np.allclose(world.pose("far"), far, atol=1e-4)


def test_what_is_let_go_falls_on_what_sleeps_and_moves_it(world):
    world.add(shapes.block("block"), at(0.5, 0.0, 0.0))
    world.add(shapes.can("tower"), at(0.5, 0.25, 0.0))
    world.settle()
    arm = SimulatedArm(world, robot("panda"), np.eye(4))
    go(arm, down(0.5, 0.0, 0.2), "fingers")
    go(arm, down(0.5, 0.0, 0.025), "fingers")
    arm.close(30.0)
    go(arm, down(0.5, 0.0, 0.3), "fingers")
    go(arm, down(0.5, 0.215, 0.3), "fingers")
    assert arm.holding
    before = world.pose("tower")
    arm.open()
    arm.wait(1.0)
    moved = np.linalg.norm(world.pose("tower")[:3, 3] - before[:3, 3])
    assert world.pose("block")[2, 3] < 0.15 and moved > 1e-4
