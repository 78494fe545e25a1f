"""Motion planning against the usual way: python-fcl, one state at a time, with OMPL on top of it.

Measured on seeded problems, a Panda picking low between eight boxes and carrying over a wall between four:
states checked per second and every disagreement; CPU time of planning with shortcutting, with and without
the certificate that the whole path is free; paths that touch something when looked at every 0.002 rad; and
how many reachable top-down poses the inverse kinematics solves. The problems and the measurement are those
of `topple.planner.motion.benchmark`; medians of CPU times, ratios of those. Whole plans follow: see
`topple.planner.bench.plans`.
"""

from typing import Any

from topple.planner.bench import plans
from topple.planner.bench.row import Progress
from topple.planner.motion import benchmark


def rows(quick: bool, seed: int, progress: Progress) -> list[dict[str, Any]]:
    """Measure.

    Args:
        quick: Fewer states and problems.
        seed: First seed of the problems.
        progress: Called before each part.

    Returns:
        The bench's rows.
    """
    return [*benchmark.rows(quick, seed, progress), *plans.rows(quick, seed, progress)]
