"""One pick and place: grasps, inverse kinematics and placements screened together, then the motions."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from topple.planner.grasp.candidates import grasp_candidates
from topple.planner.grasp.grasp import Grasp
from topple.planner.grasp.hand import hand_shape
from topple.planner.handling import MARGIN, Handling, Reached
from topple.planner.motion.planner import MotionFailure, plan_motion
from topple.planner.motion.trajectory import retime
from topple.planner.placement import Placement, placements
from topple.planner.segments import Segment, no_faster_than
from topple.planner.solids import Solids, moved, solids_of, up_of
from topple.robots.arm import Arm
from topple.robots.gripper import ToolState
from topple.topology.arrays import FloatArray, frozen
from topple.topology.errors import UnknownObject
from topple.topology.scene import Scene


@dataclass(frozen=True)
class TransferLimits:
    """How hard to look, and how fast to move.

    Attributes:
        grasps: Best grasps to ask inverse kinematics for; each is tried with the hand turned half as well.
        reached: Reachable grasp states to follow up.
        goals: Placements a motion is planned to at once.
        approach: Straight way in before the grasp [m].
        lift: Straight way up after it [m].
        drop: Straight way down before the release [m].
        retreat: Straight way out after it [m].
        straight_speed: Of the tool on straight ways [m/s]: lifts at it are known to disturb little.
        speed: Share of the joints' velocity limits for the other motions.
        budget: Seconds for one free motion.
    """

    grasps: int = 24
    reached: int = 12
    goals: int = 4
    approach: float = 0.08
    lift: float = 0.10
    drop: float = 0.06
    retreat: float = 0.08
    straight_speed: float = 0.08
    speed: float = 0.5
    budget: float = 2.0


TRANSFER_LIMITS = TransferLimits()


@dataclass(frozen=True, eq=False)
class Transfer:
    """A pick and place that was found free of collisions.

    Attributes:
        object: What is moved.
        grasp: How it is held.
        placement: Where it goes.
        segments: What the arm does, in order.
        q_end: (n,) joint values afterwards [rad].
        tried: What was dropped on the way here, with counts.
    """

    object: str
    grasp: Grasp
    placement: Placement
    segments: tuple[Segment, ...]
    q_end: FloatArray
    tried: Mapping[str, int]

    def __post_init__(self) -> None:
        object.__setattr__(self, "q_end", frozen(self.q_end))

    @property
    def seconds(self) -> float:
        """Duration of the motions [s]."""
        return sum(float(s.trajectory.times[-1]) for s in self.segments if s.trajectory is not None)


@dataclass(frozen=True, eq=False)
class TransferFailure:
    """Why an object could not be moved: the certificate.

    Attributes:
        object: What should have been moved.
        reasons: What each tried grasp or placement failed of, with counts.
        blocking: The object that stood in the way most often, or None.
    """

    object: str
    reasons: Mapping[str, int]
    blocking: str | None

    def __str__(self) -> str:
        """One line for people."""
        why = (
            "; ".join(f"{count} x {reason}" for reason, count in self.reasons.items()) or "nothing was tried"
        )
        return f"cannot move {self.object}: {why}" + (
            f" (in the way: {self.blocking})" if self.blocking else ""
        )


def plan_transfer(
    name: str,
    scene: Scene,
    bodies: Solids | None,
    arm: Arm,
    pose_base_to_world: FloatArray,
    q_start: FloatArray,
    places: Sequence[Placement] | None = None,
    *,
    grasps: Sequence[Grasp] | None = None,
    hand: ToolState | None = None,
    avoid: Sequence[Grasp] = (),
    seed: int = 0,
    limits: TransferLimits = TRANSFER_LIMITS,
) -> Transfer | TransferFailure:
    """Plan taking one object and putting it somewhere else.

    Args:
        name: The object.
        scene: What is seen now, with `up`.
        bodies: Convex parts of every object in the world; made from the scene where None.
        arm: The arm.
        pose_base_to_world: (4, 4) where it stands.
        q_start: (n,) joint values now [rad].
        places: Where it may go, best first; free places on the table where None.
        grasps: How it may be held, best first; found from the clouds where None.
        hand: How the hand stands now; open with the cup drawn in where None.
        avoid: Grasps that failed: none near them is tried while there are others.
        seed: For inverse kinematics and sampling planners.
        limits: How hard to look and how fast to move.

    Returns:
        The transfer, or why there is none. Deterministic for one seed while no planner runs out of budget.

    Raises:
        UnknownObject: The scene has no such object.
    """
    if name not in scene.clouds:
        raise UnknownObject(name, scene.names)
    bodies = solids_of(scene) if bodies is None else bodies
    searched = grasps is None
    if grasps is None:
        grasps = _others(grasp_candidates(name, scene, arm, solids=bodies), avoid)
    if places is None:
        places = placements(name, scene, bodies, pose_base_to_world=pose_base_to_world)
    if not grasps:
        return TransferFailure(name, {"no grasp that holds and has room": 1}, None)
    if not places:
        return TransferFailure(name, {"no free place within reach": 1}, None)
    handling = Handling(name, scene, bodies, arm, np.asarray(pose_base_to_world), seed)
    search = _Search(handling, tuple(places), np.asarray(q_start), hand or arm.open_hand, seed, limits)
    found = search.run(grasps)
    by_cup_alone = searched and all(grasp.tool == "suction" for grasp in grasps) and "fingers" in arm.tools
    if isinstance(found, TransferFailure) and by_cup_alone:
        pinches = grasp_candidates(name, scene, hand=hand_shape(arm), solids=bodies)
        return search.run(_others(pinches, avoid))
    return found


def _others(grasps: list[Grasp], avoid: Sequence[Grasp]) -> list[Grasp]:
    """The grasps that are not near any of those to avoid; all of them where that leaves none."""
    return [grasp for grasp in grasps if not any(grasp.near(other) for other in avoid)] or grasps


class _Search:
    """The state of one search: what was tried and what it failed of."""

    def __init__(
        self,
        handling: Handling,
        places: tuple[Placement, ...],
        q_start: FloatArray,
        hand: ToolState,
        seed: int,
        limits: TransferLimits,
    ) -> None:
        self.handling, self.places, self.q_start, self.hand = handling, places, q_start, hand
        self.seed, self.limits = seed, limits
        self.reasons: Counter[str] = Counter()
        self.witnesses: Counter[str] = Counter()

    def run(self, grasps: Sequence[Grasp]) -> Transfer | TransferFailure:
        for lenient in (False, True):
            reached = self.handling.reached(
                grasps[: self.limits.grasps], self.q_start, lenient, self.reasons, self.witnesses
            )
            for state in reached[: self.limits.reached]:
                transfer = self._with(state)
                if transfer is not None:
                    return transfer
        blocking = self.witnesses.most_common(1)
        return TransferFailure(
            self.handling.name, dict(self.reasons.most_common()), blocking[0][0] if blocking else None
        )

    def _with(self, state: Reached) -> Transfer | None:
        """Complete a transfer that starts with one reachable grasp."""
        approach = self.handling.way_in(state, self.limits.approach)
        if approach is None:
            return self._drop("no straight way in")
        lift = self.handling.way_up(state, self.limits.lift)
        if lift is None:
            return self._drop("no straight way up")
        ends = self.handling.ends(
            state, self.places, lift[-1], self.limits.drop, self.limits.retreat, self.limits.goals,
            self.reasons, self.witnesses,
        )  # fmt: skip
        if not ends:
            return self._drop("no placement this grasp reaches")
        carry = plan_motion(
            self.handling.carrying(state.grasp, MARGIN),
            lift[-1],
            np.array([end.lower[0] for end in ends]),
            seed=self.seed,
            budget=self.limits.budget,
        )
        if isinstance(carry, MotionFailure):
            return self._drop("no motion to the place")
        move = plan_motion(
            self.handling.empty(state.grasp.opening, self.q_start),
            self.q_start,
            approach[:1],
            seed=self.seed,
            budget=self.limits.budget,
        )
        if isinstance(move, MotionFailure):
            return self._drop("no motion to the object")
        end = ends[carry.goal]
        paths = [move.path, approach, lift, carry.path, end.lower, end.retreat]
        return Transfer(
            self.handling.name,
            state.grasp,
            end.placement,
            self._segments(state.grasp, paths),
            end.retreat[-1],
            dict(self.reasons),
        )

    def _drop(self, reason: str) -> None:
        self.reasons[reason] += 1

    def _segments(self, grasp: Grasp, paths: list[FloatArray]) -> tuple[Segment, ...]:
        arm, name, tool = self.handling.arm, self.handling.name, grasp.tool
        ready, closed = self.handling.ready(grasp), self.handling.closed(grasp)
        drawn_in = ToolState(ready.opening, 0.0)
        limits = self.limits

        def free(kind: str, path: FloatArray, hand: ToolState, holding: str | None) -> Segment:
            return Segment(kind, tool, hand, retime(arm, path, limits.speed), holding)

        def straight(kind: str, path: FloatArray, hand: ToolState, holding: str | None) -> Segment:
            places = arm.tool_pose(path, tool)[:, :3, 3]
            length = float(np.linalg.norm(np.diff(places, axis=0), axis=1).sum())
            slow = no_faster_than(retime(arm, path, limits.speed), length, limits.straight_speed)
            return Segment(kind, tool, hand, slow, holding)

        move, approach, lift, carry, lower, retreat = paths
        return (
            free("move", move, drawn_in, None),
            straight("approach", approach, ready, None),
            Segment("grasp", tool, closed, None, name),
            straight("lift", lift, closed, name),
            free("transfer", carry, closed, name),
            straight("place", lower, closed, name),
            Segment("release", tool, self.handling.released(grasp), None, None),
            straight("retreat", retreat, self.handling.released(grasp), None),
        )


def scene_after(scene: Scene, transfer: Transfer) -> Scene:
    """Predict the scene once a transfer is done.

    Args:
        scene: The scene before it.
        transfer: The transfer.

    Returns:
        The scene with the object's cloud let go at its place; all else is where it was.
    """
    pose = transfer.placement.pose_before_to_after
    cloud = moved((scene.clouds[transfer.object],), pose)[0]
    return scene.with_cloud(transfer.object, cloud - transfer.placement.drop * up_of(scene))
