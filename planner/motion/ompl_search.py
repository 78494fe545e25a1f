"""OMPL for what our own search does not solve: whole edges go to the batched checker, states never do."""

from importlib.util import find_spec
from itertools import count
from typing import Any

import numpy as np

from topple.planner.budget import check_budget, seconds_left
from topple.planner.motion.collision import Checker
from topple.planner.motion.tolerances import RANGE, ROUNDS
from topple.robots.arm.arm import Arm
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput

OMPL_INSTALLED = find_spec("ompl") is not None
"""It has no wheel for Windows, nor for every Python."""


def ompl_path(
    checker: Checker,
    start: FloatArray,
    goals: FloatArray,
    *,
    seed: int = 0,
    iterations: int = ROUNDS,
    planner: str = "RRTConnect",
) -> FloatArray | None:
    """A path by one of OMPL's planners.

    Args:
        checker: Collision checker.
        start: (n,) a free state.
        goals: (g, n) free states.
        seed: For OMPL's random numbers; it counts only before their first use in a process.
        iterations: Of the planner, before it gives up.
        planner: Name in `ompl.geometric`: RRTConnect, AORRTC, BITstar and others.

    Returns:
        (k, n) path, or None.

    Raises:
        InvalidInput: OMPL is not installed.
        OutOfBudget: The budget of the call ran out.
    """
    if not OMPL_INSTALLED:
        raise InvalidInput(
            f"{planner} is a planner of OMPL, which is not installed: pip install ompl (no wheel for Windows)"
        )
    from ompl import base, geometric, util

    util.setLogLevel(util.LogLevel.LOG_NONE)
    util.RNG.setSeed(seed + 1)
    space = state_space(base, checker.arm)
    information: Any = base.SpaceInformation(space)
    information.setStateValidityChecker(
        lambda state: bool(checker.free(values_of(state, len(start))[None])[0])
    )
    information.setMotionValidator(_edge_validator(base, information, checker))
    information.setup()
    problem: Any = base.ProblemDefinition(information)
    problem.addStartState(state_of(space, start))
    region: Any = base.GoalStates(information)
    for goal in goals:
        region.addState(state_of(space, goal))
    problem.setGoal(region)
    search: Any = getattr(geometric, planner)(information)
    if hasattr(search, "setRange"):
        search.setRange(RANGE)
    search.setProblemDefinition(problem)
    search.setup()
    asked = count()  # a planner asks whether to stop once in each iteration
    enough: Any = base.PlannerTerminationCondition(lambda: next(asked) >= iterations or seconds_left() <= 0.0)
    solved = search.solve(enough) and problem.hasExactSolution()
    path: Any = problem.getSolutionPath() if solved else None
    # the validator and its SpaceInformation hold each other; this lets both go
    information.setMotionValidator(base.MotionValidator(information))
    check_budget()
    if path is None:
        return None
    return np.array([values_of(path.getState(i), len(start)) for i in range(path.getStateCount())])


def state_space(base: Any, arm: Arm) -> Any:
    """The box of an arm's joint limits as an OMPL space."""
    n = len(arm.joints)
    space, bounds = base.RealVectorStateSpace(n), base.RealVectorBounds(n)
    for i, (lower, upper) in enumerate(zip(arm.lower, arm.upper, strict=True)):
        bounds.setLow(i, float(lower))
        bounds.setHigh(i, float(upper))
    space.setBounds(bounds)
    return space


def state_of(space: Any, values: FloatArray) -> Any:
    """An OMPL state with the given values (n,)."""
    state = space.allocState()
    for i, value in enumerate(values):
        state[i] = float(value)
    return state


def values_of(state: Any, n: int) -> FloatArray:
    """The n values of an OMPL state, which has no length of its own."""
    return np.array([state[i] for i in range(n)])


def _edge_validator(base: Any, information: Any, checker: Checker) -> Any:
    n = len(checker.arm.joints)

    class EdgeValidator(base.MotionValidator):
        def __init__(self) -> None:
            super().__init__(information)

        def checkMotion(self, a: Any, b: Any) -> bool:
            return bool(checker.edge_free(values_of(a, n), values_of(b, n)))

    return EdgeValidator()
