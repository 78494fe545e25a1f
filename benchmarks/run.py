"""Seeded scenes played by the arm in closed loop: how often the goal is reached and nothing is disturbed.

- dishes, lemon and tower with three cameras; random piles of five to eight things of which one is freed, with
  three cameras and with one; a pile sorted into two bins.
- Packets and planks that stand only together, by two arms and by one.
- The same piles with masks whose edges are a pixel off, and with names of objects not kept between looks.
- Piles of another generator, which nothing was developed on; with `--meshes DIR` of a folder's models, too.
- With `--data DIR`, annotated camera frames, each rebuilt as bodies in which an arm frees the object that
  most others have to go before.
- Of the same piles, how many any order of ideal lifts could free at all, were all known perfectly.
- The same piles again with the same arm, grasps and motions, but with the order decided by a rule of thumb:
  what is nearest to the arm first, the highest top first, or the paper's relations and height.

Every episode that ends is kept in a journal with its commit: a bench that was stopped goes on, and the
figures are of all that the same code played, in as many sittings as it took. `--against JOURNAL` compares the
seeds that both have. Shares have Wilson's 95 %
intervals. A sitting of half an hour shows whether anything leaks or breaks: its rows are those of memory and
crashes.
"""

import time
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from itertools import chain
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from topple.benchmarks.episodes import ENDINGS, IDEAL, TOPPLE, Ending, Episode, play
from topple.benchmarks.frames import frames_in
from topple.benchmarks.journal import Journal
from topple.benchmarks.other_piles import NAME as OTHER_PILE
from topple.benchmarks.row import Progress, Row
from topple.benchmarks.rules import RULES
from topple.benchmarks.scores import DRAWS, share
from topple.benchmarks.series import BESIDE, FULL, QUICK, Series
from topple.planner.fallbacks import Relaxation
from topple.topology.base.errors import InvalidInput
from topple.topology.base.workers import Lost, map_tasks, open_executor

JOURNAL = Path("topple-bench-run.jsonl")
LEAST_THIRD = 5  # episodes: with fewer in a third a process's memory says nothing
LOOP = 30  # [min] that a process has to go on without a break
WORST = 3.0  # points of all runs that a change may lose
STAYED = 0.01  # [m] a rebuilt body may move until it is at rest


def rows(
    quick: bool,
    seed: int,
    progress: Progress,
    journal: Path = JOURNAL,
    minutes: float | None = None,
    data: Path | None = None,
    meshes: Path | None = None,
    ahead: bool = False,
    against: str | None = None,
    scenario: str | None = None,
    executor: Executor | None = None,
) -> list[dict[str, Any]]:
    """Play what is not in the journal yet, and count.

    Args:
        quick: A handful of episodes.
        seed: The first seed of every series.
        progress: Called as episodes end.
        journal: Where endings are kept, line by line.
        minutes: After this time no further episode is begun; the figures are of what was played. With 0 they
            are of what the code of the journal's last line played, else of what today's did.
        data: A folder with annotated camera frames, to be acted out too.
        meshes: A folder with models that the piles of another generator are made of, besides its own shapes.
        ahead: Whether the next step is chosen while the arm acts, in series that are no frames.
        against: Another journal, of which the same seeds are compared with.
        scenario: The name of one whose series are played alone.
        executor: Whose workers play, and see the same folders; None for a process a core.

    Returns:
        The bench's rows.

    Raises:
        InvalidInput: No series is of that scenario.
    """
    main, beside = (QUICK, ()) if quick else (FULL, BESIDE)
    if data is not None:
        frames = frames_in(data)
        kept = frames[:1] if quick else frames
        beside = (*beside, Series("real frames", len(kept), bar=">= 70", folder=data, frames=kept))
    main, beside = (
        tuple(
            replace(one, ahead=ahead, meshes=meshes if one.scenario == OTHER_PILE else None)
            for one in some
            if scenario in (None, one.scenario)
        )
        for some in (main, beside)
    )
    if not (series := (*main, *beside)):
        named = sorted({one.scenario for one in (*FULL, *BESIDE)})
        raise InvalidInput(f"no series is of {scenario!r}: expected one of {', '.join(named)}")
    turns = (in_turn([one.episodes(seed) for one in some]) for some in (main, beside) if some)
    wanted = list(chain.from_iterable(turns))
    known = collected(wanted, progress, journal, minutes, executor)
    found = {one: [known[e] for e in one.episodes(seed) if e in known] for one in series}
    missing = sum(episode not in known for episode in wanted)
    rows = [Row("episodes left to play", missing, f"of {len(wanted)}"), *figures(found)]
    asked = set(wanted)
    endings = [ending for episode, ending in known.items() if episode in asked]
    if scenario is None:
        rows += [*fallback_rows(endings), *endurance(endings)]
    if against is not None:
        rows += paired_rows(found, _endings_in(Path(against), journal))
    return [row.to_json() for row in rows]


def collected(
    wanted: Sequence[Episode],
    progress: Progress,
    journal: Path,
    minutes: float | None = None,
    executor: Executor | None = None,
) -> Mapping[Episode, Ending]:
    """Play what is not in a journal yet, and keep it there.

    Args:
        wanted: What is to be played, in this order.
        progress: Called as episodes end.
        journal: Where endings are kept, line by line.
        minutes: After this time no further episode is begun.
        executor: Whose workers play; None for a process a core.

    Returns:
        Everything that counts in the journal, wanted or not, in the order in which it was played.
    """
    with Journal(journal, last=minutes == 0) as book:
        return _kept(wanted, progress, book, minutes, executor)


def _kept(
    wanted: Sequence[Episode],
    progress: Progress,
    book: Journal,
    minutes: float | None,
    executor: Executor | None,
) -> Mapping[Episode, Ending]:
    if book.stale:
        progress(f"{book.stale} results of other code are left out: --against compares with them")
    known = {ending.episode: ending for ending in map(Ending.from_json, book.entries)}
    left = [episode for episode in wanted if episode not in known]
    until = None if minutes is None else time.monotonic() + 60 * minutes
    for ending in _played(left, until, executor):
        known[ending.episode] = ending
        book.add(ending.to_json())
        progress(f"{sum(e in known for e in wanted)} of {len(wanted)} episodes: {ending}")
    if missing := sum(episode not in known for episode in wanted):
        progress(f"{missing} of {len(wanted)} episodes are left: the same command goes on with them")
    return known


def in_turn(lists: Sequence[Sequence[Episode]]) -> Iterator[Episode]:
    """One of each list, then the next of each: what was played so far is of all kinds."""
    for number in range(max(map(len, lists))):
        yield from (one[number] for one in lists if number < len(one))


def _played(episodes: Sequence[Episode], until: float | None, executor: Executor | None) -> Iterator[Ending]:
    """Endings as they come; a process that dies is a crash, and the next episode has another one.

    One process plays one episode after the other: its memory shows whether anything leaks.
    """
    named = {_found(episode): episode for episode in episodes}
    waiting = (e for e in named if until is None or time.monotonic() < until)
    with open_executor(executor) as pool:
        for answer in map_tasks(play, waiting, pool, in_turn=False, tries=1):
            ending = answer if isinstance(answer, Ending) else _crashed(answer)
            yield replace(ending, episode=named[ending.episode])


def _found(episode: Episode) -> Episode:
    """An episode whose folders any worker finds; a journal has them as they were given."""
    folder, meshes = (str(Path(one).resolve()) if one else "" for one in (episode.folder, episode.meshes))
    return replace(episode, folder=folder, meshes=meshes)


def _crashed(lost: Lost[Episode]) -> Ending:
    return Ending(lost.task, "crash", ("the process that played it was lost",))


def figures(found: Mapping[Series, Sequence[Ending]]) -> list[Row]:
    """The figures of what was played.

    Args:
        found: Series to the endings of those of its episodes that were played.

    Returns:
        The bench's rows.
    """
    rows: list[Row] = []
    for one, endings in found.items():
        if endings and one.rule == TOPPLE:
            rows += _of_series(one, endings)
        if endings and one.rule == IDEAL:
            possible = sum(ending.success for ending in endings)
            what = f"targets that ideal lifts of true bodies free, {len(endings)} of {one.seeds} piles"
            rows.append(share(what, possible, len(endings)))
    return rows + _against_rules(found)


def _endings_in(path: Path, journal: Path) -> Mapping[Episode, Ending]:
    """The last ending of each episode in another journal, whatever played it."""
    if not path.is_file() or path.resolve() == journal.resolve():
        raise InvalidInput(f"{path}: expected another journal than the one that is kept ({journal})")
    with Journal(path) as book:
        return {ending.episode: ending for ending in map(Ending.from_json, book.lines)}


def paired_rows(found: Mapping[Series, Sequence[Ending]], theirs: Mapping[Episode, Ending]) -> list[Row]:
    """Successes lost against another journal, on the seeds that both have, each series and all together.

    Args:
        found: Series to the endings of those of its episodes that were played.
        theirs: Endings by episode.

    Returns:
        Rows of paired differences in points, with 95 % intervals; all together may lose `WORST`, and nothing
        significantly.
    """
    pairs = {
        str(one): [(e.success, theirs[e.episode].success) for e in endings if e.episode in theirs]
        for one, endings in found.items()
        if one.rule == TOPPLE
    }
    rows: list[Row] = []
    every = [pair for some in pairs.values() for pair in some]
    for what, some in (*pairs.items(), ("all series", every)):
        if some:
            lost = 100.0 * np.array([float(its) - float(ours) for ours, its in some])
            drawn = np.random.default_rng(0).choice(lost, (DRAWS, len(lost))).mean(axis=1)
            low, high = (float(value) for value in np.percentile(drawn, [2.5, 97.5]))
            most = None if what in pairs else "<= 0" if low > 0.0 else f"<= {WORST:g}"
            told = f"runs lost against the other journal: {what}, {len(some)} seeds of both"
            rows.append(Row(told, float(lost.mean()), "points", bar=most, interval=(low, high)))
    return rows


def fallback_rows(endings: Sequence[Ending]) -> list[Row]:
    """How many steps stand on each fallback, and how many of these succeed: what earns nothing has to go.

    Args:
        endings: Of episodes.

    Returns:
        A row for every fallback of `topple.planner.fallbacks`; another for the share that succeeded where any
        step stood on it.
    """
    steps = sum(ending.steps for ending in endings)
    stood = Counter(name for ending in endings for name, _ in ending.fallbacks)
    held = Counter(name for ending in endings for name, succeeded in ending.fallbacks if succeeded)
    rows: list[Row] = []
    for name in Relaxation:
        rows.append(Row(f"steps by {name}, of {steps}", stood[name], ""))
        if stood[name]:
            rows.append(share(f"of these succeeded: {name}", held[name], stood[name]))
    return rows


def endurance(endings: Sequence[Ending]) -> list[Row]:
    """Whether it goes on: crashes, failures nobody has a name for, memory, and for how long.

    Args:
        endings: In the order in which they came.

    Returns:
        The bench's rows.
    """
    crashes = sum(ending.ending == "crash" for ending in endings)
    nameless = sum(ending.ending not in ENDINGS for ending in endings)
    rows = [
        Row(f"episodes in which the program failed, of {len(endings)}", crashes, "", bar="<= 0"),
        Row(f"failures of no known kind, of {len(endings)}", nameless, "", bar="<= 0"),
    ]
    if (growth := _growth(endings)) is not None:
        worked: Counter[int] = Counter()
        for ending in endings:
            worked[ending.process] += round(ending.seconds)
        longest = max(worked.values()) / 60
        what = "memory of a process, last third of its episodes against the second"
        rows.append(Row(what, growth, "x", bar="<= 1.2"))
        rows.append(Row("longest that a process went on", longest, "min", bar=f">= {LOOP}"))
    return rows


def _of_series(one: Series, endings: Sequence[Ending]) -> list[Row]:
    what = "seeds" if one.folder is None else "frames"
    played = f"{one}, {len(endings)} of {one.seeds} {what}"
    good = sum(ending.success for ending in endings)
    clean = sum(ending.clean for ending in endings)
    rows = [
        share(f"goal reached, nothing disturbed: {played}", good, len(endings), one.bar),
        share(f"nothing disturbed: {played}", clean, len(endings)),
    ]
    if one.folder is not None:
        stayed = sum(ending.sagged is not None and ending.sagged < STAYED for ending in endings)
        rows.append(share(f"rebuilt, every body moves below 1 cm: {played}", stayed, len(endings), ">= 80"))
    if places := sum(ending.places for ending in endings):
        placed = sum(ending.placed for ending in endings)
        rows.append(share(f"things where they belong: {played}", placed, places, ">= 90"))
    seconds = median(ending.seconds for ending in endings)
    rows.append(
        Row(f"wall time, median: {one}", seconds, "s", bar="<= 60" if one.scenario == "pile" else None)
    )
    if one.ahead and (waited := [seconds for ending in endings for seconds in ending.waited]):
        rows.append(Row(f"waiting for a decision, median: {one}", median(waited), "s"))
        rows.append(Row(f"the same, of 90 %: {one}", float(np.quantile(waited, 0.9)), "s"))
    robot = median(ending.robot_seconds for ending in endings)
    rows.append(Row(f"time of the arm, median: {one}", robot, "s"))
    ways = Counter(ending.ending for ending in endings if not ending.success)
    return rows + [Row(f"{how}: {played}", count, "episodes") for how, count in sorted(ways.items())]


def _against_rules(found: Mapping[Series, Sequence[Ending]]) -> list[Row]:
    """The same piles with other orders; only seeds that were played with both count."""
    by_rule = {
        rule: {e.episode.seed: e for one, es in found.items() if _same(one, rule) for e in es}
        for rule in (TOPPLE, *RULES)
    }
    seeds = set.intersection(*(set(endings) for endings in by_rule.values()))
    if not seeds:
        return []
    count = {rule: sum(endings[s].violated for s in seeds) for rule, endings in by_rule.items()}
    reached = {rule: sum(endings[s].success for s in seeds) for rule, endings in by_rule.items()}
    best = min(RULES, key=lambda rule: count[rule])
    rows: list[Row] = []
    for rule in RULES:
        what = f"things disturbed, the same {len(seeds)} piles"
        ratio = count[TOPPLE] / max(count[rule], 1)
        bar = "<= 1/2" if rule == best else None
        rows.append(Row(what, count[TOPPLE], "", rule, count[rule], ratio, bar))
        what = f"target freed, nothing disturbed, the same {len(seeds)} piles"
        rows.append(share(what, reached[TOPPLE], len(seeds), against=(rule, reached[rule], len(seeds))))
    return rows


def _same(one: Series, rule: str) -> bool:
    """Whether a series plays the piles that rules are compared on, by a rule."""
    return one.episodes(0)[:1] == [Episode("pile", 0, rule=rule, ahead=one.ahead)]


def _growth(endings: Sequence[Ending]) -> float | None:
    """Memory after the last third of a process's episodes against the second, the worst of all processes.

    In the first it loads what it needs, and comes by the largest scene that it will hold memory for.
    """
    by_process: dict[int, list[int]] = {}
    for ending in endings:
        by_process.setdefault(ending.process, []).append(ending.memory)
    grown: list[float] = []
    for memory in by_process.values():
        third = len(memory) // 3
        if third >= LEAST_THIRD:
            grown.append(median(memory[-third:]) / median(memory[-2 * third : -third]))
    return max(grown, default=None)
