"""What carries what: contacts read with gravity."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from topple.topology.sixim.confidence import Evidence, confidence
from topple.topology.sixim.relation_table import RelationTable
from topple.topology.sixim.table import Relation
from topple.topology.statics.contact import Contact
from topple.topology.statics.rest import Statics, within_reach
from topple.topology.statics.tolerances import BESIDE, CANCELLED, LEAN


@dataclass(frozen=True)
class Support:
    """One object carries another.

    Attributes:
        supporter: What carries.
        supported: What is carried.
        kind: "rests", "leans" or "contained".
        confidence: 0..1.
        inferred: True where no camera saw the contact.
        gap: Distance of the two where they meet [m], 0 where they do.
    """

    supporter: str
    supported: str
    kind: str
    confidence: float
    inferred: bool
    gap: float = 0.0

    def to_json(self) -> dict[str, Any]:
        """The support as the JSON of `topple order` has it."""
        return {
            "supporter": self.supporter,
            "supported": self.supported,
            "kind": self.kind,
            "confidence": round(self.confidence, 3),
            "inferred": self.inferred,
        }


def supports(statics: Statics, relations: RelationTable) -> tuple[Support, ...]:
    """Find what carries what.

    Args:
        statics: The scene at rest.
        relations: Its relations, which tell what lies in what.

    Returns:
        Supports, ordered by supported object, one for each pair: of a contact seen and one inferred, the more
        certain. What leans has two supporters or more.
    """
    best: dict[tuple[str, str], tuple[float, Support]] = {}
    order = {name: i for i, name in enumerate(statics.upright.clouds)}
    for contact in within_reach(statics.contacts, statics.weights):
        support = _read(contact, statics, relations)
        if support is not None:
            # What lies close is more likely than what hovers, and what was seen than what was concluded.
            likely = (1.0 - min(support.gap / 0.01, 0.8)) * (0.7 if support.inferred else 1.0)
            pair = support.supporter, support.supported
            if pair not in best or likely > best[pair][0]:
                best[pair] = likely, support
    found = (support for _, support in best.values())
    return tuple(sorted(found, key=lambda s: (order[s.supported], order[s.supporter])))


def _read(contact: Contact, statics: Statics, relations: RelationTable) -> Support | None:
    """The support a contact stands for: the side below its normals carries the other."""
    push = contact.normals.mean(axis=0)  # where only its rim was seen they point all around, and cancel
    up = float(push[2] / max(np.linalg.norm(push), CANCELLED))
    if abs(up) < BESIDE:  # a wall beside a wall: neither carries, unless friction does
        return None
    below, above = (contact.a, contact.b) if up > 0 else (contact.b, contact.a)
    if above in statics.upright.fixed:
        return None
    inside = relations.between(above, below).relation in (Relation.WITHIN, Relation.PARTIAL_WITHIN)
    kind = "contained" if inside else "rests" if abs(up) >= LEAN else "leans"
    upright = statics.upright
    cameras = 0 if upright.viewpoints is None else len(upright.viewpoints)
    evidence = Evidence.CARRIES_UNSEEN if contact.inferred else Evidence.CARRIES
    gap = float(max(contact.gaps.min(), 0.0))
    return Support(below, above, kind, confidence(evidence, cameras, gap), contact.inferred, gap)
