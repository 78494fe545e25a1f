"""Built-in scenes: settled worlds with cameras, a robot's place and a task, each made from a seed."""

from collections.abc import Callable

from topple.robots.scenarios.dishes import dishes
from topple.robots.scenarios.lemon import lemon_in_bowl
from topple.robots.scenarios.pile import pile
from topple.robots.scenarios.scenario import Scenario
from topple.robots.scenarios.sort import sort
from topple.robots.scenarios.tower import tower
from topple.topology.plugins import Table

SCENARIOS: Table[Callable[[int], Scenario]] = Table(
    "topple.scenarios",
    "scene",
    {
        "dishes": "topple.robots.scenarios.dishes:dishes",
        "lemon": "topple.robots.scenarios.lemon:lemon_in_bowl",
        "tower": "topple.robots.scenarios.tower:tower",
        "pile": "topple.robots.scenarios.pile:pile",
        "sort": "topple.robots.scenarios.sort:sort",
    },
    Scenario,
)
"""Every scenario by its name, to be called with a seed; other packages add theirs."""

__all__ = ["SCENARIOS", "Scenario", "dishes", "lemon_in_bowl", "pile", "scenario_called", "sort", "tower"]


def scenario_called(name: str, seed: int = 0) -> Scenario:
    """Make a scene by its name.

    Args:
        name: dishes, lemon, tower, pile, sort, or what another package adds.
        seed: Any number; the same one gives the same scene.

    Returns:
        The settled scene with its task.

    Raises:
        InvalidInput: If there is no such scene.
    """
    return SCENARIOS[name](seed)
