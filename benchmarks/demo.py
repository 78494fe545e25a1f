"""The built-in scenes as `topple demo` plays them: of how many seeds the goal is reached, nothing disturbed.

Episodes are those of `topple bench run`, kept in the same journal: what was played there is not played again.
With `--counts FILE` the count is written as `topple demo` tells it, with the seed that it plays by default.
"""

from collections import Counter
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

from topple.benchmarks.episodes import Ending, Episode
from topple.benchmarks.row import Progress, Row
from topple.benchmarks.run import JOURNAL, collected, in_turn
from topple.benchmarks.scores import share
from topple.benchmarks.versions import commit_now
from topple.planner.execution.demo_seeds import CAMERAS, SeedCount, document, text
from topple.robots.scenarios import SCENARIOS
from topple.topology.base.errors import DISTRIBUTION
from topple.topology.base.files import check_writable, write_whole

SEEDS = 40
EASY = 0.5  # share of what disturbs: a seed that stays below it is tried first as the one played by default
TURNED = (0.0, 1.0, 359.0)  # degrees: other machines settle and round otherwise
ROUGH = (0.8, 1.2)  # share of friction likewise


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
        counts: Where the count is written, as JSON; the seeds played by default are tried in variants then.
        executor: Whose workers play; None for a process a core.

    Returns:
        The bench's rows.

    Raises:
        InvalidInput: A file cannot be written.
    """
    place = None if counts is None else check_writable(str(counts))
    seeds = range(seed, seed + (1 if quick else SEEDS))
    wanted = list(in_turn([[Episode(name, one, CAMERAS) for one in seeds] for name in SCENARIOS]))

    def ended(some: Sequence[Episode]) -> list[Ending]:
        known = collected(some, progress, journal, minutes, executor)
        return [known[episode] for episode in some if episode in known]

    played = ended(wanted)
    found = {name: count_of([e for e in played if e.episode.scenario == name]) for name in SCENARIOS}
    counted = {name: count for name, count in found.items() if count is not None}
    if place is not None:
        counted = {
            name: replace(each, default=default_of(name, each, ended)) for name, each in counted.items()
        }
        made = {
            "made_by": "topple bench demo --counts FILE",
            "topple": version(DISTRIBUTION),
            "commit": commit_now(),
        }
        write_whole(place, text(document(counted, made)))
    rows = [Row("episodes left to play", len(wanted) - len(played), f"of {len(wanted)}")]
    failed = Counter(ending.ending for ending in played if not ending.success)
    rows += [Row(f"failed: {why}", count, f"of {failed.total()}") for why, count in failed.most_common()]
    for name, count in counted.items():
        part, whole = len(count.reached), len(count.played)
        what = f"goal reached, nothing disturbed: demo {name}, {whole} of {len(seeds)} seeds"
        rows.append(share(what, part, whole, counted=True))
    return [row.to_json() for row in rows]


def variants(name: str, seed: int) -> list[Episode]:
    """A scene as it is, turned by a degree either way, and with less and more friction."""
    as_it_is = Episode(name, seed, CAMERAS)
    turned = [replace(as_it_is, turned=degrees) for degrees in TURNED]
    return turned + [replace(as_it_is, friction=share) for share in ROUGH]


def default_of(name: str, count: SeedCount, ended: Callable[[Sequence[Episode]], Sequence[Ending]]) -> int:
    """The first seed, from the easiest on, of which every variant succeeds; the easiest where none does.

    Args:
        name: Of the scene.
        count: Its seeds.
        ended: Gives the endings of episodes.
    """
    for seed in dict.fromkeys((count.default, *count.reached)):
        tried = ended(variants(name, seed))
        if tried and all(ending.success for ending in tried):
            return seed
    return count.default


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
