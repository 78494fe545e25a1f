"""What topple does, as a stated version and as digests: equal where it answers and acts the same.

A digest is of what the contract names, not of how it is come by. Modules, sentences that explain, wall-clock
times and keys that a document has besides leave it as it is. Numbers are rounded to `DIGITS` first.
"""

import hashlib
import json
from collections.abc import Mapping, Sequence
from typing import Any

BEHAVIOUR = 8
"""Version of what topple does. Raise it by one with every change that is meant and that `topple bench frozen`
reports, then run `topple bench frozen --data DIR --write`. Results in the journals of benches count as long
as it stays the same."""

PLAYS_LIKE = frozenset({7})
"""Earlier versions whose episodes count, too: they went digit for digit as today's wherever both were played.
Empty it with the next change, unless that is shown again."""

REARRANGING: Mapping[str, int] = {"set-table": 4, "restack": 4, "pack": 4, "swap": 4}
"""Version of how each scene is played in which things are put as they lie in another one. Raise it by one
with every change that is meant and that the scene's episodes show, since no frozen case does it: earlier
results of the scene then do not count."""


MASKS = 1
"""Version of what is made of masks that are off. Raise it by one with every change of that alone: what was
played with exact masks counts on."""

DIGITS = 5
"""Decimals that count: steps of 0.01 mm or 0.01 mrad. What is to be noticed, 0.1 mm, is ten of them and never
lost; the noise of sums in another order, at most 1e-12, changes one number in ten million."""

Paths = Mapping[str, Sequence[str]]
"""Part of a document, as a difference is told -> its keys, as "relations.gap" for every relation's gap."""

RELATIONS: Paths = {
    "objects": ("objects", "deviation"),
    "relations": ("relations.a", "relations.b", "relations.relation"),
    "matrices": ("relations.matrix",),
    "gaps": ("relations.gap", "relations.gap_exact"),
    "confidence": ("relations.confidence", "relations.observed"),
}
ORDER: Paths = {
    "order": ("targets", "order"),
    "dependencies": ("dependencies.first", "dependencies.then", "dependencies.reason"),
    "supports": ("supports.supporter", "supports.supported"),
    "cycles": ("groups", "unresolved"),
    "confidence": ("dependencies.confidence", "supports.confidence"),
    "risk": ("risk",),
    "access": ("access.first", "access.then", "access.reason"),
}
PLAN: Paths = {
    "steps": ("goal", "robot", "order", "steps.object", "steps.action", "steps.after", "steps.upright"),
    "dependencies": ("dependencies.first", "dependencies.then", "dependencies.reason"),
    "start": ("joints", "q_start", "pose_base_to_world", "base_searched", "up"),
    "grasps": (
        "steps.grasp.kind", "steps.grasp.pose_tool_to_world", "steps.grasp.width", "steps.grasp.score",
        "steps.attachments.object", "steps.attachments.tool", "steps.attachments.pose_start_to_tool",
    ),
    "placements": ("steps.placement.pose_before_to_after", "steps.placement.drop", "steps.placement.into"),
    "segments": (
        "steps.segments.kind", "steps.segments.tool", "steps.segments.holding",
        "steps.segments.hand.opening", "steps.segments.hand.cup_extension",
    ),
    "motions": (
        "steps.segments.motion.times", "steps.segments.motion.positions", "steps.segments.motion.velocities",
        "seconds",
    ),
    "proofs": (
        "steps.segments.may_touch", "steps.segments.certified", "steps.segments.clearance", "certified",
    ),
    "objects": ("objects.name", "objects.fixed", "objects.parts", "objects.whole"),
}  # fmt: skip
EPISODE: Paths = {
    "actions": ("steps.object", "steps.action"),
    "outcome": ("success", "stopped", "violations"),
    "arm time": ("steps.robot_seconds",),
}

_FACTS = {
    "dependencies": ("first", "then"),
    "supports": ("supporter", "supported"),
    "access": ("first", "then"),
}
"""Lists that no order is promised of, and what tells their entries apart."""


def digest(document: Mapping[str, Any], paths: Paths) -> dict[str, str]:
    """Digest a JSON document, part by part.

    Args:
        document: As `to_json` gives it.
        paths: What of it counts; a key that is missing counts as null.

    Returns:
        Part -> eight hexadecimal digits.
    """
    told = {
        **document,
        **{key: _told_apart(document[key], by) for key, by in _FACTS.items() if key in document},
    }
    return {part: _hash([_column(told, path.split(".")) for path in some]) for part, some in paths.items()}


def rounded(value: Any) -> Any:
    """Round every number of JSON data; whole numbers and decimals that are equal become the same.

    Args:
        value: JSON data.

    Returns:
        The data, numbers as text with `DIGITS` decimals.
    """
    if isinstance(value, Mapping):
        return {str(key): rounded(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [rounded(entry) for entry in value]
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return f"{round(float(value), DIGITS) + 0.0:.{DIGITS}f}"  # + 0.0: no -0.00000
    return value


def _told_apart(entries: Sequence[Mapping[str, Any]], by: Sequence[str]) -> list[Mapping[str, Any]]:
    return sorted(entries, key=lambda entry: [str(entry.get(key)) for key in by])


def _column(value: Any, path: Sequence[str]) -> Any:
    """What stands under a path, of each entry where there is a list on the way."""
    if not path or value is None:
        return rounded(value)
    if isinstance(value, (list, tuple)):
        return [_column(entry, path) for entry in value]
    return _column(value.get(path[0]), path[1:])


def _hash(value: Any) -> str:
    text = json.dumps(value, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()[:8]
