"""Whether topple can be relied on: broken input, spoilt plans, faults in runs, kills, full disks, long work.

A run that a fault spoils counts as survived only where its report names the fault or the goal is reached, and
nothing else was disturbed.
"""

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any, TypeVar

from topple.benchmarks.faults.inject import FAULTS, FaultCount, Run, play
from topple.benchmarks.fuzz import READERS, ReaderCount, fuzz
from topple.benchmarks.kills import kill, refuse
from topple.benchmarks.row import Progress, Row
from topple.benchmarks.sabotages.caught import CASES, catch
from topple.benchmarks.scores import share
from topple.benchmarks.soak import side_by_side, soaked
from topple.topology.base.errors import InvalidInput
from topple.topology.base.workers import all_of, open_executor

INPUTS = 100_000  # broken files, shared out among the readers
QUICK_INPUTS = 2000
SEEDS = 20  # runs with each fault
KILLS = 40
ROUNDS = 500  # of orders and worlds in one process, and a tenth as many plans: an hour of a robot's work
SHOWN = 3  # runs that went wrong whose reports are printed


def rows(quick: bool, seed: int, progress: Progress, part: str | None = None) -> list[dict[str, Any]]:
    """Break things, and count what holds.

    Args:
        quick: A few of each.
        seed: The first seed.
        progress: Called as parts of the work end.
        part: One of `PARTS` alone; the whole takes hours.

    Returns:
        The bench's rows.

    Raises:
        InvalidInput: There is no such part.
    """
    if part is not None and part not in PARTS:
        raise InvalidInput(f"reliability has no part {part!r}: expected one of {', '.join(PARTS)}")
    parts = PARTS if part is None else (part,)
    return [row.to_json() for each in parts for row in PARTS[each](quick, seed, progress)]


Task = TypeVar("Task")
Result = TypeVar("Result")


def _spread(
    work: Callable[[Task], Result], tasks: Sequence[Task], told: Callable[[Result], str], progress: Progress
) -> Iterator[Result]:
    """Do tasks on all cores, and give what comes of them in their order."""
    with open_executor(None) as pool:
        for number, found in enumerate(all_of(work, tasks, pool), start=1):
            progress(f"{number} of {len(tasks)}: {told(found)}")
            yield found


def _readers(quick: bool, seed: int, progress: Progress) -> list[Row]:
    each = max(1, (QUICK_INPUTS if quick else INPUTS) // len(READERS))
    work = partial(_fuzzed, inputs=each, seed=seed)
    counts = _spread(work, range(len(READERS)), lambda one: f"{one.reader}, {one.broken} broken", progress)
    return [
        Row(
            f"broken files read: {one.reader}", one.broken, "broken", bar="<= 0",
            tried=one.inputs, held=one.clean, wrong=one.examples,
        )
        for one in counts
    ]  # fmt: skip


def _fuzzed(reader: int, inputs: int, seed: int) -> ReaderCount:
    return fuzz(READERS[reader], inputs, seed)


def _sabotages(quick: bool, seed: int, progress: Progress) -> list[Row]:
    work = partial(catch, every=4 if quick else 1)
    found = list(
        _spread(work, CASES[:1] if quick else CASES, lambda one: f"sabotages of {one.plan}", progress)
    )
    tried = sum(one.tried for one in found)
    escaped = tuple(f"{name} ({one.plan})" for one in found for name in one.escaped)
    what = f"sabotages caught, in {len(found)} plans"
    return [share(what, tried - len(escaped), tried, ">= 100", counted=True, wrong=escaped)]


def _faults(quick: bool, seed: int, progress: Progress) -> list[Row]:
    faults = FAULTS[::4] if quick else FAULTS
    seeds = range(seed, seed + (1 if quick else SEEDS))
    tasks = [(FAULTS.index(fault), each) for fault in faults for each in seeds]
    runs = list(_spread(_played, tasks, _said, progress))
    found: list[Row] = []
    for fault in faults:
        count = FaultCount(fault.name, tuple(run for run in runs if run.fault == fault.name))
        spoilt = [f"seed {run.seed}: {run.crashed or run.text}" for run in count.runs if not run.survived]
        what = f"fault survived: {count.fault}"
        told, tried = spoilt[:SHOWN], len(count.runs)
        found.append(share(what, count.survived, tried, ">= 100", counted=True, wrong=told))
        found += _ways(count)
    left_out = [fault for fault in FAULTS if fault not in faults]
    if left_out:
        names = "; ".join(fault.name for fault in left_out)
        found.append(Row(f"faults that --quick leaves out: {names}", len(left_out), "", tried=0))
    return found


def _ways(count: FaultCount) -> list[Row]:
    """How runs with one fault ended, side by side."""
    ways = {
        "goal reached": sum(run.reached for run in count.runs),
        "fault named": sum(run.named for run in count.runs),
        "others disturbed": sum(run.disturbed for run in count.runs),
        "dropped": sum(run.dropped for run in count.runs),
        "said reached, was not": sum(run.lied for run in count.runs),
    }
    what = f"{count.fault}, of {len(count.runs)}"
    return [Row(what, held, "", column=way) for way, held in ways.items()]


def _played(task: tuple[int, int]) -> Run:
    fault, seed = task
    return play(FAULTS[fault], seed)


def _said(run: Run) -> str:
    return f"{run.fault}, seed {run.seed}: {'survived' if run.survived else 'NOT survived'}"


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


def _soak(quick: bool, seed: int, progress: Progress) -> list[Row]:
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


PARTS: dict[str, Callable[[bool, int, Progress], list[Row]]] = {
    "readers": _readers,
    "sabotages": _sabotages,
    "faults": _faults,
    "kills": _kills,
    "soak": _soak,
}
"""What is broken, and the work that counts it."""
