"""One 3-D view's data: the drawing of a scene with its relation lines, order numbers and dependencies."""

from collections.abc import Mapping
from typing import Any, Protocol, runtime_checkable

from topple.planner.report.drawing import Drawing, thin_path
from topple.planner.report.palette import css, relation_colour
from topple.planner.report.words import because, places, said
from topple.topology.arrays import FloatArray
from topple.topology.sixim.table import ONE_SIDED_CONTACT, Relation

Document = Mapping[str, Any]


@runtime_checkable
class Documented(Protocol):
    """A result that gives its JSON document: Relations, Order."""

    def to_json(self) -> dict[str, Any]:
        """The document of the contract."""
        ...


def document(result: Documented | Document) -> Document:
    """The JSON document of a result, which may be one already."""
    return result if isinstance(result, Mapping) else result.to_json()


def view_data(
    drawing: Drawing,
    relations: Document,
    order: Document | None,
    tool_path: FloatArray | None = None,
    motion: Document | None = None,
) -> dict[str, Any]:
    """What the viewer script reads of one scene.

    Args:
        drawing: The scene as it is drawn.
        relations: Its `topple.relations` document.
        order: Its `topple.order` document, or None.
        tool_path: (k, 3) path of the tool [m], or None.
        motion: What `played.motion_json` gave, or None.

    Returns:
        Plain data, ready for JSON.
    """
    index = object_index(drawing)
    data = drawing.to_json()
    data["relations"] = [
        line for pair in relations.get("relations", ()) if (line := _line(pair, index)) is not None
    ]
    data["converse"] = {str(relation): str(relation.converse) for relation in Relation}
    place = {} if order is None else places(order)
    data["places"] = None if order is None else [place.get(name, 0) for name in index]
    data["dependencies"] = [] if order is None else _dependencies(order, index)
    data["path"] = None if tool_path is None or len(tool_path) == 0 else thin_path(tool_path)
    data["motion"] = motion
    return data


def object_index(drawing: Drawing) -> dict[str, int]:
    """Name -> number of every drawn object."""
    return {drawn.name: number for number, drawn in enumerate(drawing.objects)}


def is_inferred(pair: Mapping[str, Any]) -> bool:
    """The relation was concluded, not seen."""
    return bool(pair.get("inferred", False)) or not pair.get("observed", True)


def _line(pair: Mapping[str, Any], index: Mapping[str, int]) -> dict[str, Any] | None:
    """A relation as a line; disjoint pairs have none, except contact that one side alone shows."""
    a, b, relation, kind = str(pair["a"]), str(pair["b"]), str(pair["relation"]), pair.get("kind")
    faint = relation == Relation.DISJOINT
    if a not in index or b not in index or (faint and kind != ONE_SIDED_CONTACT):
        return None
    return {
        "a": index[a],
        "b": index[b],
        "relation": relation,
        "kind": None if kind is None else str(kind),
        "colour": css(relation_colour(relation)),
        "dashed": faint or is_inferred(pair),
        "faint": faint,
    }


def _dependencies(order: Document, index: Mapping[str, int]) -> list[dict[str, Any]]:
    return [
        {"first": index[first], "then": index[then], "text": because([first], said(dependency))}
        for dependency in order.get("dependencies", ())
        if (first := str(dependency["first"])) in index and (then := str(dependency["then"])) in index
    ]
