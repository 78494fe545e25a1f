"""Whether topple still does what it did: digests of episodes, relations, orders and plans, kept in a file.

Computed anew and compared with the file are

- closed-loop episodes of the built-in scenes: what was done to which object, what went wrong, the arm's time;
- relations and orders of generated piles seen whole, by one and by three cameras; with `--data DIR` also of
  every recorded frame in that folder, and of the piles in `piles` beside it or in `--piles DIR`;
- plans of built-in scenes for three arms: steps, grasps, placements, motions.

Every item that differs is told with what it was and what it is. With `--write` the file is made anew; where
something differs that is refused until `BEHAVIOUR` in `behaviour.py` is raised by hand, so that no change of
behaviour goes unsaid. What simulations begin with is rounded, since they carry the last bit of a sum on to
millimetres; still, digests of another processor or another numpy may differ where nothing in topple does.
`--file FILE` keeps a file of one's own for such a machine.
"""

import json
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import msgspec

from topple.benchmarks.behaviour import BEHAVIOUR
from topple.benchmarks.document import machine
from topple.benchmarks.frozen_cases import Case, Item, cases
from topple.benchmarks.row import Progress, Row
from topple.planner.formats.files import check_writable, write_whole
from topple.topology.errors import InvalidInput
from topple.topology.io.strict_json import read_json
from topple.topology.workers import Lost, WorkerLost, WorkerPool, mapped, serve

FILE = Path(__file__).with_name("frozen.json")
FORMAT, FORMAT_VERSION = "topple.frozen", 1
PROCESSES = 2
"""Each holds half a gigabyte."""

Items = dict[str, Item]


@dataclass(frozen=True)
class Frozen:
    """What a file holds.

    Attributes:
        behaviour: Version of behaviour that it is of.
        machine: What it was computed on.
        own: Items that topple makes by itself, by what they are.
        recorded: Items of recorded data.
    """

    behaviour: int = BEHAVIOUR
    machine: Mapping[str, Any] = field(default_factory=machine)
    own: Items = field(default_factory=dict[str, Item])
    recorded: Items = field(default_factory=dict[str, Item])

    @property
    def items(self) -> Items:
        """All of them."""
        return {**self.own, **self.recorded}

    def text(self) -> str:
        """The file, one item a line."""
        head = {
            "format": FORMAT, "format_version": FORMAT_VERSION,
            "behaviour": self.behaviour, "machine": self.machine,
        }  # fmt: skip
        lines = [f' "{key}": {json.dumps(value)}' for key, value in head.items()]
        for key in ("own", "recorded"):
            items: Items = getattr(self, key)
            said = ",\n".join(f"  {json.dumps(asdict(items[what]))}" for what in sorted(items))
            lines.append(f' "{key}": [\n{said}\n ]' if said else f' "{key}": []')
        return "{\n" + ",\n".join(lines) + "\n}\n"

    @staticmethod
    def read(path: Path) -> "Frozen":
        """Read a file.

        Args:
            path: Where it is.

        Raises:
            InvalidInput: It cannot be read, or is something else.
        """
        try:
            entry = read_json(path.read_text(encoding="utf-8"), str(path))
            if (entry["format"], entry["format_version"]) != (FORMAT, FORMAT_VERSION):
                raise ValueError(f"its format is {entry['format']} {entry['format_version']}")
            kept = (msgspec.convert(entry[key], list[Item]) for key in ("own", "recorded"))
            own, recorded = ({item.what: item for item in items} for items in kept)
            behaviour = msgspec.convert(entry["behaviour"], int)
            return Frozen(behaviour, msgspec.convert(entry["machine"], dict[str, Any]), own, recorded)
        except OSError as error:
            raise InvalidInput(f"{path}: nothing is frozen there ({error}): --write makes it") from error
        except (ValueError, KeyError, TypeError) as error:
            raise InvalidInput(f"{path}: holds no frozen behaviour ({error}): give another file") from error


@dataclass(frozen=True)
class Difference:
    """An item that is not what it was.

    Attributes:
        what: The item.
        parts: Those of its digest that differ.
        was: Summary in the file.
        now: Summary today.
    """

    what: str
    parts: tuple[str, ...]
    was: str
    now: str


def rows(
    quick: bool,
    seed: int,
    progress: Progress,
    *,
    data: Path | None = None,
    piles: Path | None = None,
    file: Path = FILE,
    write: bool = False,
) -> list[dict[str, Any]]:
    """Compute and compare, and write where that is asked for.

    Args:
        quick: A subset that takes below a minute.
        seed: 0: what is frozen has seeds of its own.
        progress: Called as items are done.
        data: A folder of recorded frames.
        piles: A folder of recorded piles; `piles` beside `data` where None.
        file: What is compared with, and written.
        write: Make the file anew.

    Returns:
        The bench's rows; that of the items that differ has them as `differences`.

    Raises:
        InvalidInput: There is nothing to compare with, the file cannot be written, or would lose items that
            were not computed.
    """
    if seed:
        raise InvalidInput(f"--seed {seed}: what is frozen has seeds of its own: leave --seed out")
    recorded = data is not None or piles is not None
    before = Frozen() if write and not file.exists() else Frozen.read(file)
    if write:
        check_writable(str(file))
        _check_whole(before, quick, recorded)
    now = _computed(cases(quick, data, piles), progress)
    expected = {} if quick else {**before.own, **(before.recorded if recorded else {})}
    found = differences(before.items, now.items, expected)
    refused = write and bool(found) and before.behaviour >= BEHAVIOUR
    if write and not refused:
        write_whole(file, merged(before, now).text())
    return [row.to_json() for row in _figures(before, now, write and not refused)] + [
        _told(found, len(now.items), write, refused)
    ]


def differences(before: Items, now: Items, expected: Items) -> list[Difference]:
    """Compare.

    Args:
        before: What the file holds.
        now: What was computed.
        expected: What had to be computed.

    Returns:
        What differs, and what is not there any more; what is new differs from nothing.
    """
    found = [
        Difference(what, tuple(parts), before[what].summary, item.summary)
        for what, item in now.items()
        if what in before and (parts := _parts(before[what].digest, item.digest))
    ]
    gone = [what for what in expected if what not in now]
    return found + [Difference(what, (), before[what].summary, "not there any more") for what in gone]


def merged(before: Frozen, now: Frozen) -> Frozen:
    """What is to be kept: of the same version what was not computed too, of a raised one today's alone.

    Args:
        before: What the file holds.
        now: What was computed.
    """
    if before.behaviour != now.behaviour:
        return now
    return Frozen(now.behaviour, now.machine, {**before.own, **now.own}, {**before.recorded, **now.recorded})


def _parts(before: Mapping[str, str], now: Mapping[str, str]) -> list[str]:
    return [part for part in {**before, **now} if before.get(part) != now.get(part)]


def _check_whole(before: Frozen, quick: bool, recorded: bool) -> None:
    if before.behaviour > BEHAVIOUR:
        raise InvalidInput(
            f"the file is of behaviour {before.behaviour}, topple of {BEHAVIOUR}: raise BEHAVIOUR"
        )
    if before.behaviour < BEHAVIOUR and (quick or (before.recorded and not recorded)):
        raise InvalidInput(
            "the version of behaviour was raised, so that nothing of the file stays: leave --quick out"
            + (" and give --data, which it has items of" if before.recorded else "")
        )


def _computed(wanted: Sequence[Case], progress: Progress) -> Frozen:
    now = Frozen()
    for number, (case, items) in enumerate(_as_done(wanted), 1):
        progress(f"{number} of {len(wanted)}: {case.what}")
        (now.recorded if case.recorded else now.own).update({item.what: item for item in items})
    return now


def _as_done(wanted: Sequence[Case]) -> Iterator[tuple[Case, tuple[Item, ...]]]:
    with WorkerPool(PROCESSES, _begin) as pool:
        for done in mapped(_items, wanted, pool, in_turn=False):
            if isinstance(done, Lost):
                raise WorkerLost(f"{done.task.what}: the process that computed it was lost twice")
            yield done


def _items(case: Case) -> tuple[Case, tuple[Item, ...]]:
    return case, case.items()


def _begin() -> None:
    """Ready a process: time that a search may take counts as work, so that a busy machine finds the same."""
    serve()
    time.monotonic = time.process_time


def _figures(before: Frozen, now: Frozen, written: bool) -> list[Row]:
    version = now.behaviour if written else before.behaviour
    libraries = sum(
        now.machine[key] != before.machine.get(key) for key in ("processor", "python", "libraries")
    )
    new, left = (len(a.items.keys() - b.items.keys()) for a, b in ((now, before), (before, now)))
    return [
        Row("version of behaviour in the file", version, "", bar=str(BEHAVIOUR)),
        Row("of processor, Python and libraries, other than the file's", libraries, "of 3"),
        Row("items that were not in the file", new, ""),
        Row("items of the file that were not computed", left, ""),
    ]


def _told(found: Sequence[Difference], computed: int, write: bool, refused: bool) -> dict[str, Any]:
    """The row of what differs; without a bar where that was meant and has been written."""
    what = f"items that differ, of {computed} computed"
    what += f"; not written: raise BEHAVIOUR, which is {BEHAVIOUR}" if refused else ""
    bar = None if write and not refused else "0"
    return {**Row(what, len(found), "", bar=bar).to_json(), "differences": [asdict(one) for one in found]}
