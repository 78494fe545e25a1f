"""Motions that keep what is carried upright: RRT-Connect on states turned back to within a tilt."""

from dataclasses import dataclass

import numpy as np

from topple.planner.motion.certificate import Certifier
from topple.planner.motion.collision import Checker
from topple.planner.motion.planner import Motion, MotionFailure, checkers, in_turn
from topple.planner.motion.rrt import rrt_connect
from topple.planner.motion.shortcut import shortcut
from topple.planner.motion.tolerances import CLEARANCE, DAMPING, ROUNDS, STEP, UPRIGHT_ROUNDS, WITHIN
from topple.topology.base.arrays import BoolArray, FloatArray

REACH = 0.35  # [rad] longer branches leave the band of small tilts more often than not


@dataclass(frozen=True)
class Upright:
    """How a tool is kept as it stands: its name, (3,) up in the base's frame, and the largest tilt [rad]."""

    tool: str
    up: FloatArray
    tilt: float


class _Level:
    """A checker that also refuses tilts from how the tool stands in a state (n,), as searches ask it."""

    def __init__(self, checker: Checker, start: FloatArray, kept: Upright) -> None:
        self.checker, self.arm, self.up, self.tilt = checker, checker.arm, kept.up, kept.tilt
        self._tool, self._axis = kept.tool, checker.arm.tool_pose(start, kept.tool)[0, :3, :3].T @ kept.up

    def _carried_up(self, q: FloatArray) -> FloatArray:
        """(m, 3) where what was up in the first state points in states (m, n)."""
        return self.arm.tool_pose(q, self._tool)[:, :3, :3] @ self._axis

    def tilts(self, q: FloatArray) -> FloatArray:
        """Angles (m,) by which states (m, n) tilt what is carried [rad]."""
        carried = self._carried_up(q)
        return np.arctan2(np.linalg.norm(np.cross(carried, self.up), axis=1), carried @ self.up)

    def edges_free(self, starts: FloatArray, ends: FloatArray) -> BoolArray:
        """Which straight edges (e, n) stay free at the checked states, and within the tilt everywhere.

        Between two states looked at the tilt changes by at most the sum of the joints' changes.
        """
        level = np.array([self._level(a, b) for a, b in zip(starts, ends, strict=True)], dtype=np.bool_)
        level[level] = self.checker.edges_free(starts[level], ends[level])
        return level

    def _level(self, start: FloatArray, end: FloatArray) -> bool:
        change = np.abs(end - start)
        count = max(int(np.ceil(float(change.max()) / STEP)), 1)
        states = start + (np.arange(count)[:, None] + 0.5) / count * (end - start)
        return bool(self.tilts(states).max() + 0.5 * float(change.sum()) / count <= self.tilt)

    def turned_back(self, q: FloatArray) -> FloatArray:
        """States (m, n) moved the least way that brings their tilt well within the limit."""
        q = np.array(q)
        for _ in range(UPRIGHT_ROUNDS):
            over = np.flatnonzero(self.tilts(q) > WITHIN * self.tilt)
            if not len(over):
                break
            frames = self.arm.chain.frames(q[over])
            carried = self._carried_up(q[over])
            away = np.cross(carried, self.up)
            sine = np.linalg.norm(away, axis=1, keepdims=True)
            angle = np.arctan2(sine, (carried @ self.up)[:, None])
            wanted = away / np.maximum(sine, 1e-9) * (angle - 0.5 * WITHIN * self.tilt)
            turns = self.arm.chain.jacobian(frames, frames[:, -1, :3, 3])[:, 3:]
            turns = turns - self.up[:, None] * np.einsum("i,mij->mj", self.up, turns)[:, None, :]
            square = np.matmul(turns, turns.transpose(0, 2, 1)) + DAMPING * np.eye(3)
            step = np.matmul(turns.transpose(0, 2, 1), np.linalg.solve(square, wanted[:, :, None]))[..., 0]
            q[over] = np.clip(q[over] + step, self.arm.lower, self.arm.upper)
        return q


def plan_upright(
    checker: Checker,
    start: FloatArray,
    goals: FloatArray,
    kept: Upright,
    *,
    seed: int = 0,
    rounds: int = ROUNDS,
) -> Motion | MotionFailure:
    """Find a path that keeps what a tool carries as it stands at the start.

    Args:
        checker: The arm, what it holds and what it must not hit.
        start: (n,) joint values; what is carried is upright there.
        goals: (g, n) joint values; those that tilt it are left out.
        kept: The tool that carries, and how far it may be tilted.
        seed: Of the search.
        rounds: Batches of branches before the search gives up.

    Returns:
        The motion with its certificate, its tilt proven too; or why there is none.
    """
    trials = checkers(checker, start, goals, CLEARANCE)
    levels = ((_Level(trial, start, kept), round(share * rounds)) for trial, share in trials)
    return in_turn(None, (_plan(level, start, goals, seed, share) for level, share in levels))


def _plan(
    level: _Level, start: FloatArray, goals: FloatArray, seed: int, rounds: int
) -> Motion | MotionFailure:
    """An upright motion that keeps the checker's margins, or why there is none."""
    checker = level.checker
    kept = np.flatnonzero(checker.free(goals) & (level.tilts(goals) <= level.tilt))
    contacts = checker.contacts(start)
    if contacts or not len(kept):
        stage, what = (
            ("start", "at the start something touches") if contacts else ("goals", "no goal is free")
        )
        return MotionFailure(stage, f"{what}, with what is carried upright", contacts)
    starts = np.broadcast_to(start, goals[kept].shape)
    direct = kept[level.edges_free(starts, goals[kept])]
    for attempt in range(4):
        if len(direct):
            path, stage = np.array([start, goals[direct[0]]]), "direct"
            direct = direct[1:]
        else:
            path, stage = (
                rrt_connect(
                    level, start, goals[kept], seed=seed + 7919 * attempt, rounds=rounds,
                    reach=REACH, project=level.turned_back,
                ),
                "rrt",
            )  # fmt: skip
            path = None if path is None else shortcut(path, level.edges_free)
        if path is None:
            break
        certificate = Certifier(checker).path(path)
        if certificate.proven:
            goal = int(np.argmin(np.abs(goals - path[-1]).max(axis=1)))
            return Motion(path, goal, stage, certificate)
    return MotionFailure("search", "no upright motion found")
