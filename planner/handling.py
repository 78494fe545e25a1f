"""Collision checks and straight ways around one grasp of one object."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from topple.planner.grasp.grasp import Grasp
from topple.planner.motion.cartesian import straight_line
from topple.planner.motion.collision import Checker
from topple.planner.motion.model import Attachment
from topple.planner.placement import Placement
from topple.planner.solids import Solids, apart, moved, up_of
from topple.robots.arm import Arm
from topple.robots.gripper import ToolState
from topple.topology.arrays import FloatArray
from topple.topology.scene import Scene

MARGIN = 0.004  # kept to everything on free motions: depth noise and tracking error [m]
OPENING_STEP = 0.005  # openings are rounded up to it, so that grasps share their checks [m]
SEEDS = 24  # random starts of inverse kinematics for each pose: finds nearly all that are reachable
CONTACT = 0.006  # bodies this close touch: noise of two clouds [m]


@dataclass(frozen=True, eq=False)
class Reached:
    """A grasp with joint values that make it.

    Attributes:
        grasp: The grasp.
        q: (n,) joint values [rad].
        lenient: Whether fingers may enter the inferred bodies of neighbours, whose clouds they are clear of.
    """

    grasp: Grasp
    q: FloatArray
    lenient: bool


@dataclass(frozen=True, eq=False)
class End:
    """The last part of a transfer.

    Attributes:
        placement: Where the object goes.
        lower: (k, n) straight way down to it.
        retreat: (m, n) straight way out.
    """

    placement: Placement
    lower: FloatArray
    retreat: FloatArray


class Handling:
    """Everything that is asked about moving one object in one scene.

    Args:
        name: The object.
        scene: The scene.
        bodies: Convex parts of all objects, in the world.
        arm: The arm.
        pose_base_to_world: (4, 4) where it stands.
        seed: For inverse kinematics.
    """

    def __init__(
        self,
        name: str,
        scene: Scene,
        bodies: Solids,
        arm: Arm,
        pose_base_to_world: FloatArray,
        seed: int = 0,
    ) -> None:
        self.name, self.scene, self.arm, self.seed = name, scene, arm, seed
        self.bodies, self.up = bodies, up_of(scene)
        self.pose_base_to_world = pose_base_to_world
        self.world_to_base = np.linalg.inv(pose_base_to_world)
        self._checkers: dict[tuple[object, ...], Checker] = {}

    # -- how the hand stands

    def ready(self, grasp: Grasp) -> ToolState:
        """On the way in."""
        if grasp.tool == "suction":
            return self.arm.tools["suction"].ready
        return ToolState(_rounded(grasp.opening, self.arm))

    def closed(self, grasp: Grasp) -> ToolState:
        """With the object."""
        return self.ready(grasp) if grasp.tool == "suction" else ToolState(grasp.width)

    def released(self, grasp: Grasp) -> ToolState:
        """After letting go: wide open, so that the object stays where it is when the hand leaves."""
        return self.ready(grasp) if grasp.tool == "suction" else self.arm.open_hand

    # -- what is checked against what

    def _links(self, grasp: Grasp) -> tuple[str, ...]:
        """Links that may be next to the object: what holds it, and the fingers that stand open around a cup.

        The search for suction kept the open hand clear of the object's cloud; the hulls drawn around the
        cloud bridge its hollows, a plate's for one, and would bar it.
        """
        links = self.arm.tools[grasp.tool].links
        if grasp.tool == "suction" and self.arm.jaw is not None:
            return (*links, *self.arm.jaw.links)
        return links

    def approaching(self, grasp: Grasp, lenient: bool) -> Checker:
        """The open hand around the object: what holds may touch it."""
        key = ("approach", grasp.tool, self.ready(grasp), lenient)
        if key not in self._checkers:
            others = [other for other in self.scene.movable if other != self.name] if lenient else []
            allow = _pairs(self._links(grasp), [self.name, *others])
            self._checkers[key] = self._checker(self.bodies, self.ready(grasp), allow=allow)
        return self._checkers[key]

    def lifting(self, grasp: Grasp, lenient: bool) -> Checker:
        """The object leaving what it stood on or against: what it touches now it may touch."""
        allow = _pairs([self.name], self.touching)
        if lenient:
            allow += _pairs(self._links(grasp), [o for o in self.others if o not in self.scene.fixed])
        return self._checker(self.others, self.closed(grasp), attached=self._attached(grasp), allow=allow)

    def carrying(self, grasp: Grasp, margin: float, into: str | None = None) -> Checker:
        """The object in the hand, everything else in the way at a margin, but for what it is put into."""
        return self._checker(
            self.others,
            self.closed(grasp),
            attached=self._attached(grasp),
            allow=[] if into is None else _pairs([self.name], [into]),
            margin=margin,
        )

    def leaving(self, grasp: Grasp) -> Checker:
        """The open hand drawing back from the object at its new place.

        The object itself is left out: hand and object part as they met, which was checked there.
        """
        key = ("leave", grasp.tool, self.released(grasp))
        if key not in self._checkers:
            self._checkers[key] = self._checker(self.others, self.released(grasp))
        return self._checkers[key]

    def empty(self, opening: float, q_start: FloatArray) -> Checker:
        """The empty hand among everything."""
        state = ToolState(_rounded(opening, self.arm))
        checker = self._checker(self.bodies, state, margin=MARGIN)
        if checker.free(q_start)[0]:
            return checker
        # the last action may have left the hand closer than the margin: what it is next to now it may leave
        near = [frozenset((contact.a, contact.b)) for contact in checker.contacts(q_start)]
        return self._checker(self.bodies, state, allow=near, margin=MARGIN)

    @cached_property
    def others(self) -> dict[str, Sequence[FloatArray]]:
        """The bodies of all but the object."""
        return {other: parts for other, parts in self.bodies.items() if other != self.name}

    @cached_property
    def touching(self) -> tuple[str, ...]:
        """The others whose clouds or bodies come within contact distance of the object's."""
        return tuple(
            other
            for other in self.bodies
            if other != self.name and not apart(self.bodies[self.name], self.bodies[other], CONTACT)
        )

    def _attached(self, grasp: Grasp) -> Attachment:
        to_tool: FloatArray = np.linalg.inv(grasp.pose_tool_to_world).astype(np.float64)
        return Attachment(moved(self.bodies[self.name], to_tool), grasp.tool, self.name)

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

    # -- what the arm reaches

    def reached(
        self,
        grasps: Sequence[Grasp],
        near: FloatArray,
        lenient: bool,
        reasons: Counter[str],
        witnesses: Counter[str],
    ) -> list[Reached]:
        """Joint values for grasps, in their order, each also with the hand turned half.

        Args:
            grasps: In the world.
            near: (n,) joint values solutions should be close to.
            lenient: Whether fingers may enter inferred bodies of neighbours.
            reasons: Counts what grasps are dropped for.
            witnesses: Counts what stands in the way.

        Returns:
            Free states, at most two for each hand direction.
        """
        both = [hand for grasp in grasps for hand in _directions(grasp)]
        solutions = self._inverse(both, [grasp.pose_tool_to_world for grasp in both], near)
        found: list[Reached] = []
        for grasp, states in zip(both, solutions, strict=True):
            if len(states) == 0:
                reasons["grasp out of reach"] += 1
                continue
            checker = self.approaching(grasp, lenient)
            free = checker.free(states)
            if not free.any():
                reasons[self._blame(checker, states[0], "grasp", witnesses)] += 1
            found += [Reached(grasp, q, lenient) for q in states[free][:2]]
        return found

    def _inverse(
        self, grasps: Sequence[Grasp], poses_tool_to_world: Sequence[FloatArray], near: FloatArray
    ) -> list[FloatArray]:
        """Joint values for tool poses, grasp by grasp; one batch for each tool."""
        found: list[FloatArray] = [np.empty((0, len(self.arm.joints)))] * len(grasps)
        for tool in self.arm.tools:
            index = [i for i, grasp in enumerate(grasps) if grasp.tool == tool]
            if index:
                poses = self.world_to_base @ np.array([poses_tool_to_world[i] for i in index])
                rng = np.random.default_rng(self.seed)
                for i, states in zip(
                    index, self.arm.inverse(poses, tool, seeds=SEEDS, rng=rng, near=near), strict=True
                ):
                    found[i] = states
        return found

    def _blame(self, checker: Checker, q: FloatArray, what: str, witnesses: Counter[str]) -> str:
        witness = checker.witness(q)
        if witness is None:
            return f"{what} in collision"
        other = next((name for name in witness if name in self.bodies and name != self.name), None)
        if other is not None:
            witnesses[other] += 1
        return f"{what}: {witness[0]} meets {witness[1]}"

    # -- straight ways

    def way_in(self, state: Reached, length: float) -> FloatArray | None:
        """(k, n) straight from before the object to the grasp, or None where something is in the way."""
        back = np.eye(4)
        back[2, 3] = -length
        target = self.world_to_base @ state.grasp.pose_tool_to_world @ back
        checker = self.approaching(state.grasp, state.lenient)
        path = straight_line(self.arm, checker, state.q, target, state.grasp.tool)
        return None if path is None else path[::-1]

    def way_up(self, state: Reached, length: float) -> FloatArray | None:
        """(k, n) straight up with the object, or None."""
        target = state.grasp.pose_tool_to_world.copy()
        target[:3, 3] += length * self.up
        checker = self.lifting(state.grasp, state.lenient)
        return straight_line(self.arm, checker, state.q, self.world_to_base @ target, state.grasp.tool)

    def ends(
        self,
        state: Reached,
        places: Sequence[Placement],
        near: FloatArray,
        drop: float,
        retreat: float,
        most: int,
        reasons: Counter[str],
        witnesses: Counter[str],
    ) -> list[End]:
        """Ways of ending a transfer that are free from above the place until the hand is out.

        Args:
            state: The grasp.
            places: Placements, best first.
            near: (n,) joint values to stay close to.
            drop: Straight way down [m].
            retreat: Straight way out [m].
            most: How many to return.
            reasons: Counts what placements are dropped for.
            witnesses: Counts what stands in the way.

        Returns:
            Up to `most` ends, best placements first.
        """
        grasp, found = state.grasp, list[End]()
        checker = self.carrying(grasp, 0.0, places[0].into if places else None)
        targets = [place.pose_before_to_after @ grasp.pose_tool_to_world for place in places]
        for place, target, states in zip(
            places, targets, self._inverse([grasp] * len(places), targets, near), strict=True
        ):
            if len(states) == 0:
                reasons["place out of reach"] += 1
                continue
            free = checker.free(states)
            if not free.any():
                reasons[self._blame(checker, states[0], "place", witnesses)] += 1
            for q in states[free][:2]:
                end = self._end(grasp, place, target, q, drop, retreat, checker)
                if end is not None:
                    found.append(end)
                    break
            if len(found) >= most:
                break
        return found

    def _end(
        self,
        grasp: Grasp,
        place: Placement,
        target: FloatArray,
        q: FloatArray,
        drop: float,
        retreat: float,
        carrying: Checker,
    ) -> End | None:
        above, back = target.copy(), np.eye(4)
        above[:3, 3] += drop * self.up
        back[2, 3] = -retreat
        raised = straight_line(self.arm, carrying, q, self.world_to_base @ above, grasp.tool)
        if raised is None:
            return None
        out = straight_line(self.arm, self.leaving(grasp), q, self.world_to_base @ target @ back, grasp.tool)
        return None if out is None else End(place, raised[::-1], out)


def _directions(grasp: Grasp) -> list[Grasp]:
    """A grasp's hand directions: a jaw turned half is the same, a round cup may be turned at will."""
    if grasp.tool == "fingers":
        return [grasp, grasp.turned()]
    quarter = np.array(
        [[0.0, -1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]]
    )
    across = replace(grasp, pose_tool_to_world=grasp.pose_tool_to_world @ quarter)
    return [grasp, grasp.turned(), across, across.turned()]


def _rounded(opening: float, arm: Arm) -> float:
    largest = arm.jaw.max_opening if arm.jaw else 0.0
    return min(largest, float(np.ceil(opening / OPENING_STEP - 1e-9)) * OPENING_STEP)


def _pairs(links: Sequence[str], objects: Sequence[str]) -> list[frozenset[str]]:
    return [frozenset((link, name)) for link in links for name in objects]
