"""Rearranging cubes of one size in layers: what must happen before what."""

from collections.abc import Mapping

from topple.planner.rearranging.problem import Act, Pair, Problem
from topple.topology.arrays import FloatArray


def cubes_problem(start: Mapping[str, FloatArray], goal: Mapping[str, FloatArray], side: float) -> Problem:
    """What must happen before what, for upright cubes with parallel edges.

    A cube is lifted straight up, so what is over it goes first, and what is under its place in the goal comes
    first. What is anywhere under, in or over that place at the start is gone by then.

    Args:
        start: name -> (3,) centre; any unit of length.
        goal: The same in the goal.
        side: Of every cube.
    """
    take, put = Act.TAKE, Act.PUT
    pairs: set[Pair] = set()
    for a in start:
        for b in start:
            if a == b:
                continue
            if _over(start[a], start[b], side) and start[a][2] > start[b][2]:
                pairs.add(((take, a), (take, b)))
            if _over(goal[a], goal[b], side) and goal[a][2] > goal[b][2]:
                pairs.add(((put, b), (put, a)))
            if _over(start[a], goal[b], side):
                pairs.add(((take, a), (put, b)))
    moving = tuple(name for name in start if (start[name] != goal[name]).any())
    return Problem(moving, tuple(name for name in start if name not in moving), frozenset(pairs))


def _over(a: FloatArray, b: FloatArray, side: float) -> bool:
    """Whether two cubes overlap seen from above."""
    return bool((abs(a - b)[:2] < side * (1 - 1e-6)).all())
