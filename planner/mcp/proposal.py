"""A proposal to take something next, accepted or refused, with all that the answer rests on."""

from collections.abc import Iterable
from typing import Any

from topple.planner.decide.arrange import Order
from topple.planner.decide.dependency import dependencies
from topple.planner.planning.order import check_targets, order
from topple.planner.stability.check import check
from topple.topology.base.errors import InvalidInput
from topple.topology.situation.situation import Situation
from topple.topology.sixim.table import Relation


def judge_proposal(situation: Situation, take: str, gone: Iterable[str] = ()) -> dict[str, Any]:
    """Ask whether an object may be taken next.

    Args:
        situation: The scene.
        take: What shall be taken.
        gone: What has been taken before.

    Returns:
        `accepted`, a `reason` in a sentence, `first`, what has to go before in this order, and the
        `certificate`: `dependencies` with the relations that they rest on, `swept`, the relation of the
        object, with all that it passes when lifted, to each that it meets, and those it `clears`;
        `contacts` of the object, each with a place and a normal in the scene's frame [m]; `check`, what
        holds it and what it carries, with forces [N].

    Raises:
        InvalidInput: The object is fixed, is gone, or hangs on a wrong mask; or the scene has no `up`.
        UnknownObject: There is no such object.
    """
    gone = check_targets(situation.scene, tuple(gone))
    check_targets(situation.scene, take)
    if take in gone:
        raise InvalidInput(f"{take} is among what is gone: propose one of those that are left")
    left = situation.without(*gone) if gone else situation
    found = order(left, take)
    return {
        "format": "topple.proposal", "format_version": 1, "take": take, "gone": list(gone),
        "accepted": found.order == (take,), "reason": _reason(found, take),
        "first": [name for name in found.order if name != take], "risk": round(found.risk.get(take, 0.0), 3),
        "certificate": _certificate(left, take), "assumptions": list(found.assumptions),
    }  # fmt: skip


def _reason(found: Order, take: str) -> str:
    before = found.graph.before(take)
    if not before:
        return f"nothing rests on {take}, leans on it, lies in it or is in the way of lifting it"
    direct = [edge.sentence() for edge in found.graph.dependencies if edge.then == take]
    held = [f"{' and '.join(group)} hold each other" for group in found.groups if take in group]
    return "; ".join([*held, *direct])


def _certificate(situation: Situation, take: str) -> dict[str, Any]:
    graph = dependencies(situation, direct=False)
    needed = {take, *graph.before(take)}
    others = [name for name in situation.scene.names if name != take and name not in situation.scene.fixed]
    lifted = [situation.swept(take, other) for other in others]
    objects = check(situation).objects
    carried = [each for each in objects.values() if take in (carry.name for carry in each.carried_by)]
    to_scene = situation.statics.upright.rotation  # of rows
    return {
        "dependencies": [
            {**edge.to_json(), "sentence": edge.sentence()}
            for edge in graph.dependencies
            if needed.issuperset((edge.first, edge.then))
        ],
        "swept": [each.to_json() for each in lifted if each.relation is not Relation.DISJOINT],
        "clears": [each.b for each in lifted if each.relation is Relation.DISJOINT],
        "contacts": [
            {"a": each.a, "b": each.b, "at": (each.points.mean(axis=0) @ to_scene).round(4).tolist(),
             "normal_a_to_b": (each.normals.mean(axis=0) @ to_scene).round(3).tolist(),
             "inferred": each.inferred}
            for each in situation.contacts if take in (each.a, each.b)
        ],
        "check": [each.to_json() for each in (objects[take], *carried)],
    }  # fmt: skip
