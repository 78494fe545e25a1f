"""Relations read from JSON, topple's own or another program's."""

from collections.abc import Mapping
from dataclasses import replace
from math import inf, isfinite
from types import NoneType
from typing import Any

import numpy as np

from topple.topology.base.errors import InvalidInput
from topple.topology.sixim.pair import PairRelation
from topple.topology.sixim.relation_table import FORMAT, FORMAT_VERSION, AnyTable, RelationTable


def deviation_of(document: Mapping[str, Any]) -> float | None:
    """The deviation factor [m] with which a document says that its relations were found; None where not.

    Args:
        document: See `Relations.from_json`.

    Raises:
        InvalidInput: It is none of relations, or its deviation is no number.
    """
    _entries(document)
    deviation = document.get("deviation")
    return None if deviation is None else _number(deviation, "deviation")


def told_in(document: Mapping[str, Any], relations: AnyTable) -> AnyTable:
    """Relations as a document tells them.

    Args:
        document: See `Relations.from_json`.
        relations: What was found of the same scene: it stays where the document says nothing.

    Raises:
        InvalidInput: The document is not what it should be; says where.
        UnknownObject: A pair names an object that is not in the scene.
    """
    entries = _entries(document)
    told: set[frozenset[str]] = set()
    for place, entry in enumerate(entries):
        where = f"relations[{place}]"
        if not isinstance(entry, Mapping) or not all(isinstance(entry.get(key), str) for key in "ab"):
            raise InvalidInput(f"{where}: expected an object with the names 'a' and 'b', and a 'relation'")
        pair = frozenset((entry["a"], entry["b"]))
        if pair in told:
            raise InvalidInput(f"{where}: {entry['a']} and {entry['b']} are told twice")
        told.add(pair)
        relations = relations.with_pair(_pair(entry, relations, where))
    return relations


def _entries(document: Mapping[str, Any]) -> list[Any]:
    entries = document.get("relations") if isinstance(document, Mapping) else None  # type: ignore
    told = {"format": FORMAT, "format_version": FORMAT_VERSION}
    if not isinstance(entries, list) or any(document.get(key, value) != value for key, value in told.items()):
        raise InvalidInput(
            f"no relations: expected a {FORMAT!r} document of version {FORMAT_VERSION} with a list "
            "'relations'"
        )
    return entries


def _pair(entry: Mapping[str, Any], relations: RelationTable, where: str) -> PairRelation:
    """The pair as it is told; what is not told of it stays as it was found."""
    known = relations.with_relation(entry["a"], entry["b"], entry.get("relation", "")).between(
        entry["a"], entry["b"]
    )
    for key in ("kind", "reason"):
        if not isinstance(entry.get(key), (str, NoneType)):
            raise InvalidInput(f"{where}.{key}: expected text or null")
    told: dict[str, Any] = {"inferred": bool(entry.get("inferred", False)), "kind": entry.get("kind")}
    if "matrix" in entry:
        told["reason"] = entry.get("reason")
    if "gap" in entry:
        told["distance"] = _number(entry["gap"], f"{where}.gap")
        told |= {"gap_exact": bool(entry.get("gap_exact", True)), "least_gap": -inf}
    if "confidence" in entry:
        told["confidence"] = _number(entry["confidence"], f"{where}.confidence")
        if not 0.0 <= told["confidence"] <= 1.0:
            raise InvalidInput(f"{where}.confidence: {entry['confidence']} is no number from 0 to 1")
    if "observed" in entry:
        told["observed"] = bool(entry["observed"])
    if "matrix" in entry:
        told["counts"] = _matrix(entry["matrix"], f"{where}.matrix")
    return replace(known, **told)


def _number(value: Any, where: str) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not isfinite(value):
        raise InvalidInput(f"{where}: {value!r} is no number")
    return float(value)


def _matrix(value: Any, where: str) -> "np.ndarray[Any, np.dtype[np.int64]]":
    try:
        matrix = np.asarray(value, dtype=np.int64)
    except (TypeError, ValueError, OverflowError):
        matrix = np.empty(0, dtype=np.int64)
    if matrix.shape != (2, 3) or (matrix < 0).any():
        raise InvalidInput(f"{where}: expected 2 x 3 counts, [[A∩B°, A∩∂B, A∩B⁻], [A°∩B, ∂A∩B, A⁻∩B]]")
    return matrix
