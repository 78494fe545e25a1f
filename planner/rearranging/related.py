"""An arrangement as relations tell it, worked out: what shall be in what, and what shall touch what."""

from collections.abc import Mapping
from typing import Any

import networkx as nx

from topple.planner.decide.goal import Place, PlaceRelation
from topple.planner.errors import NoSafePlan
from topple.planner.rearranging.arrangement import INSIDE, Arrangement
from topple.planner.rearranging.words import laid_out
from topple.topology.base.errors import InvalidInput
from topple.topology.io.relations import told_in
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation
from topple.topology.sixim.relation_table import RelationTable
from topple.topology.sixim.table import Relation

OUTSIDE = (Relation.CONTAIN, Relation.PARTIAL_CONTAIN)

Pairs = Mapping[tuple[str, str], Relation]
"""What pairs are told, each once and so that nothing contains: (a, b) -> "a relation b"."""


def arrange_by_relations(document: Mapping[str, Any], situation: Situation) -> Arrangement:
    """Work out an arrangement that has the relations of a document, with as little moved as they ask for.

    What shall be in another thing is put there; what shall touch others goes onto the one over which the way
    down to what never moves is shortest, since relations do not say what is below. What already lies as told
    stays, and so does what the document does not tell of.

    Args:
        document: What `topple relate --json` prints, of this scene or of another one of the same things.
        situation: How things lie now.

    Raises:
        InvalidInput: The document is none of relations, something in it has nothing to rest on, or nothing
            that moves is in it.
        UnknownObject: It names what is not in the scene.
        NoSafePlan: Somewhere there is no room; or the certificate has the pairs that would not be as told.
    """
    told = _pairs_of(document, situation)
    clauses = _clauses(told, situation.scene)
    now = situation.relations
    leaving = {
        max(pair, key=situation.scene.names.index)
        for pair, relation in told.items()
        if relation is Relation.DISJOINT and now.between(*pair).relation is not Relation.DISJOINT
    }
    found = laid_out(clauses, situation, leaving)
    if missing := _missing_words(told, found.situation.relations):
        raise NoSafePlan(f"relations that would not hold: {'; '.join(missing)}", missing)
    return found


def _pairs_of(document: Mapping[str, Any], situation: Situation) -> Pairs:
    """The pairs of a document of which one moves."""
    table = told_in(document, situation.relations)
    movable = set(situation.movable)
    told: dict[tuple[str, str], Relation] = {}
    for entry in document["relations"]:
        a, b = entry["a"], entry["b"]
        if not movable & {a, b}:
            continue
        relation = table.between(a, b).relation
        pair = (b, a) if relation in OUTSIDE else (a, b)
        told[pair] = table.between(*pair).relation
    if not told:
        raise InvalidInput("the relations tell of nothing that moves: expected pairs of the goal")
    return told


def _clauses(told: Pairs, scene: Scene) -> list[Place]:
    """Where each thing goes: into what it is in, or onto what leads down to what never moves."""
    meeting: nx.Graph[str] = nx.Graph()
    meeting.add_nodes_from([*scene.fixed, *(name for pair in told for name in pair)])
    meeting.add_edges_from(pair for pair, relation in told.items() if relation is not Relation.DISJOINT)
    inside = {pair for pair, relation in told.items() if relation in INSIDE}
    levels = nx.multi_source_dijkstra_path_length(meeting, set(scene.fixed)) if scene.fixed else {}
    told_where = {n for pair in told if set(pair) & set(scene.fixed) for n in pair} | {n for n, _ in inside}
    clauses: list[Place] = []
    for name in scene.movable:
        around = [b for a, b in inside if a == name]
        if around:  # of a bowl on a tray, the bowl
            nearest = max(around, key=lambda each: sum((each, other) in inside for other in around))
            clauses.append(Place(name, PlaceRelation.WITHIN, nearest))
        elif name in levels:
            below = min(meeting[name], key=lambda each: (levels[each], scene.names.index(each)))
            clauses.append(Place(name, PlaceRelation.ON, below))
        elif name in told_where or (name in meeting and meeting.degree(name)):
            raise InvalidInput(
                f"{name} would rest on nothing: expected a relation to what carries it, such as touch"
            )
    return clauses


def _missing_words(told: Pairs, found: RelationTable) -> tuple[str, ...]:
    """Pairs that would not be as told, in words; what is on a plate may also be within its rim."""
    missing: list[str] = []
    for (a, b), wanted in told.items():
        now = found.between(a, b).relation
        if wanted in INSIDE:
            held = now in INSIDE
        else:
            held = (wanted is Relation.DISJOINT) == (now is Relation.DISJOINT)
        if not held:
            missing.append(f"{a} and {b} would be {now}, not {wanted}")
    return tuple(missing)
