"""Whether topple can be relied on: broken input, spoilt plans, faults in runs, kills, full disks, long work.

A run that a fault spoils counts as survived only where its report names the fault or the goal is reached, and
nothing else was disturbed.
"""

from typing import Any

from topple.benchmarks.faults.inject import FAULTS, inject
from topple.benchmarks.fuzz import fuzz_readers
from topple.benchmarks.kills import kill, refuse
from topple.benchmarks.row import Progress, Row
from topple.benchmarks.sabotages.caught import CASES, catch
from topple.benchmarks.scores import share_interval
from topple.benchmarks.soak import side_by_side, soaked

INPUTS = 100_000  # broken files, shared out among the readers
SEEDS = 20  # runs with each fault
KILLS = 40
ROUNDS = 500  # of orders and worlds in one process, and a tenth as many plans: an hour of a robot's work
SHOWN = 3  # runs that went wrong whose reports are printed


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
        *_readers(2000 if quick else INPUTS, seed, progress),
        *_sabotages(quick, progress),
        *_faults(quick, seed, progress),
        *_kills(quick, seed, progress),
        *_soak(quick, progress),
    ]
    return [row.to_json() for row in found]


def _readers(count: int, seed: int, progress: Progress) -> list[Row]:
    return [
        Row(
            f"broken files read: {one.reader}", one.broken, "broken", bar="<= 0",
            tried=one.inputs, held=one.clean, wrong=one.examples,
        )
        for one in fuzz_readers(count, seed, progress)
    ]  # fmt: skip


def _sabotages(quick: bool, progress: Progress) -> list[Row]:
    found = catch(CASES[:1], progress, every=4) if quick else catch(CASES, progress)
    tried = sum(one.tried for one in found)
    escaped = tuple(f"{name} ({one.plan})" for one in found for name in one.escaped)
    return [_share(f"sabotages caught, in {len(found)} plans", tried - len(escaped), tried, escaped)]


def _faults(quick: bool, seed: int, progress: Progress) -> list[Row]:
    faults = FAULTS[::4] if quick else FAULTS
    seeds = range(seed, seed + (1 if quick else SEEDS))
    found: list[Row] = []
    for count in inject(faults, seeds, progress):
        spoilt = [f"seed {run.seed}: {run.crashed or run.text}" for run in count.runs if not run.survived]
        what = f"fault survived: {count.fault}"
        found.append(_share(what, count.survived, len(count.runs), tuple(spoilt[:SHOWN])))
    left_out = [fault for fault in FAULTS if fault not in faults]
    if left_out:
        names = "; ".join(fault.name for fault in left_out)
        found.append(Row(f"faults that --quick leaves out: {names}", len(left_out), "", tried=0))
    return found


def _share(what: str, held: int, tried: int, wrong: tuple[str, ...]) -> Row:
    """A share of which nothing may be missing."""
    interval = share_interval(held, tried)
    share = 100 * held / tried
    return Row(what, share, "%", bar=">= 100", interval=interval, tried=tried, held=held, wrong=wrong)


def _kills(quick: bool, seed: int, progress: Progress) -> list[Row]:
    found = [
        Row(
            f"killed, nothing left: {one.command}", len(one.left), "left", bar="<= 0",
            tried=one.kills, held=one.clean, wrong=one.left,
        )
        for one in kill(4 if quick else KILLS, seed, progress)
    ]  # fmt: skip
    refused = refuse(quick, progress)
    wrong = tuple(f"{one.what}: {one.wrong}" for one in refused if one.wrong)
    what, held = "no room for output, refused in a line", len(refused) - len(wrong)
    return [*found, Row(what, len(wrong), "wrong", bar="<= 0", tried=len(refused), held=held, wrong=wrong)]


def _soak(quick: bool, progress: Progress) -> list[Row]:
    held = soaked(9 if quick else ROUNDS, progress)
    tried, differ = side_by_side(1 if quick else 10, progress)
    what = f"memory after {held.rounds} rounds, last third against the second"
    return [
        Row("memory of the last third", held.megabytes, "MB"),
        Row(what, held.growth, "x", bar=None if quick else "<= 1.05"),
        Row("simulations left open", held.clients, "", bar="<= 0"),
        Row("threads left", held.threads, "", bar="<= 0"),
        Row("files left open", held.files, "", bar="<= 0"),
        Row(
            "orders in threads and processes, as serial", differ, "other", bar="<= 0",
            tried=tried, held=tried - differ,
        ),
    ]  # fmt: skip
