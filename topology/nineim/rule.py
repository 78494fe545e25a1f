"""The 9-intersection model as a rule beside those of the 6-intersection model."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass

from topple.topology.arrays import FloatArray
from topple.topology.bodies.solids import parts_of, solids_of
from topple.topology.cloud import estimate_deviation
from topple.topology.nineim.matrix import NineIntersections, Solid, matrix_of, nine_intersections
from topple.topology.pair import PairRelation
from topple.topology.relation_table import AnyTable
from topple.topology.scene import Scene
from topple.topology.sixim.table import Relation

_AS = {
    "disjoint": Relation.DISJOINT,
    "meet": Relation.TOUCH,
    "overlap": Relation.CROSS,
    "inside": Relation.WITHIN,
    "covered by": Relation.WITHIN,
    "contains": Relation.CONTAIN,
    "covers": Relation.CONTAIN,
    "equal": Relation.TOUCH,  # as the 6-intersection model has it of coincident clouds
}


@dataclass(frozen=True, eq=False)
class NineRule:
    """Relations by the nine intersections of the objects as complete solids.

    Where noise leaves several relations possible, it says touch if that is one of them, with a confidence of
    one to as many as are possible, and why it cannot tell in `reason`. It knows no partial within, and the
    convex parts of a body fill part of its hollow: what lies there crosses it.

    Attributes:
        deviation: How far surfaces may be from where they are taken to be [m].
        solids: The complete bodies, by name.
    """

    deviation: float
    solids: Mapping[str, tuple[FloatArray, ...]]

    @property
    def reach(self) -> float:
        """Boxes further apart than the deviation hold solids that are surely disjoint [m]."""
        return self.deviation

    def prepare(self, name: str, cloud: FloatArray) -> Solid:
        """The complete body of an object; of one that has none yet, the hull of its cloud."""
        return Solid.of(name, self.solids.get(name, (cloud,)))

    def relate(self, a: Solid, b: Solid) -> PairRelation:
        """Relate two solids."""
        nine = nine_intersections(a, b, self.deviation)
        relation, share = _told(nine)
        return PairRelation(
            a.name, b.name, relation, matrix_of(nine), nine.gap, confidence=share, reason=nine.why_open
        )

    def after(self, scene: Scene, changed: Collection[str], looked_again: bool) -> "NineRule":
        """The rule of the changed scene."""
        return NineRule(self.deviation, _solids(scene))

    def look_again(self, pair: PairRelation, a: Solid, b: Solid) -> PairRelation:
        """The same pair, for the same reason."""
        return pair

    def conclude(self, scene: Scene, relations: AnyTable) -> AnyTable:
        """Nothing follows from all pairs together."""
        return relations


def nine(scene: Scene, deviation: float | None = None) -> NineRule:
    """The 9-intersection model on the complete solids of a scene.

    Args:
        scene: Best with `up`: bodies are completed down to what carries them.
        deviation: How far surfaces may be off [m]; estimated where None.
    """
    estimated = estimate_deviation(scene) if deviation is None else deviation
    return NineRule(estimated, _solids(scene))


def _solids(scene: Scene) -> dict[str, tuple[FloatArray, ...]]:
    if scene.up is not None:
        return solids_of(scene)
    return {name: parts_of(cloud, scene) for name, cloud in scene.clouds.items()}


def _told(nine: NineIntersections) -> tuple[Relation, float]:
    """The relation of the 6-intersection model that is said, and how sure."""
    relations = [_AS[name] for name in nine.possible] or [Relation.CROSS]
    said = Relation.TOUCH if Relation.TOUCH in relations else relations[0]
    return said, 1.0 / len(relations)
