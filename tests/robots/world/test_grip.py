"""Whether a jaw holds is told by its encoder and its motor, not by what the simulation knows of contacts."""

from collections.abc import Iterator

import numpy as np
import pytest
from moving import at, down, go

from topple.robots import shapes
from topple.robots.catalog import robot
from topple.robots.world.simulated_arm import SimulatedArm
from topple.robots.world.world import World

ARMS = ("panda", "iiwa", "xarm6")  # slides, slides that stand apart, a linkage of hinges


@pytest.fixture
def world() -> Iterator[World]:
    with World() as made:
        made.add_table()
        yield made


def lowered(world: World, name: str) -> SimulatedArm:
    """An arm with its open fingers about what stands at (0.5, 0)."""
    arm = SimulatedArm(world, robot(name), at(0.0, 0.0, 0.0))
    go(arm, down(0.5, 0.0, 0.25))
    go(arm, down(0.5, 0.0, 0.08))
    assert not arm.holding, "an open hand"
    return arm


@pytest.mark.parametrize("name", ARMS)
def test_an_empty_jaw_closes_and_holds_nothing(world, name):
    arm = lowered(world, name)
    opening = arm.close(42.0)
    assert arm.jaw is not None
    assert not arm.holding
    assert opening < 0.002
    assert arm.grip_force < 1.0, "its motor does not push against anything"
    go(arm, down(0.5, 0.0, 0.25))
    assert not arm.holding, "moving it does not press on the pads"


@pytest.mark.slow
@pytest.mark.parametrize("name", ARMS)
@pytest.mark.parametrize("thick", [0.001, 0.03])
def test_a_sheet_and_a_box_are_held(world, name, thick):
    world.add(shapes.box("thing", (0.06, thick, 0.1), mass=0.05), at(0.5, 0.0, 0.0))
    arm = lowered(world, name)
    opening = arm.close(42.0)
    arm.wait(0.2)
    assert arm.holding
    assert opening >= thick - 1e-3
    assert arm.jaw is not None
    assert arm.grip_force <= 1.01 * min(42.0, arm.jaw.force)
    go(arm, down(0.5, 0.0, 0.25))
    assert arm.holding and world.pose("thing")[2, 3] > 0.1
    arm.open()
    assert not arm.holding


def test_a_linkage_whose_tips_press_keeps_its_pads_upright(world):
    world.add(shapes.box("thing", (0.06, 0.05, 0.06), mass=0.5), at(0.5, 0.0, 0.0), fixed=True)
    arm = SimulatedArm(world, robot("xarm6"), at(0.0, 0.0, 0.0))
    jaw = arm.jaw
    assert jaw is not None
    tips = arm.arm.tools["fingers"].pads(0.05)[2, 3] + jaw.pad_size[1] / 2.0
    go(arm, down(0.5, 0.0, 0.25))
    go(arm, down(0.5, 0.0, 0.055 + tips))  # their last 5 mm are beside it
    arm.close(jaw.force)
    assert arm.holding
    values = arm.joint_positions(jaw.joints)
    assert np.ptp(values) < 0.03, "rad: its joints go by the same angle"


def test_a_jaw_that_was_told_to_open_so_far_holds_nothing(world):
    arm = lowered(world, "panda")
    arm.open(0.03)
    assert arm.opening == pytest.approx(0.03, abs=1e-3)
    assert not arm.holding


def test_a_jaw_notices_what_is_pulled_out_of_it(world):
    world.add(shapes.box("thing", (0.06, 0.03, 0.1), mass=0.05), at(0.5, 0.0, 0.0))
    arm = lowered(world, "panda")
    arm.close(42.0)
    go(arm, down(0.5, 0.0, 0.25))
    assert arm.holding
    world.place("thing", at(0.5, 0.5, 0.0))
    arm.wait(0.05)
    assert not arm.holding, "while it closes on the gap"
    arm.wait(1.0)
    assert not arm.holding and arm.opening < 1e-3


def test_a_jaw_notices_a_load_that_slips_through(world):
    world.add(shapes.can("can", mass=4.0), at(0.5, 0.0, 0.0))
    world.settle()
    arm = lowered(world, "panda")
    arm.close(5.0)
    assert arm.holding, "it stands and is pressed on"
    go(arm, down(0.5, 0.0, 0.25))
    arm.wait(1.0)
    assert world.pose("can")[2, 3] < 0.05
    assert not arm.holding
