"""What is checked against what while one object is taken, carried and put down."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from topple.planner.grasp.grasp import Grasp
from topple.planner.grasp.jaw import stepped
from topple.planner.grasp.shape import Shape, shapes_of
from topple.planner.motion.collision import Checker
from topple.planner.motion.model import Attachment
from topple.planner.placement.placement import Placement
from topple.planner.transfer.tolerances import CONTACT
from topple.robots.arm.arm import Arm
from topple.robots.arm.gripper import ToolState
from topple.robots.arm.torques import Strain, strain
from topple.robots.collision.fcl_bodies import apart
from topple.robots.poses import inverse
from topple.topology.base.arrays import FloatArray
from topple.topology.bodies.solids import Solids, moved
from topple.topology.geometry.rigid import transformed
from topple.topology.geometry.samples import volume_and_centre
from topple.topology.situation.situation import Situation


@dataclass(frozen=True, eq=False)
class Station:
    """An arm as it stands.

    Attributes:
        arm: The arm.
        pose_base_to_world: (4, 4) where it stands.
        q: (n,) its joint values [rad].
    """

    arm: Arm
    pose_base_to_world: FloatArray
    q: FloatArray


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
        self.riding, self.seed = riding, seed
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
        bodies = {name: self.bodies[name] for name in (self.name, *self.riding) if name in masses}
        if not bodies:
            return 0.0, np.zeros(3)
        centres = [
            known[name] if name in known else volume_and_centre(np.vstack(parts), parts)[1]
            for name, parts in bodies.items()
        ]
        weights = [masses[name] for name in bodies]
        return sum(weights), np.average(centres, axis=0, weights=weights)

    def strain(self, grasp: Grasp, q: FloatArray) -> Strain:
        """What the arm and what it carries ask of the joints in states (m, n)."""
        mass, centre = self.load
        to_flange = self.arm.tool_to_flange(grasp.tool) @ inverse(self.tool_pose(grasp))
        up = self.world_to_base[:3, :3] @ self.up
        return strain(self.arm, q, up, mass, transformed(centre[None], to_flange)[0])

    # -- how the hand stands

    def hand(self, grasp: Grasp) -> Shape:
        """That of the tool which makes a grasp: it says how it stands on the way in, closed and released."""
        return shapes_of(self.arm)[grasp.tool]

    def tool_pose(self, grasp: Grasp) -> FloatArray:
        """(4, 4) pose of the arm's tool in the world as it makes a grasp."""
        return grasp.pose_of(self.arm.tools[grasp.tool])

    # -- what is checked against what

    def approaching(self, grasp: Grasp, lenient: bool) -> Checker:
        """The open hand around the object: what holds may touch it."""
        key = ("approach", grasp.tool, self.hand(grasp).ready(grasp), lenient)
        if key not in self._checkers:
            others = [other for other in self.scene.movable if other != self.name] if lenient else []
            allow = _pairs(self.hand(grasp).links, [self.name, *others])
            self._checkers[key] = self._checker(self.bodies, self.hand(grasp).ready(grasp), allow=allow)
        return self._checkers[key]

    def lifting(self, grasp: Grasp, lenient: bool) -> Checker:
        """The object leaving what it stood on or against: what it touches now it may touch."""
        allow = _pairs([self.name], self.touching)
        if lenient:
            allow += _pairs(self.hand(grasp).links, [o for o in self.others if o in self.scene.movable])
        held = self._attached(grasp)
        return self._checker(self.others, self.hand(grasp).closed(grasp), attached=held, allow=allow)

    def carrying(self, grasp: Grasp, margin: float, into: str | None = None) -> Checker:
        """The object in the hand, everything else in the way at a margin, but for what it is put into."""
        key = ("carry", grasp, margin, into)
        if key not in self._checkers:
            self._checkers[key] = self._checker(
                self.others,
                self.hand(grasp).closed(grasp),
                attached=self._attached(grasp),
                allow=[] if into is None else _pairs([self.name], [into]),
                margin=margin,
            )
        return self._checkers[key]

    def leaving(self, grasp: Grasp, into: str | None = None) -> Checker:
        """The open hand drawing back from the object at its new place.

        The object itself is left out, as its place is not known here; `parting` has it.
        """
        state = self.hand(grasp).released(grasp, into, self.up)
        key = ("leave", grasp.tool, state)
        if key not in self._checkers:
            self._checkers[key] = self._checker(self.others, state)
        return self._checkers[key]

    def parting(self, grasp: Grasp, place: Placement) -> Checker:
        """The open hand drawing back, the object at its new place included: what held it may touch it."""
        pose = place.pose_before_to_after
        bodies = {**self.others, **{n: moved(self.bodies[n], pose) for n in (self.name, *self.riding)}}
        allow = _pairs(self.hand(grasp).links, (self.name, *self.riding))
        return self._checker(bodies, self.hand(grasp).released(grasp, place.into, self.up), allow=allow)

    def empty(self, opening: float) -> Checker:
        """The empty hand among everything; it may start near what it just left, so no margin is asked for."""
        opening = min(self.arm.hand_limits.opening, stepped(opening))
        return self._checker(self.bodies, self.arm.on_the_way(opening))

    @cached_property
    def others(self) -> dict[str, Sequence[FloatArray]]:
        """The bodies of all but the object and what rides in it."""
        away = (self.name, *self.riding)
        return {other: parts for other, parts in self.bodies.items() if other not in away}

    @cached_property
    def touching(self) -> tuple[str, ...]:
        """The others whose clouds or bodies come within contact distance of the object's."""
        return tuple(
            other
            for other in self.others
            if other in self.scene.clouds  # another arm may not be touched, however near it is
            and not apart(self.bodies[self.name], self.bodies[other], CONTACT)
        )

    def _attached(self, grasp: Grasp) -> Attachment:
        to_tool: FloatArray = np.linalg.inv(self.tool_pose(grasp)).astype(np.float64)
        parts = [part for name in (self.name, *self.riding) for part in self.bodies[name]]
        return Attachment(moved(parts, to_tool), grasp.tool, self.name)

    def _checker(
        self,
        bodies: Solids,
        state: ToolState,
        *,
        attached: Attachment | None = None,
        allow: Sequence[frozenset[str]] = (),
        margin: float = 0.0,
    ) -> Checker:
        return Checker(
            self.arm,
            self.pose_base_to_world,
            bodies,
            tool_state=state,
            attached=attached,
            allow=allow,
            margin=margin,
        )


def _pairs(links: Sequence[str], objects: Sequence[str]) -> list[frozenset[str]]:
    return [frozenset((link, name)) for link in links for name in objects]
