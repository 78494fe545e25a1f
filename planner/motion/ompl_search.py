"""OMPL for what our own search does not solve: whole edges go to the batched checker, states never do."""

from typing import Any

import numpy as np

from topple.planner.motion.collision import Checker
from topple.topology.arrays import FloatArray

RANGE = 1.0  # [rad] longest branch; beats OMPL's default of 20 % of the space in clutter


def ompl_path(
    checker: Checker,
    start: FloatArray,
    goals: FloatArray,
    *,
    seed: int = 0,
    seconds: float = 5.0,
    planner: str = "RRTConnect",
) -> FloatArray | None:
    """A path by one of OMPL's planners.

    Args:
        checker: Collision checker.
        start: (n,) a free state.
        goals: (g, n) free states.
        seed: For OMPL's random numbers; it counts only before their first use in a process.
        seconds: Time limit.
        planner: Name in `ompl.geometric`: RRTConnect, AORRTC, BITstar and others.

    Returns:
        (k, n) path, or None.
    """
    if seconds <= 0:
        return None
    from ompl import base, geometric, util

    util.setLogLevel(util.LogLevel.LOG_NONE)
    util.RNG.setSeed(seed + 1)
    space = _space(base, checker)
    information: Any = base.SpaceInformation(space)
    information.setStateValidityChecker(lambda state: bool(checker.free(_values(state, len(start))[None])[0]))
    information.setMotionValidator(_edge_validator(base, information, checker))
    information.setup()
    problem: Any = base.ProblemDefinition(information)
    problem.addStartState(_state(space, start))
    region: Any = base.GoalStates(information)
    for goal in goals:
        region.addState(_state(space, goal))
    problem.setGoal(region)
    search: Any = getattr(geometric, planner)(information)
    if hasattr(search, "setRange"):
        search.setRange(RANGE)
    search.setProblemDefinition(problem)
    search.setup()
    solved = search.solve(seconds) and problem.hasExactSolution()
    path: Any = problem.getSolutionPath() if solved else None
    # the validator and its SpaceInformation hold each other; this lets both go
    information.setMotionValidator(base.MotionValidator(information))
    if path is None:
        return None
    return np.array([_values(path.getState(i), len(start)) for i in range(path.getStateCount())])


def _space(base: Any, checker: Checker) -> Any:
    n = len(checker.arm.joints)
    space, bounds = base.RealVectorStateSpace(n), base.RealVectorBounds(n)
    for i, (lower, upper) in enumerate(zip(checker.arm.lower, checker.arm.upper, strict=True)):
        bounds.setLow(i, float(lower))
        bounds.setHigh(i, float(upper))
    space.setBounds(bounds)
    return space


def _state(space: Any, values: FloatArray) -> Any:
    state = space.allocState()
    for i, value in enumerate(values):
        state[i] = float(value)
    return state


def _values(state: Any, n: int) -> FloatArray:
    return np.array([state[i] for i in range(n)])


def _edge_validator(base: Any, information: Any, checker: Checker) -> Any:
    n = len(checker.arm.joints)

    class EdgeValidator(base.MotionValidator):
        def __init__(self) -> None:
            super().__init__(information)

        def checkMotion(self, a: Any, b: Any) -> bool:
            return bool(checker.edge_free(_values(a, n), _values(b, n)))

    return EdgeValidator()
