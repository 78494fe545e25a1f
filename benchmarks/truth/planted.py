"""Faults and refactorings planted into copies of topple: does the gate tell them apart?

`python -m topple.benchmarks.truth.planted [NAME ...]` runs the scenes of every run on a copy with each fault,
view by view until a floor is broken, and prints which: a fault has to break one. The refactorings are planted
into one copy together, which has to break none. A change is a text in one file that stands there once; where
the code has changed so that it does not, its entry has to be written anew.
"""

import argparse
import hashlib
import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from topple.benchmarks.truth.answers import answers
from topple.benchmarks.truth.cases import few, pool_cases
from topple.benchmarks.truth.floors import Floors
from topple.benchmarks.truth.gate import FLOORS, FOLDER, broken
from topple.benchmarks.truth.views import VIEWS
from topple.benchmarks.versions import Version, code_key, today
from topple.planner.cli.console import print_text
from topple.topology.base.errors import InvalidInput


@dataclass(frozen=True)
class Change:
    """A change of one place.

    Attributes:
        name: What it is.
        file: Where, from the root.
        before: What stands there, once.
        after: What is put in its place.
        fault: Whether it is a fault; else what it says is the same.
    """

    name: str
    file: str
    before: str
    after: str
    fault: bool = True

    def plant(self, folder: Path) -> None:
        """Make the change in a copy.

        Args:
            folder: The copy's.

        Raises:
            InvalidInput: The text does not stand there once.
        """
        path = folder / "topple" / self.file
        text = path.read_text(encoding="utf-8")
        if text.count(self.before) != 1:
            raise InvalidInput(
                f"{self.name}: {self.file} has its text {text.count(self.before)} times, not once"
            )
        path.write_text(text.replace(self.before, self.after), encoding="utf-8")


def planted(changes: Sequence[Change], version: Version, cache: Path) -> Version:
    """A copy of a version with changes.

    Args:
        changes: What is planted.
        version: What is copied.
        cache: Folder of versions.
    """
    name = "; ".join(change.name for change in changes)
    folder = cache.resolve() / f"planted-{hashlib.sha256(name.encode()).hexdigest()[:12]}"
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(version.folder, folder)
    for change in changes:
        change.plant(folder)
    code_key.cache_clear()
    return Version(name, code_key(folder / "topple"), folder)


_CONTACT = "topology/statics/contact.py"
_SWEEP = "topology/statics/sweep.py"
_DEPENDENCY = "planner/decide/dependency.py"
_ROBUST = "topology/relations/robust.py"

CHANGES = (
    Change(
        "a term dropped: what is over a table stands on it, however high", _CONTACT,
        "near = over & (heights < reach)", "near = over",
    ),
    Change(
        "a sign: what hangs over needs a push aside", _SWEEP,
        "return Overlap(evasion,", "return Overlap(-evasion,",
    ),
    Change(
        "normals turned", _CONTACT,
        "normals = np.where(offsets[:, None] < 0, -normals, normals)",
        "normals = np.where(offsets[:, None] > 0, -normals, normals)",
    ),
    Change(
        "one contact lost in ten", _CONTACT,
        "return tuple(with_friction(contact, upright.friction) for contact in found)",
        "from zlib import crc32\n\n"
        "    kept = (c for c in found if crc32(f'{c.a} {c.b}'.encode()) % 10 != 7)\n"
        "    return tuple(with_friction(contact, upright.friction) for contact in kept)",
    ),
    Change(
        "the table 5 mm low", "topology/statics/grounds.py",
        "return points @ self.normal + self.offset", "return points @ self.normal + self.offset + 0.005",
    ),
    Change(
        "what falls is not asked", "planner/decide/disturbance.py",
        "unheld[then].get(first, 0.0) if (first, then) in together else 0.0", "0.0",
    ),
    Change(
        "a pixel is its mask's whatever its depth", "topology/views/borders.py",
        "    found[wrong] = owner\n", "    found[wrong] = picture.label[wrong]\n",
    ),
    Change(
        "nothing is completed where cameras look", "topology/bodies/surfaces.py",
        "self._done.update(complete(self.upright.among(missing), self.sight))",
        "self._done.update(self.upright.among(missing).clouds)",
    ),
    Change(
        "what lies in something only touches it", _ROBUST,
        "if counts[0] < _least(a.size):\n", "if True:\n",
    ),
    Change(
        "centres of mass 3 cm aside", "topology/statics/rest.py",
        "    centre = middle_of(points) if centre is None else centre\n",
        "    centre = middle_of(points) + np.array([0.03, 0.0, 0.0])\n",
    ),
    Change(
        "a sum in another order", _CONTACT,
        "return np.add.reduceat(self._along(directions), self._starts) / self.counts",
        "ends = np.cumsum(self._along(directions))[self._starts + self.counts - 1]\n"
        "        return np.diff(ends, prepend=0.0) / self.counts",
        fault=False,
    ),
    Change(
        "a scatter matrix by a product", _CONTACT,
        "values, vectors = np.linalg.eigh(outer / (counts - 1)[:, None, None])",
        "values, vectors = np.linalg.eigh(outer)\n    values = values / (counts - 1)[:, None]",
        fault=False,
    ),
    Change(
        "middles by a mean", _CONTACT,
        "middles = (candidates[close] + first[nearest[close]]) / 2",
        "middles = np.mean([first[nearest[close]], candidates[close]], axis=0)",
        fault=False,
    ),
    Change(
        "a name and a local variable", _SWEEP,
        "    ceiling = heights_over(upper, low, SWEEP_CELL, size, highest=True)\n"
        "    height = ceiling - heights_over(lower, low, SWEEP_CELL, size, highest=False)",
        "    floor = heights_over(lower, low, SWEEP_CELL, size, highest=False)\n"
        "    ceiling = heights_over(upper, low, SWEEP_CELL, size, highest=True)\n"
        "    height = -(floor - ceiling)",
        fault=False,
    ),
    Change(
        "an area the other way round", _SWEEP,
        "evasion, len(cells) * SWEEP_CELL**2", "evasion, SWEEP_CELL * (SWEEP_CELL * len(cells))",
        fault=False,
    ),
    Change(
        "edges in another order", _DEPENDENCY,
        "return DependencyGraph(situation.movable, tuple(edges)),",
        "return DependencyGraph(situation.movable, tuple(sorted(edges, key=lambda e: (e.then, e.first)))),",
        fault=False,
    ),
    Change(
        "pairs by two loops", "planner/decide/disturbance.py",
        "key=lambda pair: (place[pair[0]], place[pair[1]])",
        "key=lambda pair: (place[pair[1]], place[pair[0]])",
        fault=False,
    ),
    Change(
        "an angle by its sine", _CONTACT,
        "leaning = np.arccos(np.minimum(1.0, np.abs(normals @ plane.normal)))",
        "upright_ = np.minimum(1.0, np.abs(normals @ plane.normal))\n"
        "    leaning = np.arctan2(np.sqrt(1.0 - upright_**2), upright_)",
        fault=False,
    ),
    Change(
        "a count by a sum", _ROBUST,
        "beyond = int(np.count_nonzero(b.hull.facet_distance(a.coarse[exterior]) > 0))",
        "beyond = int(sum(b.hull.facet_distance(a.coarse[exterior]) > 0))",
        fault=False,
    ),
    Change(
        "distances in a tree of a copy", _CONTACT,
        "_tree_of = remember(KEPT_BODIES)(PointTree)",
        "_tree_of = remember(KEPT_BODIES)(lambda points: PointTree(points.copy()))",
        fault=False,
    ),
)  # fmt: skip
"""Ten faults, then ten refactorings."""


def main(arguments: Sequence[str] | None = None) -> None:
    """Plant each and print what breaks."""
    parser = argparse.ArgumentParser(
        description="Plant faults and refactorings, and see which the gate notices."
    )
    parser.add_argument("name", nargs="*", help="parts of names; all of them where not given")
    wanted = parser.parse_args(arguments).name
    cache, floors = FOLDER / "versions", Floors.read(FLOORS)
    version, cases = today(cache), pool_cases(few(), FOLDER / "given", lambda text: None)
    some = [c for c in CHANGES if not wanted or any(part in c.name for part in wanted)]
    alike = [change for change in some if not change.fault]
    for changes in [*([change] for change in some if change.fault), *([alike] if alike else [])]:
        copy = planted(changes, version, cache)
        below: list[str] = []
        for view in VIEWS:
            seen = [case for case in cases if case.view == view]
            found = answers(copy, [case.question for case in seen], FOLDER / "answers", lambda text: None)
            below += broken(floors, seen, found)
            if below:
                break
        fault = changes[0].fault
        kind = "fault" if fault else f"{len(changes)} refactorings"
        verdict = f"{len(below)} floors broken" if below else "no floor broken"
        print_text(
            f"{'ok    ' if bool(below) == fault else 'WRONG '} {kind}: {copy.name}: {verdict}",
            *(f"    {one}" for one in below),
        )
        shutil.rmtree(copy.folder)


if __name__ == "__main__":
    main()
