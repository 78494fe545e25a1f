"""A suction cup on a body on a table, on either engine, and the loads that it is to hold or not."""

import numpy as np
from moving import Way, at, down

from topple.robots.catalog import robot
from topple.robots.engines import arm_in
from topple.robots.world.acting_arm import ActingArm
from topple.robots.world.bodies import Body
from topple.robots.world.physical_world import PhysicalWorld
from topple.topology.base.arrays import FloatArray

FLAT = 0.0065  # [m] height of a plate's inside, see `shapes.plate`
RAMP = 30  # steps until a load is whole: a load put on at once would be a knock
LOADS = [
    (0.7, 0.0, 0.0, True),
    (1.2, 0.0, 0.0, False),
    (0.0, 0.7, 0.0, True),
    (0.0, 1.2, 0.0, False),
    (0.3, 0.3, 0.0, True),
    (0.8, 0.8, 0.0, False),  # each alone would be held
    (0.0, 0.0, 0.7, True),
    (0.0, 0.0, 1.3, False),  # as far beyond its moment as no force shows
]  # pull, shear and twist in shares of the cup's force and of what friction bears of it, and whether it holds


def lowered(world: PhysicalWorld, body: Body, top: float, beside: float = 0.0) -> tuple[ActingArm, Way]:
    """An arm whose cup is on a body, `top` [m] over a table, and the way back up, 5 cm.

    The cup is so far beside the body's origin [m].
    """
    world.add_table(size=(1.6, 1.4))
    world.add(body, at(0.5 + beside, 0.0, 0.0))
    world.settle()
    arm = arm_in(world, robot("panda-suction"), np.eye(4))
    states = list[FloatArray]()
    for height in np.linspace(top + 0.05, top, 12):
        near = states[-1] if states else None
        states.append(arm.arm.inverse(down(0.5, 0.0, height), "suction", near=near)[0][0])
    arm.follow(Way.between(arm.q_target, states[0], 3.0))
    assert arm.cup is not None
    arm.extend(arm.cup.stroke)
    arm.follow(Way(np.array(states), 1.0))
    return arm, Way(np.array(states[::-1]), 1.0)


def loaded(arm: ActingArm, pull: float, shear: float, twist: float) -> tuple[FloatArray, float]:
    """A force (3,) [N] at a lip and a moment [N m] about its axis, from shares as in `LOADS`."""
    cup = arm.cup
    assert cup is not None
    rubbed = cup.max_force * cup.friction
    return np.array([shear * rubbed, 0.0, -pull * cup.max_force]), twist * rubbed * cup.radius
