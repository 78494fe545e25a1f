"""Which object has to go before which, as others wrote it: VMRD, REGRAD, MetaGraspNet, recorded piles."""

import json
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast
from xml.etree import ElementTree

import networkx as nx
import numpy as np

from topple.benchmarks.scores import Labels
from topple.topology.base.errors import InvalidInput, UnknownObject
from topple.topology.io.archive import read_arrays
from topple.topology.io.clouds import names_in
from topple.topology.io.limits import check_size
from topple.topology.io.strict_json import read_json

EXPECTED = (
    "a recorded pile (.npz with labels), {then: {first: 1, 0 or null}} or an mrt.json of REGRAD (.json), an "
    "annotation of VMRD (.xml), or an order.csv of MetaGraspNet (.csv)"
)
SEGMENT_STEP, SEGMENT_START = 10, 1
"""REGRAD's picture of segments has 10 id + 1 where object id is."""


@dataclass(frozen=True)
class Truth:
    """Labels of one scene.

    Attributes:
        format: What they were read from: "pile", "labels", "frame", "REGRAD", "VMRD" or "MetaGraspNet".
        labels: then -> first -> 1 where it had to go first, 0 where not, None where nobody can tell.
        aliases: Other names that a scene may have for the objects, each naming all of them or most.
    """

    format: str
    labels: Labels
    aliases: tuple[Mapping[str, str], ...] = ()

    def named(self, objects: Collection[str]) -> Labels:
        """The labels under the names that a scene has for its objects.

        What only stands before others gets a row as well: nobody can tell what had to go before it.

        Args:
            objects: The scene's names.

        Raises:
            UnknownObject: The scene has none of the labelled objects under any of the names.
        """
        ways: list[Mapping[str, str]] = [{name: name for name in self.labels}, *self.aliases]
        best = max(ways, key=lambda way: len({way.get(name) for name in self.labels} & set(objects)))
        listed = {name: None for y, row in self.labels.items() for name in (y, *row)}
        names = {name: best.get(name, name) for name in listed}
        if not set(names.values()) & set(objects):
            raise UnknownObject(", ".join(self.labels), objects, role="labelled objects")
        return {names[y]: {names[x]: value for x, value in self.labels.get(y, {}).items()} for y in listed}


def read_truth(path: Path) -> Truth:
    """Read labels, told apart by what the file's name ends in and by content.

    A tree says what has to go directly before what; what follows counts as said, all else as denied.

    Args:
        path: A recorded pile, plain labels, or an annotation of one of the data sets.

    Returns:
        The labels.

    Raises:
        InvalidInput: The file is none of these or broken; one line that names it.
    """
    readers: Mapping[str, Callable[[Path], Truth]] = {
        ".npz": _pile, ".json": _json, ".xml": _vmrd, ".csv": _metagraspnet
    }  # fmt: skip
    reader = readers.get(path.suffix.lower())
    try:
        if not path.is_file():
            raise InvalidInput("no such file")
        if reader is None:
            raise InvalidInput(f"cannot tell what labels these are: expected {EXPECTED}")
        check_size(path.stat().st_size, "the file")
        return reader(path)
    except InvalidInput as error:
        raise InvalidInput(f"{path}: {error}") from error
    except (OSError, UnicodeDecodeError) as error:
        raise InvalidInput(f"{path}: cannot be read: {error}") from error


def _pile(path: Path) -> Truth:
    arrays = read_arrays(path)
    if "labels" not in arrays or arrays["labels"].dtype.kind not in "US" or arrays["labels"].size != 1:
        raise InvalidInput(f"holds no text called labels: expected {EXPECTED}")
    return Truth("pile", _checked(read_json(names_in(arrays["labels"])[0], "labels")))


def _json(path: Path) -> Truth:
    document: Any = read_json(path.read_text(encoding="utf-8"), "the file")
    if not isinstance(document, dict) or not document:
        raise InvalidInput(f"is no object of names: expected {EXPECTED}")
    rows = cast(dict[str, Any], document)
    if "removal_constraints" in rows:
        try:
            return _frame(rows)
        except (AttributeError, IndexError, TypeError, ValueError) as error:
            raise InvalidInput(
                "is no annotated frame: expected removal_constraints [[first, then], ...], and of those in "
                'doubt their places, "doubtful": {"removal_constraints": [0, ...]}'
            ) from error
    if all(isinstance(row, dict) for row in rows.values()):
        return Truth("labels", _checked(rows))
    if all(isinstance(row, list) for row in rows.values()):
        return _regrad(rows)
    raise InvalidInput(f"is neither labels nor a tree: expected {EXPECTED}")


def _frame(rows: Mapping[str, Any]) -> Truth:
    """An annotated camera frame: direct constraints, and pairs that its annotator was not sure of."""
    pairs = [(str(first), str(then)) for first, then in rows["removal_constraints"]]
    doubtful = rows.get("doubtful", {}).get("removal_constraints", ())
    unsure = [pairs[k] for k in doubtful]
    for a, b, *_ in rows.get("uncertain_pairs", ()):
        unsure += [(str(a), str(b)), (str(b), str(a))]
    listed = [str(name) for row in (*rows.get("relations", ()), *pairs) for name in row[:2]]
    return Truth("frame", _closed(listed, pairs, unsure))


def _regrad(rows: Mapping[str, Any]) -> Truth:
    """REGRAD: each object with its parents, which are what it lies on."""
    for name, parents in rows.items():
        for parent in parents:
            if not isinstance(parent, str) or parent not in rows:
                raise InvalidInput(f"{name!r} has the parent {parent!r}, which is no object of the tree")
    numbers = {name: name.rpartition("-")[2] for name in rows}
    segments = {
        name: str(SEGMENT_STEP * int(number) + SEGMENT_START)
        for name, number in numbers.items()
        if number.isdecimal()
    }
    pairs = [(name, parent) for name, parents in rows.items() for parent in parents]
    return Truth("REGRAD", _closed(rows, pairs), (numbers, segments))


def _vmrd(path: Path) -> Truth:
    """VMRD: each object with its fathers, which are what it lies on, and its children, by their indices."""
    try:
        root = ElementTree.fromstring(path.read_bytes())  # in whatever encoding it declares
    except (ElementTree.ParseError, LookupError, ValueError) as error:
        raise InvalidInput(f"is not XML: {error}") from error
    kinds: dict[str, str] = {}
    pairs: list[tuple[str, str]] = []
    for node in root.iter("object"):
        index = (node.findtext("index") or "").strip()
        if not index.isdecimal() or index in kinds:
            raise InvalidInput(f"an object has the index {index!r}: expected whole numbers, each once")
        kinds[index] = (node.findtext("name") or "").strip()
        pairs += [(index, one) for one in _numbers(node, "father")]
        pairs += [(one, index) for one in _numbers(node, "children")]
    if not kinds:
        raise InvalidInput("has no <object>: expected an annotation of VMRD")
    if stray := {one for pair in pairs for one in pair} - kinds.keys():
        raise InvalidInput(f"names objects that it does not have: {', '.join(sorted(stray))}")
    joined = [{key: f"{kind}{mark}{key}" for key, kind in kinds.items()} for mark in ("_", "-", "")]
    unique = len(set(kinds.values())) == len(kinds)
    return Truth("VMRD", _closed(kinds, pairs), (kinds, *joined) if unique else tuple(joined))


def _numbers(node: ElementTree.Element, key: str) -> list[str]:
    return [(number.text or "").strip() for number in node.findall(f"{key}/num")]


def _metagraspnet(path: Path) -> Truth:
    """MetaGraspNet: -1 in row i, column j where object j covers object i, 1 where i covers j; from 1 on."""
    try:
        matrix = np.atleast_2d(np.loadtxt(path, delimiter=",", encoding="utf-8-sig"))
    except ValueError as error:
        raise InvalidInput(f"is no table of numbers: {error}") from error
    if matrix.shape[0] != matrix.shape[1] or not np.isin(matrix, (-1, 0, 1)).all():
        raise InvalidInput(f"is a table {matrix.shape}: expected a square one of -1, 0 and 1")
    names = [str(number + 1) for number in range(len(matrix))]
    over = (matrix.T == -1) | (matrix == 1)  # row covers column
    return Truth("MetaGraspNet", _closed(names, [(names[i], names[j]) for i, j in np.argwhere(over)]))


def _closed(
    names: Iterable[str], pairs: Collection[tuple[str, str]], unsure: Collection[tuple[str, str]] = ()
) -> Labels:
    """Labels of direct pairs (first, then): all that follows from them is true, all else is not."""
    tree: nx.DiGraph[str] = nx.DiGraph()
    tree.add_nodes_from(names)
    tree.add_edges_from(pairs)
    after = set(nx.transitive_closure(tree).edges)
    return {
        then: {
            first: None if (first, then) in unsure else int((first, then) in after)
            for first in tree
            if first != then
        }
        for then in tree
    }


def _checked(rows: object) -> Labels:
    """Labels as they are given, each 1, 0 or null."""
    if not isinstance(rows, dict):
        raise InvalidInput(f"labels hold {json.dumps(rows)[:40]}: expected {{then: {{first: 1, 0 or null}}}}")
    for then, row in cast(dict[str, Any], rows).items():
        if not isinstance(row, dict):
            raise InvalidInput(f"labels of {then!r} are {row!r}: expected {{first: 1, 0 or null}}")
        for first, value in cast(dict[str, Any], row).items():
            if value not in (None, 0, 1):
                raise InvalidInput(f"label {first!r} before {then!r} is {value!r}: expected 1, 0 or null")
    return cast(Labels, rows)
