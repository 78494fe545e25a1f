"""Where a thing comes to lie that an arm pushes along a table: the push, played in simulation beforehand."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from topple.planner.placement.drops import levelling
from topple.planner.placement.tolerances import SECONDS
from topple.planner.tolerances import DISTURBED, TURNED
from topple.robots.arm.arm import Arm
from topple.robots.driver import Motion
from topple.robots.engines import arm_in, rehearsal_world
from topple.robots.poses import angle_between, inverse
from topple.topology.arrays import FloatArray
from topple.topology.bodies.solids import Solids


@dataclass(frozen=True)
class Pushed:
    """How a push ends.

    Attributes:
        shift: How far the thing's centre of mass gets from where it was meant to be [m].
        turn: By how much it is turned against how it was meant to lie [rad].
        others: Of what else can move, how much it was disturbed at most: 1 is as much as counts.
        disturbed: Its name; "" where nothing else can move.
    """

    shift: float
    turn: float
    others: float = 0.0
    disturbed: str = ""

    def within(self, share: float = 1.0) -> bool:
        """Whether the thing lies where it should and nothing else moved, by a share of what is allowed."""
        return self.shift <= share * DISTURBED and self.turn <= share * TURNED and self.others <= share


def pushed(
    name: str,
    bodies: Solids,
    fixed: Collection[str],
    arm: Arm,
    pose_base_to_world: FloatArray,
    motions: Sequence[Motion],
    opening: float,
    pose_before_to_meant: FloatArray,
    up: FloatArray,
    masses: Mapping[str, float] | None = None,
    friction: Mapping[str, float] | None = None,
) -> Pushed:
    """Push a thing in a world of its own, by contact and friction alone.

    Args:
        name: The thing.
        bodies: Convex parts of all objects in the world [m], each where it is before the push.
        fixed: Those that never move.
        arm: The arm.
        pose_base_to_world: (4, 4) where it stands.
        motions: What it drives, one after the other, from beside the thing until the hand is back.
        opening: Distance of its pads [m].
        pose_before_to_meant: (4, 4) rigid transform in the world to where the thing is meant to lie.
        up: (3,) unit vector.
        masses: In [kg], of what was weighed.
        friction: Coefficients of surfaces that were tried.

    Returns:
        How it ends once everything is at rest again.
    """
    from topple.robots.world.bodies import Body
    from topple.robots.world.tolerances import FRICTION, TABLE_FRICTION

    level, known, rough = levelling(up), masses or {}, friction or {}
    with rehearsal_world() as world:
        for other, parts in bodies.items():
            usual = TABLE_FRICTION if other in fixed else FRICTION
            body = Body.of(other, parts, mass=known.get(other), friction=rough.get(other, usual))
            world.add(body, level, fixed=other in fixed)
        world.settle(SECONDS)
        before = world.poses()
        robot = arm_in(world, arm, level @ pose_base_to_world, q=motions[0].positions[0])
        robot.open(opening)
        for motion in motions:
            robot.follow(motion)
        robot.wait(SECONDS)
        after = world.poses()
        centre = np.append(world.body(name).centre_of_mass, 1.0)
    meant = level @ pose_before_to_meant @ inverse(level) @ before[name]  # from where it had come to rest
    shift = float(np.linalg.norm(((after[name] - meant) @ centre)[:3]))
    worst = max(
        (
            (max(float(np.linalg.norm((after[o] - before[o])[:3, 3])) / DISTURBED,
                 angle_between(before[o], after[o]) / TURNED), o)
            for o in bodies if o != name and o not in fixed
        ),
        default=(0.0, ""),
    )  # fmt: skip
    return Pushed(shift, angle_between(meant, after[name]), *worst)
