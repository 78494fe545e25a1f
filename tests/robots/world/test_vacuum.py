"""A vacuum holds what pulls, shears and twists less than its limits, and lets go of what does more."""

from collections.abc import Iterator

import numpy as np
import pybullet
import pytest
from moving import FLIP, Way

from topple.robots import shapes
from topple.robots.catalog import robot
from topple.robots.world.bodies import Body
from topple.robots.world.simulated_arm import SimulatedArm
from topple.robots.world.world import World
from topple.topology.arrays import FloatArray

RAMP = 30  # steps until a load is whole: a load put on at once would be a knock


def lowered(world: World, body: Body, beside: float = 0.0) -> tuple[SimulatedArm, Way]:
    """An arm whose cup is on a body on a table, some way beside its middle [m], and the way back up, 5 cm."""
    world.add_table()
    place = np.eye(4)
    place[0, 3] = 0.5 + beside
    world.add(body, place)
    world.settle()
    top = pybullet.rayTest([0.5, 0.0, 0.5], [0.5, 0.0, -0.1], physicsClientId=world.client)[0][3][2]
    model = robot("panda-suction")
    heights, states = np.linspace(top + 0.05, top, 12), list[FloatArray]()
    for height in heights:
        lip = FLIP.copy()
        lip[:3, 3] = [0.5, 0.0, height]
        near = states[-1] if states else None
        states.append(model.inverse(lip, "suction", near=near)[0][0])
    arm = SimulatedArm(world, model, np.eye(4), q=states[0])
    assert arm.cup is not None
    arm.extend(arm.cup.stroke)
    arm.follow(Way(np.array(states), 1.0))
    return arm, Way(np.array(states[::-1]), 1.0)


@pytest.fixture
def lifted() -> Iterator[SimulatedArm]:
    """An arm whose cup holds a plate 5 cm above a table."""
    with World() as world:
        arm, up = lowered(world, shapes.plate("plate"))
        assert arm.suck()
        arm.follow(up)
        assert arm.holding
        yield arm


def knobbed(*knobs: tuple[float, float, float]) -> Body:
    """A plate with square knobs, 1 cm wide, on its flat: (x, y, height) of each [m]."""
    plate = shapes.plate("plate")
    base = 0.0065 - 0.001  # the flat, see `shapes.plate`
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
def test_a_cup_seals_on_what_its_lip_bridges_and_no_more(
    knobs: list[tuple[float, float, float]], seals: bool
) -> None:
    with World() as world:
        arm, _ = lowered(world, knobbed(*knobs))
        assert arm.suck() is seals


@pytest.mark.parametrize(("mass", "held"), [(0.4, True), (0.8, False)])
def test_what_hangs_beside_the_cup_bends_it_off(mass: float, held: bool) -> None:
    """A bar held 9 cm beside its middle: 0.8 kg are a fifth of the force, and more than its moment."""
    with World() as world:
        bar = shapes.box("bar", (0.3, 0.06, 0.04), mass=mass)
        arm, up = lowered(world, bar, beside=0.09)
        assert arm.suck() and arm.vacuum is not None
        arm.follow(up)
        arm.wait(0.3)
        assert arm.holding is held
        if held:
            _, moment = arm.vacuum._load()  # pyright: ignore[reportPrivateUsage]
            assert moment == pytest.approx([0.0, 0.09 * mass * 9.81, 0.0], abs=0.01)


def held_under(arm: SimulatedArm, force: FloatArray, twist: float) -> bool:
    """Whether a cup still holds its plate under a force [N] at its lip and a moment [N m] about its axis."""
    world = arm.world
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


@pytest.mark.parametrize(
    ("pull", "shear", "twist", "held"),
    [
        (0.7, 0.0, 0.0, True),
        (1.2, 0.0, 0.0, False),
        (0.0, 0.7, 0.0, True),
        (0.0, 1.2, 0.0, False),
        (0.3, 0.3, 0.0, True),
        (0.8, 0.8, 0.0, False),  # each alone would be held
        (0.0, 0.0, 0.7, True),
        (0.0, 0.0, 1.3, False),  # as far beyond its moment as no force shows
    ],
)
def test_a_cup_holds_up_to_its_force_and_its_moment(
    lifted: SimulatedArm, pull: float, shear: float, twist: float, held: bool
) -> None:
    """Loads in shares of the cup's force, across it and about it of what friction bears of that."""
    assert lifted.cup is not None
    most, rubbed = lifted.cup.max_force, lifted.cup.max_force * lifted.cup.friction
    force = np.array([shear * rubbed, 0.0, -pull * most])
    assert held_under(lifted, force, twist * rubbed * lifted.cup.radius) is held
