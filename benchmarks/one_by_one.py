"""The usual way, to compare with: python-fcl on one state after the other, OMPL on top of it."""

from typing import Any

import numpy as np

from topple.planner.motion.exact import ExactPhase
from topple.planner.motion.model import CollisionModel
from topple.planner.motion.ompl_search import state_of, state_space, values_of
from topple.planner.motion.tolerances import RANGE
from topple.robots.arm.arm import Arm
from topple.topology.base.arrays import BoolArray, FloatArray

RESOLUTION = 0.08  # [rad] Euclidean between checked states: about 0.05 rad in the joint that moves most


class OneByOne:
    """Checks one state at a time, every pair of parts by python-fcl until one touches."""

    def __init__(self, arm: Arm, model: CollisionModel) -> None:
        """Take the parts and pairs of a checker's model."""
        self.arm = arm
        self._exact = ExactPhase(model)
        self._moving: list[int] = model.moving.tolist()
        table = np.argwhere(model.standing_pairs)
        self._pairs: list[tuple[int, int]] = [
            (int(model.moving[m]), int(model.standing[s])) for m, s in table.tolist()
        ]
        self._pairs += [(int(a), int(b)) for a, b in model.moving_pairs.tolist()]

    def free(self, q: FloatArray) -> bool:
        """Whether one state (n,) is free."""
        self._exact.load(self.arm.chain.poses(q[None]))
        self._exact.place(0, *self._moving)
        return not any(self._exact.touches(a, b) for a, b in self._pairs)

    def all(self, q: FloatArray) -> BoolArray:
        """Which of (m, n) states are free."""
        return np.array([self.free(state) for state in q], dtype=np.bool_)


def ompl_one_by_one(
    checker: OneByOne, start: FloatArray, goals: FloatArray, seconds: float
) -> FloatArray | None:
    """OMPL's RRTConnect and its own simplification with a state checker, the way tutorials do it."""
    from ompl import base, geometric, util

    util.setLogLevel(util.LogLevel.LOG_NONE)
    n = len(start)
    space = state_space(base, checker.arm)
    setup: Any = geometric.SimpleSetup(space)
    setup.setStateValidityChecker(lambda state: checker.free(values_of(state, n)))
    information: Any = setup.getSpaceInformation()
    information.setStateValidityCheckingResolution(RESOLUTION / space.getMaximumExtent())
    setup.addStartState(state_of(space, start))
    region: Any = base.GoalStates(information)
    for goal in goals:
        region.addState(state_of(space, goal))
    setup.setGoal(region)
    planner: Any = geometric.RRTConnect(information)
    planner.setRange(RANGE)
    setup.setPlanner(planner)
    setup.setup()
    if not setup.solve(seconds) or not setup.haveExactSolutionPath():
        return None
    setup.simplifySolution()
    path: Any = setup.getSolutionPath()
    return np.array([values_of(path.getState(i), n) for i in range(path.getStateCount())])
