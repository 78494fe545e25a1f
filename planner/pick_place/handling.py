"""Collision checks and straight ways around one grasp of one object."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from topple.planner.grasp.grasp import Grasp
from topple.planner.motion.cartesian import straight_lines
from topple.planner.motion.collision import Checker
from topple.planner.motion.model import Attachment
from topple.planner.motion.shortcut import densely
from topple.planner.pick_place.failure import Tally
from topple.planner.place.placement import Placement
from topple.planner.solids import Solids, apart, moved, up_of
from topple.robots.arm import Arm
from topple.robots.gripper import ToolState
from topple.topology.arrays import FloatArray
from topple.topology.scene import Scene

MARGIN = 0.004  # kept to everything on free motions: depth noise and tracking error [m]
MARGINS = (MARGIN, 0.001, 0.0)  # the hand may start nearer to what it just left: then the first that holds
LINE_STEP = 0.01  # [rad] between checked states of straight ways, which pass close by things
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
        riding: What lies in the object and goes with it.
        seed: For inverse kinematics.
    """

    def __init__(
        self,
        name: str,
        scene: Scene,
        bodies: Solids,
        arm: Arm,
        pose_base_to_world: FloatArray,
        riding: tuple[str, ...] = (),
        seed: int = 0,
    ) -> None:
        self.name, self.scene, self.arm, self.riding, self.seed = name, scene, arm, riding, seed
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
        held = self._attached(grasp)
        return self._checker(self.others, self.closed(grasp), attached=held, allow=allow)

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

        The object itself is left out, as its place is not known here; `parting` has it.
        """
        key = ("leave", grasp.tool, self.released(grasp))
        if key not in self._checkers:
            self._checkers[key] = self._checker(self.others, self.released(grasp))
        return self._checkers[key]

    def parting(self, grasp: Grasp, place: Placement) -> Checker:
        """The open hand drawing back, the object at its new place included: what held it may touch it."""
        pose = place.pose_before_to_after
        bodies = {**self.others, **{n: moved(self.bodies[n], pose) for n in (self.name, *self.riding)}}
        allow = _pairs(self._links(grasp), (self.name, *self.riding))
        return self._checker(bodies, self.released(grasp), allow=allow)

    def empty(self, opening: float, q_start: FloatArray) -> Checker:
        """The empty hand among everything, at the largest of `MARGINS` that it keeps at the start."""
        state = ToolState(_rounded(opening, self.arm))
        checkers = (self._checker(self.bodies, state, margin=margin) for margin in MARGINS)
        free = (checker for checker in checkers if checker.free(q_start)[0])
        return next(free, None) or self._checker(self.bodies, state)

    @cached_property
    def others(self) -> dict[str, Sequence[FloatArray]]:
        """The bodies of all but the object and what rides in it."""
        away = (self.name, *self.riding)
        return {other: parts for other, parts in self.bodies.items() if other not in away}

    @cached_property
    def touching(self) -> tuple[str, ...]:
        """The others whose clouds or bodies come within contact distance of the object's."""
        return tuple(
            other for other in self.others if not apart(self.bodies[self.name], self.bodies[other], CONTACT)
        )

    def _attached(self, grasp: Grasp) -> Attachment:
        to_tool: FloatArray = np.linalg.inv(grasp.pose_tool_to_world).astype(np.float64)
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

    # -- what the arm reaches

    def reached(
        self,
        grasps: Sequence[Grasp],
        near: FloatArray,
        lenient: bool,
        tally: Tally,
    ) -> list[Reached]:
        """Joint values for grasps, in their order, each also with the hand turned half.

        Args:
            grasps: In the world.
            near: (n,) joint values solutions should be close to.
            lenient: Whether fingers may enter inferred bodies of neighbours.
            tally: Notes what grasps are dropped for.

        Returns:
            Free states, at most two for each hand direction.
        """
        both = [hand for grasp in grasps for hand in _directions(grasp)]
        solutions = self._inverse(both, [grasp.pose_tool_to_world for grasp in both], near)
        found: list[Reached] = []
        for grasp, states in zip(both, solutions, strict=True):
            if len(states) == 0:
                tally.note("grasp", "reach", "grasp out of reach")
                continue
            checker = self.approaching(grasp, lenient)
            free = checker.free(states)
            if not free.any():
                _blame(tally, checker, states[0], "grasp")
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

    # -- straight ways

    def way_in(self, state: Reached, length: float, tally: Tally) -> FloatArray | None:
        """(k, n) straight from before the object to the grasp, or None where something is in the way."""
        back = np.eye(4)
        back[2, 3] = -length
        checker = self.approaching(state.grasp, state.lenient)
        target = state.grasp.pose_tool_to_world @ back
        path = self._straight(checker, state.q, target, state.grasp.tool, "approach", tally)
        return None if path is None else path[::-1]

    def way_up(self, state: Reached, length: float, tally: Tally) -> FloatArray | None:
        """(k, n) straight up with the object, or None."""
        target = state.grasp.pose_tool_to_world.copy()
        target[:3, 3] += length * self.up
        checker = self.lifting(state.grasp, state.lenient)
        return self._straight(checker, state.q, target, state.grasp.tool, "lift", tally)

    def _straight(
        self, checker: Checker, q: FloatArray, target: FloatArray, tool: str, step: str, tally: Tally
    ) -> FloatArray | None:
        """(k, n) straight from a state to a tool pose in the world; what bars it is noted."""
        path = straight_lines(self.arm, q[None], (self.world_to_base @ target)[None], tool)[0]
        return self._clear(path, checker, q, step, tally)

    def _clear(
        self, path: FloatArray | None, checker: Checker, q: FloatArray, step: str, tally: Tally
    ) -> FloatArray | None:
        """A straight path from a state where nothing bars it; what does is noted."""
        if path is None:
            tally.note(step, "reach", f"no straight {step} within the arm's reach", q)
        elif not checker.edges_free(path[:-1], path[1:], step=LINE_STEP).all():
            states = densely(path, LINE_STEP)
            _blame(tally, checker, states[int(np.argmin(checker.free(states)))], step)
        else:
            return path
        return None

    def ends(
        self,
        state: Reached,
        places: Sequence[Placement],
        near: FloatArray,
        drop: float,
        retreat: float,
        most: int,
        tally: Tally,
    ) -> list[End]:
        """Ways of ending a transfer that are free from above the place until the hand is out.

        Args:
            state: The grasp.
            places: Placements, best first.
            near: (n,) joint values to stay close to.
            drop: Straight way down [m].
            retreat: Straight way out [m].
            most: How many to return.
            tally: Notes what placements are dropped for.

        Returns:
            Up to `most` ends, best placements first.
        """
        grasp = state.grasp
        checker = self.carrying(grasp, 0.0, places[0].into if places else None)
        targets = [place.pose_before_to_after @ grasp.pose_tool_to_world for place in places]
        tried: list[tuple[Placement, FloatArray, FloatArray]] = []
        for place, target, states in zip(
            places, targets, self._inverse([grasp] * len(places), targets, near), strict=True
        ):
            if len(states) == 0:
                tally.note("place", "reach", "place out of reach")
                continue
            free = checker.free(states)
            if not free.any():
                _blame(tally, checker, states[0], "place")
            tried += [(place, target, q) for q in states[free][:2]]
        return self._free_ends(grasp, tried, (drop, retreat), checker, most, tally)

    def _free_ends(
        self,
        grasp: Grasp,
        tried: Sequence[tuple[Placement, FloatArray, FloatArray]],
        ways: tuple[float, float],
        carrying: Checker,
        most: int,
        tally: Tally,
    ) -> list[End]:
        """Of places with tool poses and states there the first `most` with straight ways in and out."""
        if not tried:
            return []
        states, to_base = np.array([q for _, _, q in tried]), self.world_to_base
        above, back = np.array([to_base @ target for _, target, _ in tried]), np.eye(4)
        above[:, :3, 3] += ways[0] * to_base[:3, :3] @ self.up
        back[2, 3] = -ways[1]
        out = np.array([to_base @ target @ back for _, target, _ in tried])
        raised = straight_lines(self.arm, states, above, grasp.tool)
        drawn = straight_lines(self.arm, states, out, grasp.tool)
        found: list[End] = []
        for (place, _, q), rising, leaving in zip(tried, raised, drawn, strict=True):
            if len(found) >= most or any(end.placement is place for end in found):
                continue
            up = self._clear(rising, carrying, q, "place", tally)
            away = None if up is None else self._clear(leaving, self.leaving(grasp), q, "retreat", tally)
            if up is not None and away is not None:
                found.append(End(place, up[::-1], away))
        return found


def _blame(tally: Tally, checker: Checker, q: FloatArray, step: str) -> None:
    """Note who meets whom in a state."""
    pair = checker.witness(q)
    text = f"{step} in collision" if pair is None else f"{step}: {pair[0]} meets {pair[1]}"
    tally.note(step, "collision", text, q, pair)


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
