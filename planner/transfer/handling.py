"""What the arm reaches of one object's grasps and places, and the straight ways there and out."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from topple.planner.failure import Tally
from topple.planner.grasp.grasp import Grasp
from topple.planner.motion.cartesian import straight_lines
from topple.planner.motion.collision import Checker
from topple.planner.motion.shortcut import densely
from topple.planner.placement.placement import Placement
from topple.planner.transfer.checks import Checks
from topple.robots.poses import inverse
from topple.topology.arrays import FloatArray

LINE_STEP = 0.01  # [rad] between checked states of straight ways, which pass close by things
SEEDS = 24  # random starts of inverse kinematics for each pose: finds nearly all that are reachable


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


class Handling(Checks):
    """Everything that is asked about moving one object in one scene."""

    def hands(
        self, grasps: Sequence[Grasp], near: FloatArray, tally: Tally
    ) -> list[tuple[Grasp, FloatArray]]:
        """Hand poses for grasps, in their order, each also turned half, with all joint values that are found.

        Args:
            grasps: In the world.
            near: (n,) joint values solutions should be close to.
            tally: Notes what grasps are dropped for.
        """
        both = [hand for grasp in grasps for hand in _directions(grasp)]
        poses = [grasp.pose_tool_to_world for grasp in both]
        clear = self._clear_of(
            both, poses, [self.approaching(grasp, lenient=True) for grasp in both], "grasp", tally
        )
        both = [grasp for grasp, free in zip(both, clear, strict=True) if free]
        solutions = self._inverse(both, [grasp.pose_tool_to_world for grasp in both], near)
        for states in solutions:
            if len(states) == 0:
                tally.note("grasp", "reach", "grasp out of reach")
        return [(grasp, q) for grasp, q in zip(both, solutions, strict=True) if len(q)]

    def reached(
        self, hands: Sequence[tuple[Grasp, FloatArray]], lenient: bool, tally: Tally
    ) -> list[Reached]:
        """States of hand poses in which the open hand is free.

        Args:
            hands: As `hands` gives them.
            lenient: Whether fingers may enter inferred bodies of neighbours.
            tally: Notes what grasps are dropped for.

        Returns:
            Free states, at most two for each hand pose.
        """
        found: list[Reached] = []
        for grasp, states in hands:
            checker = self.approaching(grasp, lenient)
            free = checker.free(states)
            if not free.any():
                _blame(tally, checker, states[0], "grasp")
            found += [Reached(grasp, q, lenient) for q in states[free][:2]]
        return found

    def _clear_of(
        self,
        grasps: Sequence[Grasp],
        poses_tool_to_world: Sequence[FloatArray],
        checkers: Sequence[Checker],
        step: str,
        tally: Tally,
    ) -> list[bool]:
        """Which hands in tool poses meet nothing, whatever the arm behind them does."""
        clear = [True] * len(grasps)
        for checker in dict.fromkeys(checkers):
            index = [i for i, other in enumerate(checkers) if other is checker]
            flange = [
                self.world_to_base @ poses_tool_to_world[i] @ self._to_flange(grasps[i].tool) for i in index
            ]
            for i, pair in zip(index, checker.hand_meets(np.array(flange)), strict=True):
                if pair is not None:
                    clear[i] = False
                    q = None
                    if tally.further(step, stands=True):  # the one that is told says how the arm would stand
                        states = self._inverse([grasps[i]], [poses_tool_to_world[i]], self.arm.home)[0]
                        q = states[0] if len(states) else None
                    tally.note(step, "collision", f"{step}: {pair[0]} meets {pair[1]}", q, pair)
        return clear

    def _to_flange(self, tool: str) -> FloatArray:
        """(4, 4) pose of the flange in a tool's frame."""
        return inverse(self.arm.tool_to_flange(tool))

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

    def open_ends(
        self, grasp: Grasp, places: Sequence[Placement], drop: float, retreat: float, tally: Tally
    ) -> list[Placement]:
        """Places where the hand is free: with the object there and above, without it there and drawn back.

        Whether the arm gets there is not asked.

        Args:
            grasp: The grasp.
            places: Placements.
            drop: Straight way down [m].
            retreat: Straight way out [m].
            tally: Notes what placements are dropped for.
        """
        into = places[0].into
        carrying, leaving = self.carrying(grasp, 0.0, into), self.leaving(grasp, into)
        found = list(places)
        for checker, step, way in (
            (carrying, "place", 0.0),
            (carrying, "place", drop),
            (leaving, "retreat", 0.0),
            (leaving, "retreat", retreat),
        ):
            above, back = np.eye(4), np.eye(4)
            if checker is carrying:
                above[:3, 3] = way * self.up
            else:
                back[2, 3] = -way
            poses = [above @ p.pose_before_to_after @ grasp.pose_tool_to_world @ back for p in found]
            clear = self._clear_of([grasp] * len(found), poses, [checker] * len(found), step, tally)
            found = [place for place, free in zip(found, clear, strict=True) if free]
        return found

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
            places: Placements, best first, as `open_ends` leaves them.
            near: (n,) joint values to stay close to.
            drop: Straight way down [m].
            retreat: Straight way out [m].
            most: How many to return.
            tally: Notes what placements are dropped for.

        Returns:
            Up to `most` ends, best placements first.
        """
        grasp = state.grasp
        checker = self.carrying(grasp, 0.0, places[0].into)
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
            empty = self.leaving(grasp, place.into)
            away = None if up is None else self._clear(leaving, empty, q, "retreat", tally)
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
