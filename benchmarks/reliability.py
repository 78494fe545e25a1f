"""Whether topple can be relied on: broken input, spoilt plans, faults in runs, kills, full disks, long work.

A run that a fault spoils counts as survived only where its report names the fault or the goal is reached, and
nothing else was disturbed.
"""

from importlib import import_module
from importlib.util import find_spec
from typing import Any

from topple.benchmarks.faults.inject import FAULTS, inject
from topple.benchmarks.kills import kill, refuse
from topple.benchmarks.row import Progress, Row
from topple.benchmarks.sabotages.caught import CASES, catch
from topple.benchmarks.scores import share_interval
from topple.benchmarks.soak import side_by_side, soaked

READERS = "topple.benchmarks.fuzz"
INPUTS = 2000  # broken files for each reader
SEEDS = 20  # runs with each fault
KILLS = 40
ROUNDS = 300  # of orders and worlds in one process: an hour of a robot's work


def rows(quick: bool, seed: int, progress: Progress) -> list[dict[str, Any]]:
    """Break things, and count what holds.

    Args:
        quick: A few of each.
        seed: The first seed.
        progress: Called before each part.

    Returns:
        The bench's rows.
    """
    found = [
        *_readers(100 if quick else INPUTS, seed, progress),
        *_sabotages(quick, progress),
        *_faults(quick, seed, progress),
        *_kills(quick, seed, progress),
        *_soak(quick, progress),
    ]
    return [row.to_json() for row in found]


def _readers(count: int, seed: int, progress: Progress) -> list[Row]:
    if find_spec(READERS) is None:
        return [Row(f"readers tried with broken input ({READERS} is not there)", 0, "readers")]
    counts = import_module(READERS).fuzz_readers(count, seed, progress)
    return [
        Row(f"broken: {one.reader}, {one.inputs} inputs, {one.clean} clean", one.broken, "inputs", bar="<= 0")
        for one in counts
    ]


def _sabotages(quick: bool, progress: Progress) -> list[Row]:
    found = catch(CASES[:1] if quick else CASES, progress)
    tried, escaped = sum(one.tried for one in found), sum(len(one.escaped) for one in found)
    what = f"sabotages caught, of {tried} in {len(found)} plans"
    interval = share_interval(tried - escaped, tried)
    return [Row(what, 100 * (tried - escaped) / tried, "%", bar=">= 100", interval=interval)]


def _faults(quick: bool, seed: int, progress: Progress) -> list[Row]:
    faults = FAULTS[::4] if quick else FAULTS
    seeds = range(seed, seed + (1 if quick else SEEDS))
    return [
        Row(
            f"named or overcome, nothing else disturbed: {count.fault}, {len(count.runs)} runs",
            100 * count.survived / len(count.runs),
            "%",
            bar=">= 100",
            interval=share_interval(count.survived, len(count.runs)),
        )
        for count in inject(faults, seeds, progress)
    ]


def _kills(quick: bool, seed: int, progress: Progress) -> list[Row]:
    found = kill(4 if quick else KILLS, seed, progress)
    refused = refuse(quick, progress)
    wrong = [one.what for one in refused if one.wrong]
    said = f" ({'; '.join(wrong)})" if wrong else ""
    what = f"outputs that find no room and are not refused in a line, of {len(refused)}{said}"
    return [
        *(
            Row(f"left behind: {one.command}, killed {one.kills} times", len(one.left), "", bar="<= 0")
            for one in found
        ),
        Row(what, len(wrong), "", bar="<= 0"),
    ]


def _soak(quick: bool, progress: Progress) -> list[Row]:
    held = soaked(12 if quick else ROUNDS, progress)
    differ = side_by_side(1 if quick else 10, progress)
    what = f"memory after {held.rounds} rounds, last third against the second"
    return [
        Row(what, held.growth, "x", bar=None if quick else "<= 1.05"),
        Row("simulations left open", held.clients, "", bar="<= 0"),
        Row("threads left", held.threads, "", bar="<= 0"),
        Row("files left open", held.files, "", bar="<= 0"),
        Row("orders in threads and processes that are not the serial ones", differ, "", bar="<= 0"),
    ]
