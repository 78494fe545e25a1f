"""The built-in scenes as `topple demo` plays them: of how many seeds the goal is reached, nothing disturbed.

Episodes are those of `topple bench run`, kept in the same journal: what was played there is not played again.
With `--counts FILE` the count is written as `topple demo` tells it, with the seed that it plays by default.
"""

from collections.abc import Sequence
from concurrent.futures import Executor
from importlib.metadata import version
from pathlib import Path
from typing import Any

from topple.benchmarks.episodes import Ending, Episode
from topple.benchmarks.row import Progress, Row
from topple.benchmarks.run import JOURNAL, collected, in_turn
from topple.benchmarks.scores import share_interval
from topple.benchmarks.versions import commit_now
from topple.planner.execution.demo_seeds import CAMERAS, SeedCount, document, text
from topple.planner.formats.files import check_writable, write_whole
from topple.robots.scenarios import SCENARIOS
from topple.topology.errors import DISTRIBUTION

SEEDS = 40
EASY = 0.5  # share of what disturbs: a seed that stays below it is played by default, as it succeeds again


def rows(
    quick: bool,
    seed: int,
    progress: Progress,
    journal: Path = JOURNAL,
    minutes: float | None = None,
    counts: Path | None = None,
    executor: Executor | None = None,
) -> list[dict[str, Any]]:
    """Play what is not in the journal yet, and count.

    Args:
        quick: One seed of each scene.
        seed: The first seed.
        progress: Called as episodes end.
        journal: Where endings are kept, line by line; that of `topple bench run` will do.
        minutes: After this time no further episode is begun; the figures are of what was played.
        counts: Where the count is written, as JSON.
        executor: Whose workers play; None for a process a core.

    Returns:
        The bench's rows.

    Raises:
        InvalidInput: A file cannot be written.
    """
    place = None if counts is None else check_writable(str(counts))
    seeds = range(seed, seed + (1 if quick else SEEDS))
    episodes = {name: [Episode(name, one, CAMERAS) for one in seeds] for name in SCENARIOS}
    wanted = list(in_turn(list(episodes.values())))
    known = collected(wanted, progress, journal, minutes, executor)
    found = {name: count_of([known[e] for e in some if e in known]) for name, some in episodes.items()}
    counted = {name: count for name, count in found.items() if count is not None}
    if place is not None:
        made = {
            "made_by": "topple bench demo --counts FILE",
            "topple": version(DISTRIBUTION),
            "commit": commit_now(),
        }
        write_whole(place, text(document(counted, made)))
    missing = sum(episode not in known for episode in wanted)
    rows = [Row("episodes left to play", missing, f"of {len(wanted)}")]
    for name, count in counted.items():
        part, whole = len(count.reached), len(count.played)
        what = f"goal reached, nothing disturbed: demo {name}, {whole} of {len(seeds)} seeds"
        rows.append(
            Row(what, 100 * part / whole, "%", interval=share_interval(part, whole), tried=whole, held=part)
        )
    return [row.to_json() for row in rows]


def count_of(endings: Sequence[Ending]) -> SeedCount | None:
    """Count the seeds of one scene.

    Args:
        endings: Of its episodes, one for each seed.

    Returns:
        The count; None where nothing was played. Played by default is the first seed that succeeded by a wide
        margin, else the one with the widest.
    """
    if not endings:
        return None
    reached = sorted((ending for ending in endings if ending.success), key=lambda e: e.episode.seed)
    easy = [ending for ending in reached if ending.used < EASY]
    chosen = easy[0] if easy else min(reached or endings, key=lambda ending: ending.used)
    played = sorted(ending.episode.seed for ending in endings)
    return SeedCount(tuple(played), tuple(e.episode.seed for e in reached), chosen.episode.seed)
