"""What is checked against what while one object is taken, carried and put down."""

from collections.abc import Collection, Iterable, Sequence
from functools import cached_property

import numpy as np

from topple.planner.grasp.grasp import Grasp
from topple.planner.grasp.shape import Shape, shapes_of
from topple.planner.motion.collision import Checker
from topple.planner.motion.model import Attachment
from topple.planner.placement.placement import Placement
from topple.planner.transfer.segments import SegmentKind
from topple.planner.transfer.tolerances import CONTACT
from topple.robots.arm.arm import Station
from topple.robots.arm.gripper import ToolState
from topple.robots.arm.torques import Strain, strain
from topple.robots.collision.fcl_bodies import apart
from topple.robots.poses import inverse
from topple.topology.base.arrays import FloatArray
from topple.topology.bodies.solids import Solids, move_parts
from topple.topology.geometry.rigid import move_points
from topple.topology.geometry.samples import volume_and_centre
from topple.topology.situation.situation import Situation


class Checks:
    """The checkers of one object's way in one scene, each made once.

    Args:
        name: The object.
        situation: Where everything is.
        station: The arm as it stands before.
        riding: What lies in the object and goes with it.
        seed: For inverse kinematics.
        obstacles: Bodies that are in the way and no part of the scene: another arm, as it stands.
    """

    def __init__(
        self,
        name: str,
        situation: Situation,
        station: Station,
        riding: tuple[str, ...] = (),
        seed: int = 0,
        obstacles: Solids | None = None,
    ) -> None:
        self.name, self.arm, self.q_start = name, station.arm, np.asarray(station.q)
        self.riding, self.own, self.seed = riding, (name, *riding), seed
        self.situation, self.scene, self.up = situation, situation.scene, situation.up
        self.bodies: Solids = {**situation.solids, **(obstacles or {})}
        self.pose_base_to_world = np.asarray(station.pose_base_to_world)
        self.world_to_base = np.linalg.inv(self.pose_base_to_world)
        self._checkers: dict[tuple[object, ...], Checker] = {}

    # -- what it weighs

    @cached_property
    def load(self) -> tuple[float, FloatArray]:
        """The mass [kg] of what was weighed of what is carried, and its centre (3,) in the world [m].

        A weight that is guessed is off by a factor of two, so nothing is refused for it.
        """
        masses, known = self.scene.masses, self.scene.centres
        bodies = {name: self.bodies[name] for name in self.own if name in masses}
        if not bodies:
            return 0.0, np.zeros(3)
        centres = [
            known[name] if name in known else volume_and_centre(np.vstack(parts), parts)[1]
            for name, parts in bodies.items()
        ]
        weights = [masses[name] for name in bodies]
        return sum(weights), np.average(centres, axis=0, weights=weights)

    def strain(self, grasp: Grasp, q: FloatArray) -> Strain:
        """Compare the load of the arm and its object with the joints' limits in states (m, n)."""
        mass, centre = self.load
        to_flange = self.arm.tool_to_flange(grasp.tool) @ inverse(self.tool_pose(grasp))
        up = self.world_to_base[:3, :3] @ self.up
        return strain(self.arm, q, up, mass, move_points(centre[None], to_flange)[0])

    # -- how the hand stands

    def hand(self, grasp: Grasp) -> Shape:
        """That of the tool which makes a grasp: it says how it stands on the way in, closed and released."""
        return shapes_of(self.arm)[grasp.tool]

    def tool_pose(self, grasp: Grasp) -> FloatArray:
        """(4, 4) pose of the arm's tool in the world as it makes a grasp."""
        return grasp.pose_of(self.arm.tools[grasp.tool])

    # -- what is checked against what

    def checker(
        self,
        kind: SegmentKind,
        grasp: Grasp,
        place: Placement | None = None,
        *,
        lenient: bool = False,
        margin: float = 0.0,
        placed: bool = True,
    ) -> Checker:
        """Make what a motion is checked against, once for all that are checked alike.

        Args:
            kind: The motion.
            grasp: How the object is held.
            place: Where it goes.
            lenient: Whether fingers that come or lift may enter the inferred bodies of neighbours.
            margin: Least distance from everything [m].
            placed: Whether the object is where a hand leaves it; else it is left out.
        """
        comes, leaves = kind in (SegmentKind.MOVE, SegmentKind.APPROACH), kind is SegmentKind.RETREAT
        into = None if place is None else place.into
        held, at = None if comes or leaves else grasp, place if leaves and placed else into
        state = self._hand_at(kind, grasp, into)
        key = kind, grasp.tool, state, held, at, lenient, margin
        if key not in self._checkers:
            bodies = self.bodies if comes else self.others
            if leaves and placed and place is not None:
                left = {name: move_parts(self.bodies[name], place.pose_before_to_after) for name in self.own}
                bodies = {**bodies, **left}
            self._checkers[key] = Checker(
                self.arm,
                self.pose_base_to_world,
                bodies,
                tool_state=state,
                attached=None if held is None else self._attachment(held),
                allow=self._may_touch(kind, grasp, into, lenient),
                margin=margin,
            )
        return self._checkers[key]

    def _hand_at(self, kind: SegmentKind, grasp: Grasp, into: str | None) -> ToolState:
        """How the hand stands during a motion."""
        hand = self.hand(grasp)
        if kind is SegmentKind.MOVE:
            return self.arm.on_the_way(hand.ready(grasp).opening)
        if kind is SegmentKind.RETREAT:
            return hand.released(grasp, into, self.up)
        return hand.ready(grasp) if kind is SegmentKind.APPROACH else hand.closed(grasp)

    def _may_touch(
        self, kind: SegmentKind, grasp: Grasp, into: str | None, lenient: bool
    ) -> list[frozenset[str]]:
        """Who may touch whom during a motion; nobody where that is not said."""
        links, near = self.hand(grasp).links, self.scene.movable if lenient else ()
        match kind:
            case SegmentKind.APPROACH:
                return _pairs(links, [self.name, *near])
            case SegmentKind.LIFT:  # what the object touches now, off which it comes
                return _pairs([self.name], self.neighbours) + _pairs(links, {*near}.difference(self.own))
            case SegmentKind.PLACE if into is not None:
                return _pairs([self.name], [into])
            case SegmentKind.RETREAT:
                return _pairs(links, self.own)
            case _:
                return []

    @cached_property
    def others(self) -> dict[str, Sequence[FloatArray]]:
        """The bodies of all but the object and what rides in it."""
        return {other: parts for other, parts in self.bodies.items() if other not in self.own}

    @cached_property
    def neighbours(self) -> tuple[str, ...]:
        """The others whose clouds or bodies come within contact distance of the object's."""
        return tuple(
            other
            for other in self.others
            if other in self.scene.clouds  # another arm may not be touched, however near it is
            and not apart(self.bodies[self.name], self.bodies[other], CONTACT)
        )

    def _attachment(self, grasp: Grasp) -> Attachment:
        to_tool: FloatArray = np.linalg.inv(self.tool_pose(grasp)).astype(np.float64)
        parts = [part for name in self.own for part in self.bodies[name]]
        return Attachment(move_parts(parts, to_tool), grasp.tool, self.name)


def _pairs(links: Iterable[str], objects: Collection[str]) -> list[frozenset[str]]:
    return [frozenset((link, name)) for link in links for name in objects]
