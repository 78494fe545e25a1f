"""The proof of a placement: what is let go there stays there, among everything else as it then stands.

The planner asks it of a place before it plans a way there; the check of a finished plan asks it again, of the
numbers the plan was written with.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from topple.planner.decide.goal import PlaceRelation
from topple.planner.placement.away import BODIES, IN_HAND, Away
from topple.planner.placement.placement import Placement
from topple.planner.placement.tolerances import PROOF_SPARE, SHIFT, TURN
from topple.planner.simulate.sandbox import Sandbox
from topple.robots.engines import INSTALLED
from topple.robots.poses import angle_between
from topple.topology.base.arrays import FloatArray
from topple.topology.bodies.solids import Solids
from topple.topology.geometry.axes import level_axes
from topple.topology.geometry.sides import inset
from topple.topology.situation.situation import Situation


@dataclass(frozen=True)
class Settled:
    """How an object ends that is let go.

    Attributes:
        shift: How far its centre of mass gets from where it was meant to be [m].
        turn: By how much it turns [rad].
        outside: How far its centre is beside or below what it was put into [m]; None where it was put into
            nothing. What is put into a container may roll there.
    """

    shift: float
    turn: float
    outside: float | None = None

    def within(self, share: float = 1.0) -> bool:
        """Whether it stays, by a share of what is allowed."""
        if self.outside is not None:
            return self.outside <= 0.0
        return self.shift <= share * SHIFT and self.turn <= share * TURN

    def __str__(self) -> str:
        """In words."""
        if self.outside is not None:
            return f"it would leave its container by {1e3 * self.outside:.0f} mm"
        return f"it would move by {1e3 * self.shift:.0f} mm and turn by {np.degrees(self.turn):.0f} deg"


class Proof:
    """Lets an object go at one place after the other.

    On a table it is asked with the hidden sides, which it may have to stand on; on or in another
    thing it was lowered by what was seen of both, and is asked by that.

    Args:
        name: The object.
        situation: Where it is now.
        riding: What lies in the object and goes with it.
        beside: Bodies that are no part of the scene, by name.
        sandbox: The world to do it in; one of its own where None.
    """

    def __init__(
        self,
        name: str,
        situation: Situation,
        riding: tuple[str, ...] = (),
        beside: Solids | None = None,
        sandbox: Sandbox | None = None,
    ) -> None:
        self.name, self._up, bodies = name, situation.up, situation.solids
        staying = {other: parts for other, parts in bodies.items() if other not in riding}
        there: Solids = {**staying, **(beside or {})}
        self._bodies = {False: there, True: {**there, name: situation.completed[name]}}
        self._sandbox, self._known = sandbox or Sandbox(), dict[Placement, Settled]()

    def settle(self, place: Placement) -> Settled:
        """How the object ends that is let go at a place; each place is tried once."""
        if place not in self._known:
            bodies, up = self._bodies[place.into is None and place.how != Away.BIN], self._up
            if self._sandbox.bodies is not bodies:
                self._sandbox.fill(self.name, bodies, up)
            container, meant = container_of(place.how, place.into), place.pose_at_rest(up)
            around = None if container is None else bodies[container]
            self._known[place] = settle(self._sandbox, place.pose_before_to_after, meant, around, up)
        return self._known[place]

    def holds(self, place: Placement) -> bool:
        """Whether the object stays where a place has it, with some to spare; unasked without an engine."""
        if place.how in IN_HAND:
            return True
        return not place.falls and (not INSTALLED or self.settle(place).within(PROOF_SPARE))


def container_of(how: str | None, into: str | None) -> str | None:
    """Name the container an object is put into, where it may roll; None where it is put onto something."""
    return into if how == PlaceRelation.WITHIN else BODIES[Away.BIN] if how == Away.BIN else None


def settle(
    sandbox: Sandbox,
    pose_before_to_release: FloatArray,
    pose_before_to_meant: FloatArray,
    container: Sequence[FloatArray] | None,
    up: FloatArray,
) -> Settled:
    """Let an object go.

    Args:
        sandbox: The world with the object.
        pose_before_to_release: (4, 4) rigid transform in the world to where it is let go.
        pose_before_to_meant: (4, 4) to where it is meant to rest.
        container: Convex parts of what it is put into; None where it is put onto something.
        up: (3,) unit vector.

    Returns:
        How it ends.
    """
    rest = sandbox.release(pose_before_to_release)
    place = (rest @ np.append(sandbox.body.centre_of_mass, 1.0))[:3]
    outside = None if container is None else _beyond(place, np.vstack(container), up)
    way, turn = sandbox.way(rest, pose_before_to_meant), angle_between(pose_before_to_meant, rest)
    return Settled(way, turn, outside)


def _beyond(place: FloatArray, points: FloatArray, up: FloatArray) -> float:
    """How far a place (3,) is beside the level outline of points, or below them [m]."""
    axes = np.stack(level_axes(up))
    aside = -float(inset(points @ axes.T, (place @ axes.T)[None])[0])
    below = float((points @ up).min() - place @ up)
    return max(0.0, aside, below)
