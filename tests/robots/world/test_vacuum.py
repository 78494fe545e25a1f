"""A vacuum holds what pulls, shears and twists less than its limits, and lets go of what does more."""

from collections.abc import Iterator

import numpy as np
import pybullet
import pytest
from cup_down import FLAT, LOADS, RAMP, loaded, lowered

from topple.robots import shapes
from topple.robots.world.acting_arm import ActingArm
from topple.robots.world.bodies import Body
from topple.robots.world.world import World, in_bullet
from topple.topology.base.arrays import FloatArray


@pytest.fixture
def lifted() -> Iterator[ActingArm]:
    """An arm whose cup holds a plate 5 cm above a table."""
    with World() as world:
        arm, up = lowered(world, shapes.plate("plate"), FLAT)
        assert arm.suck()
        arm.follow(up)
        assert arm.holding
        yield arm


def knobbed(*knobs: tuple[float, float, float]) -> Body:
    """A plate with square knobs, 1 cm wide, on its flat: (x, y, height) of each [m]."""
    plate = shapes.plate("plate")
    base = FLAT - 0.001
    corners = np.array([[x, y, z] for x in (-0.005, 0.005) for y in (-0.005, 0.005) for z in (0.0, 1.0)])
    parts = [corners * [1, 1, 0.001 + high] + np.array([x, y, base]) for x, y, high in knobs]
    return Body.of("plate", [*plate.parts, *parts], mass=plate.mass)


@pytest.mark.parametrize(
    ("knobs", "seals"),
    [
        ([(0.016, 0.0, 0.005)], False),  # under the lip
        ([(0.0, 0.0, 0.005)], False),  # within it: the cup stands on it
        ([(0.016, 0.0, 0.001)], True),
        ([(0.04, 0.0, 0.005)], True),  # beside the cup
        (
            [(0.016, 0.0, 0.005), (-0.016, 0.0, 0.005), (0.0, 0.016, 0.0), (0.0, -0.016, 0.0)],
            False,
        ),  # a saddle
    ],
)
def test_a_cup_seals_on_what_its_lip_bridges_and_no_more(knobs, seals):
    with World() as world:
        under = max((high for x, y, high in knobs if x == y == 0.0), default=0.0)
        arm, _ = lowered(world, knobbed(*knobs), FLAT + under)
        assert arm.suck() is seals


@pytest.mark.parametrize(("mass", "held"), [(0.4, True), (0.8, False)])
def test_what_hangs_beside_the_cup_bends_it_off(mass, held):
    """A bar held 9 cm beside its middle: 0.8 kg are a fifth of the force, and more than its moment."""
    with World() as world:
        bar = shapes.box("bar", (0.3, 0.06, 0.04), mass=mass)
        arm, up = lowered(world, bar, 0.04, beside=0.09)
        assert arm.suck() and arm.vacuum is not None
        arm.follow(up)
        arm.wait(0.3)
        assert arm.holding is held
        if held:
            _, moment = arm.vacuum.load()
            assert moment == pytest.approx([0.0, 0.09 * mass * 9.81, 0.0], abs=0.01)


def held_under(arm: ActingArm, force: FloatArray, twist: float) -> bool:
    """Whether a cup still holds its plate under a force [N] at its lip and a moment [N m] about its axis."""
    world = in_bullet(arm.world)
    plate, lip = world.ids["plate"], arm.link_pose("suction_cup")[:3, 3].tolist()
    for step in range(2 * RAMP):
        share = min(1.0, (step + 1) / RAMP)
        pybullet.applyExternalForce(
            plate, -1, (share * force).tolist(), lip, pybullet.WORLD_FRAME, physicsClientId=world.client
        )
        pybullet.applyExternalTorque(
            plate, -1, [0.0, 0.0, share * twist], pybullet.WORLD_FRAME, physicsClientId=world.client
        )
        arm.step()
    return arm.holding


@pytest.mark.parametrize(("pull", "shear", "twist", "held"), LOADS)
def test_a_cup_holds_up_to_its_force_and_its_moment(lifted, pull, shear, twist, held):
    """Loads in shares of the cup's force, across it and about it of what friction bears of that."""
    assert held_under(lifted, *loaded(lifted, pull, shear, twist)) is held
