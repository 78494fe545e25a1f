"""Built-in scenes: settled worlds with cameras, a robot's place and a task, each made from a seed."""

from collections.abc import Callable, Mapping

from topple.robots.scenarios.dishes import dishes
from topple.robots.scenarios.lemon import lemon_in_bowl
from topple.robots.scenarios.pile import pile
from topple.robots.scenarios.scenario import Scenario
from topple.robots.scenarios.sort import sort
from topple.robots.scenarios.tower import tower
from topple.topology.errors import InvalidInput
from topple.topology.values import FrozenDict

SCENARIOS: Mapping[str, Callable[[int], Scenario]] = FrozenDict(
    {"dishes": dishes, "lemon": lemon_in_bowl, "tower": tower, "pile": pile, "sort": sort}
)
"""Every scenario by its name, to be called with a seed."""

__all__ = ["SCENARIOS", "Scenario", "dishes", "lemon_in_bowl", "pile", "scenario_called", "sort", "tower"]


def scenario_called(name: str, seed: int = 0) -> Scenario:
    """Make a built-in scene.

    Args:
        name: dishes, lemon, tower, pile or sort.
        seed: Any number; the same one gives the same scene.

    Returns:
        The settled scene with its task.

    Raises:
        InvalidInput: If there is no such scene.
    """
    if name not in SCENARIOS:
        raise InvalidInput(f"there is no scene {name!r}: choose one of {', '.join(SCENARIOS)}")
    return SCENARIOS[name](seed)
