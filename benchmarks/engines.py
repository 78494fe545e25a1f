"""The same scenes, seeds and decisions on both physics engines: goals reached and verdicts side by side.

Every scene settles on PyBullet. For MuJoCo its bodies are put where they lie, and come to rest once more. The
loop looks, decides and plans by the same code with the same seed and the same arm, that of the scene. What
differs is how things touch.

Episodes are kept in the journal of `topple bench run`, and those that it has are not played again: those on
PyBullet are the ones that `topple bench demo` counts.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from topple.benchmarks.episodes import Ending, Episode
from topple.benchmarks.row import Progress, Row
from topple.benchmarks.run import JOURNAL, collected, in_turn
from topple.benchmarks.scores import share
from topple.robots.engines import BULLET, ENGINES, MUJOCO

SCENES = ("dishes", "tower", "lemon", "pile")
SEEDS = 40
NAMES = {BULLET: "PyBullet", MUJOCO: "MuJoCo"}


def rows(
    quick: bool,
    seed: int,
    progress: Progress,
    journal: Path = JOURNAL,
    minutes: float | None = None,
    seeds: int = SEEDS,
) -> list[dict[str, Any]]:
    """Play what is not in the journal yet, and compare.

    Args:
        quick: One seed of the tower alone.
        seed: The first seed.
        progress: Called as episodes end.
        journal: Where endings are kept, line by line.
        minutes: After this time no further episode is begun; the figures are of what was played.
        seeds: Of each scene.

    Returns:
        The bench's rows; only seeds that were played on both engines count.

    Raises:
        InvalidInput: The journal cannot be written.
        NotInstalled: MuJoCo is not installed.
    """
    from topple.robots.mujoco.engine import mujoco  # said before an hour is spent on the other engine

    assert mujoco
    numbers = range(seed, seed + (1 if quick else seeds))
    scenes = ("tower",) if quick else SCENES
    pairs = {
        scene: [{e: Episode(scene, one, engine=e) for e in ENGINES} for one in numbers] for scene in scenes
    }
    turns = in_turn([[episode for pair in some for episode in pair.values()] for some in pairs.values()])
    wanted = list(turns)
    known = collected(wanted, progress, journal, minutes)
    missing = sum(episode not in known for episode in wanted)
    found = [Row("episodes left to play", missing, f"of {len(wanted)}")]
    for scene, some in pairs.items():
        both = [
            {engine: known[episode] for engine, episode in pair.items()}
            for pair in some
            if all(episode in known for episode in pair.values())
        ]
        if both:
            found += compared(scene, both, len(numbers))
    return [row.to_json() for row in found]


def compared(scene: str, both: Sequence[Mapping[str, Ending]], of: int) -> list[Row]:
    """The rows of one scene.

    Args:
        scene: Its name.
        both: For every seed its endings by engine.
        of: How many seeds there are.

    Returns:
        The shares of each engine, and that of the seeds with the same verdict, with those that have not.
    """
    found: list[Row] = []
    for engine in ENGINES:
        good, clean = (sum(getattr(pair[engine], key) for pair in both) for key in ("success", "clean"))
        for what, held in (("goal reached, nothing disturbed", good), ("nothing disturbed", clean)):
            words = f"{what}: {scene}, {NAMES[engine]}, {len(both)} of {of} seeds"
            found.append(share(words, held, len(both)))
    other = [pair for pair in both if len({(one.success, one.clean) for one in pair.values()}) > 1]
    same, wrong = len(both) - len(other), [_told(pair) for pair in other]
    return [*found, share(f"same verdict on both: {scene}", same, len(both), counted=True, wrong=wrong)]


def _told(pair: Mapping[str, Ending]) -> str:
    """What a seed came to on each engine."""
    ends = [f"{NAMES[e]}: {': '.join([ending.ending, *ending.violations[:1]])}" for e, ending in pair.items()]
    return f"seed {pair[BULLET].episode.seed}: {'; '.join(ends)}"
