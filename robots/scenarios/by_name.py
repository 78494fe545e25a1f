"""A built-in scene by its name."""

from topple.robots.engines import DEFAULT_ENGINE, playing_on
from topple.robots.scenarios import SCENARIOS
from topple.robots.scenarios.scenario import Scenario
from topple.topology.base.arguments import checked_arguments


@checked_arguments
def scenario(name: str, seed: int = 0, engine: str = DEFAULT_ENGINE) -> Scenario:
    """Make a scene by its name.

    Args:
        name: dishes, lemon, tower, pile, sort, set-table, restack, pack, swap, hold, shelf, or one that
            another package adds.
        seed: Any number; the same one gives the same scene on the same engine.
        engine: What it is played on, one of `topple.robots.engines.ENGINES`.

    Returns:
        The settled scene with its task; as a context manager it closes its world in the end.

    Raises:
        InvalidInput: If there is no such scene or engine.
        NotInstalled: If the engine is not installed.

    Examples:
        >>> with scenario("dishes", seed=3) as stage:
        ...     stage.goal, stage.targets, stage.fixed
        ('free plate', ('plate',), ('table',))
    """
    with playing_on(engine):
        return SCENARIOS[name](seed)
