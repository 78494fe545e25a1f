"""One relation for every unordered pair of objects: what a rule fills, and what statics read."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import combinations
from typing import Any, Protocol, TypeVar

import numpy as np

from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput, UnknownObject
from topple.topology.base.notebook import in_words
from topple.topology.base.values import in_columns, same
from topple.topology.scene.scene import Scene
from topple.topology.sixim.pair import PairRelation
from topple.topology.sixim.table import Relation

FORMAT, FORMAT_VERSION = "topple.relations", 1

AnyTable = TypeVar("AnyTable", bound="RelationTable")


def _relation_called(name: "Relation | str") -> Relation:
    try:
        return Relation(name)
    except ValueError as error:
        raise InvalidInput(f"{name!r} is no relation: expected {', '.join(Relation)}") from error


class Prepared(Protocol):
    """What a rule derives from one cloud, once, for all of its pairs."""

    @property
    def lower(self) -> FloatArray:
        """(3,) least corner of the box [m]."""
        ...

    @property
    def upper(self) -> FloatArray:
        """(3,) greatest corner of the box [m]."""
        ...

    @property
    def size(self) -> int:
        """Number of points."""
        ...


@dataclass(frozen=True, eq=False)
class Extent:
    """What is known of a prepared cloud without preparing it.

    Attributes:
        lower: (3,) least corner of the box [m].
        upper: (3,) greatest corner of the box [m].
        size: Number of points.
    """

    lower: FloatArray
    upper: FloatArray
    size: int

    @staticmethod
    def of(one: Prepared) -> "Extent":
        """That of a prepared cloud."""
        return Extent(one.lower, one.upper, one.size)


def box_distance(a: Prepared, b: Prepared) -> float:
    """Distance of two clouds' axis-aligned boxes [m], 0 where they overlap: no points are closer."""
    return float(np.linalg.norm(np.maximum(np.maximum(a.lower - b.upper, b.lower - a.upper), 0.0)))


class Rule(Protocol):
    """A way to relate two clouds."""

    @property
    def deviation(self) -> float:
        """The deviation factor δ [m]."""
        ...

    @property
    def reach(self) -> float:
        """Pairs whose boxes are further apart than this are disjoint without a closer look [m]."""
        ...

    def prepare(self, name: str, cloud: FloatArray) -> Any:
        """Derive what the rule needs of one cloud (N, 3); the result is a `Prepared`."""
        ...

    def relate(self, a: Any, b: Any) -> PairRelation:
        """Relate two prepared clouds."""
        ...

    def after(self, scene: Scene, changed: Collection[str], looked_again: bool) -> "Rule":
        """The rule for the same objects where some have other clouds, and cameras may have looked again."""
        ...

    def look_again(self, pair: PairRelation, a: Any, b: Any) -> PairRelation:
        """A pair whose clouds are the same, when others have changed or cameras have looked again."""
        ...

    def conclude(self, scene: Scene, relations: AnyTable) -> AnyTable:
        """Add what follows from all pairs together."""
        ...


class Basis(Protocol):
    """What relations are of: a scene, and the rule that relates it."""

    @property
    def scene(self) -> Scene:
        """The related scene."""
        ...

    @property
    def rule(self) -> Rule:
        """The rule that was used."""
        ...

    @property
    def deviation(self) -> float:
        """The deviation factor δ [m] of the rule."""
        ...


@dataclass(frozen=True, eq=False)
class LoadedBasis:
    """A scene and a rule that are there.

    Attributes:
        scene: What was related.
        rule: The rule that was used.
    """

    scene: Scene = field(repr=False)
    rule: Rule

    @property
    def deviation(self) -> float:
        """The deviation factor δ [m] of the rule."""
        return self.rule.deviation


@dataclass(frozen=True, eq=False)
class RelationTable:
    """The relations of all pairs of a scene.

    Pairs whose boxes are far apart are not stored: they are made when asked for.

    Attributes:
        objects: Names, in the scene's order.
        basis: The scene and the rule: `scene`, `rule`.
        near: Pairs that were looked at closely, under their positions (i, j) in `objects`, i < j.
        extents: Box and size of each prepared cloud, in the order of `objects`.
        known_prepared: What the rule derived from each cloud, where it is known: `prepared`.
    """

    objects: tuple[str, ...]
    basis: Basis
    near: Mapping[tuple[int, int], PairRelation]
    extents: tuple[Prepared, ...] = field(repr=False)
    known_prepared: tuple[Prepared, ...] | None = field(default=None, repr=False)

    @property
    def scene(self) -> Scene:
        """The related scene."""
        return self.basis.scene

    @property
    def rule(self) -> Rule:
        """The rule that was used."""
        return self.basis.rule

    @cached_property
    def prepared(self) -> tuple[Prepared, ...]:
        """Data that the rule derives from each cloud, in the order of `objects`."""
        if self.known_prepared is not None:
            return self.known_prepared
        return tuple(self.rule.prepare(name, cloud) for name, cloud in self.scene.clouds.items())

    @property
    def deviation(self) -> float:
        """The deviation factor δ [m] all pairs were related with."""
        return self.basis.deviation

    @cached_property
    def pairs(self) -> tuple[PairRelation, ...]:
        """Every unordered pair once, "a relation b", a before b in `objects`."""
        return tuple(self._pair(i, j) for i, j in combinations(range(len(self.objects)), 2))

    @cached_property
    def _index(self) -> dict[str, int]:
        return {name: i for i, name in enumerate(self.objects)}

    @cached_property
    def _around(self) -> dict[int, list[tuple[int, int]]]:
        """The keys of `near` in which each position occurs."""
        around: dict[int, list[tuple[int, int]]] = {}
        for key in self.near:
            for position in key:
                around.setdefault(position, []).append(key)
        return around

    def __iter__(self) -> Iterator[PairRelation]:
        return iter(self.pairs)

    def __len__(self) -> int:
        """Number of unordered pairs."""
        return len(self.objects) * (len(self.objects) - 1) // 2

    def between(self, a: str, b: str) -> PairRelation:
        """The pair of two objects, told from `a`: "a relation b".

        Args:
            a: Name of one object.
            b: Name of another.

        Raises:
            UnknownObject: A name is not in the scene.
            InvalidInput: Both names are the same.
        """
        i, j = self._position(a), self._position(b)
        if i == j:
            raise InvalidInput(f"{a!r} has no relation to itself: give two different objects")
        return self._pair(i, j) if i < j else self._pair(j, i).converse

    def __getitem__(self, names: tuple[str, str]) -> PairRelation:
        """The pair of two objects, as `between` tells it: `relations["fork", "plate"]`."""
        return self.between(*names)

    def __str__(self) -> str:
        """The pairs that meet, a line each, as `topple relate` prints them."""
        met = [pair for pair in self.near.values() if pair.relation is not Relation.DISJOINT]
        head = f"{len(self.objects)} objects, deviation {1000 * self.deviation:.2f} mm"
        far = f"disjoint: {len(self) - len(met)} of {len(self)} pairs"
        return "\n".join([head, *in_columns(in_words(self.scene, [pair.cells() for pair in met])), far])

    def of(self, name: str) -> Iterator[PairRelation]:
        """The pairs of one object that were looked at closely, each told from it.

        Args:
            name: Name of the object.

        Raises:
            UnknownObject: The name is not in the scene.
        """
        wanted = self._position(name)
        for key in self._around.get(wanted, ()):
            yield self.near[key] if wanted == key[0] else self.near[key].converse

    @cached_property
    def meeting(self) -> frozenset[frozenset[str]]:
        """The pairs that are in contact or in each other: every one that is not disjoint."""
        met = (pair for pair in self.near.values() if pair.relation is not Relation.DISJOINT)
        return frozenset(frozenset((pair.a, pair.b)) for pair in met)

    def with_relation(self: AnyTable, a: str, b: str, relation: Relation | str) -> AnyTable:
        """Copy in which one pair has another relation, as somebody knows better; its matrix stays as counted.

        Args:
            a: Name of one object.
            b: Name of another.
            relation: "a relation b", one of the seven.

        Raises:
            UnknownObject: A name is not in the scene.
            InvalidInput: There is no such relation, or both names are the same.
        """
        return self.with_pair(
            replace(
                self.between(a, b),
                relation=_relation_called(relation),
                kind=None,
                inferred=False,
                reason="as given",
            )
        )

    def with_pair(self: AnyTable, pair: PairRelation) -> AnyTable:
        """Copy with one pair replaced.

        Args:
            pair: The new relation of two objects of the scene, told from either.

        Raises:
            UnknownObject: A name is not in the scene.
        """
        i, j = self._position(pair.a), self._position(pair.b)
        key, pair = ((i, j), pair) if i < j else ((j, i), pair.converse)
        return replace(self, near={**self.near, key: pair})

    def updated(self: AnyTable, name: str, cloud: FloatArray) -> AnyTable:
        """Relations of the scene in which one object's cloud changed, as `relate` would find them.

        Only the object's own pairs are related again, those that were inferred from gravity, and whether
        the gaps of the others are still in sight. The deviation stays.

        Args:
            name: Name of the object.
            cloud: (N, 3) its new points [m].

        Raises:
            UnknownObject: The name is not in the scene.
            InvalidInput: The cloud is no cloud.
        """
        self._position(name)
        return self._follow(self.scene.with_cloud(name, cloud), [name])

    def followed(self: AnyTable, scene: Scene) -> AnyTable:
        """Relations of the next frame of a tracked scene: only what changed is looked at again.

        Args:
            scene: The frame, with the same objects; a cloud that is the very same array did not change.

        Raises:
            InvalidInput: The frame has other objects: relate it anew.
        """
        if scene.names != self.objects:
            raise InvalidInput(f"the frame has {', '.join(scene.names)}, expected {', '.join(self.objects)}")
        changed = [name for name, cloud in scene.clouds.items() if cloud is not self.scene.clouds[name]]
        again = len(scene.images) != len(self.scene.images) or not np.array_equal(
            scene.viewpoints, self.scene.viewpoints
        )
        again = again or any(new is not old for new, old in zip(scene.images, self.scene.images, strict=True))
        return self._follow(scene, changed, again) if changed or again else self

    def _follow(self: AnyTable, scene: Scene, names: Sequence[str], looked_again: bool = False) -> AnyTable:
        """Relations of a scene of the same objects in which some have other clouds."""
        rule, prepared = self.rule.after(scene, names, looked_again), list(self.prepared)
        for name in names:
            prepared[self._position(name)] = rule.prepare(name, scene.clouds[name])
        moved = {self._position(name) for name in names}
        again = {key for key, pair in self.near.items() if pair.inferred and moved.isdisjoint(key)}
        near = {
            (i, j): rule.look_again(pair, prepared[i], prepared[j])
            for (i, j), pair in self.near.items()
            if moved.isdisjoint((i, j)) and (i, j) not in again
        }
        lower = np.array([other.lower for other in prepared]) - rule.reach
        upper = np.array([other.upper for other in prepared]) + rule.reach
        for one in moved:
            meeting = ((lower <= prepared[one].upper) & (upper >= prepared[one].lower)).all(axis=1)
            again |= {(min(one, other), max(one, other)) for other in np.flatnonzero(meeting).tolist()}
        for i, j in sorted(again):
            if i != j:
                near[i, j] = rule.relate(prepared[i], prepared[j])
        made = tuple(prepared)
        related = replace(self, basis=LoadedBasis(scene, rule), near=near, extents=made, known_prepared=made)
        return rule.conclude(scene, related)

    def __eq__(self, other: object) -> bool:
        """Compare the scenes and what is said of every pair."""
        if not isinstance(other, RelationTable):
            return NotImplemented
        if self is other:
            return True
        alike = self.deviation == other.deviation and same(self.near, other.near)
        return alike and self.scene == other.scene

    def __hash__(self) -> int:
        """Hash the names."""
        return hash(self.objects)

    def to_json(self, *, far: bool = True) -> dict[str, Any]:
        """The relations as plain JSON data: format "topple.relations", version 1.

        Args:
            far: Whether pairs out of each other's reach are listed, which are disjoint: they grow with the
                square of the objects. Where they are not, `far_pairs_left_out` says how many there are.
        """
        pairs = self.pairs if far else tuple(self._pair(*key) for key in sorted(self.near))
        count = len(self.objects)
        return {
            "format": FORMAT,
            "format_version": FORMAT_VERSION,
            "deviation": self.deviation,
            "objects": list(self.objects),
            "relations": [pair.to_json() for pair in pairs],
            **({} if far else {"far_pairs_left_out": count * (count - 1) // 2 - len(pairs)}),
        }

    def _position(self, name: str) -> int:
        if name not in self._index:
            raise UnknownObject(name, self.objects)
        return self._index[name]

    def _pair(self, i: int, j: int) -> PairRelation:
        if (i, j) in self.near:
            return self.near[i, j]
        a, b = self.extents[i], self.extents[j]
        return PairRelation(
            a=self.objects[i],
            b=self.objects[j],
            relation=Relation.DISJOINT,
            counts=np.array([[0, 0, a.size], [0, 0, b.size]], dtype=np.int64),
            distance=box_distance(a, b),
            gap_exact=False,
        )
