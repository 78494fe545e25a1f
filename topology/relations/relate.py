"""What `relate` answers: broad phase, then a closer look at the pairs that are near, by one rule of many."""

from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Executor
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any

import numpy as np

from topple.topology.base.arguments import checked_arguments
from topple.topology.base.errors import InvalidInput
from topple.topology.base.notebook import in_cell
from topple.topology.base.plugins import Table, check_kind
from topple.topology.base.tolerances import TOLERANCES
from topple.topology.base.workers import all_of
from topple.topology.geometry.broadphase import near_pairs
from topple.topology.io.load import AnyScene, as_scene
from topple.topology.io.relations import deviation_of, told_in
from topple.topology.relations.tolerances import MOST_OBJECTS, NEAR_EACH
from topple.topology.scene.scene import Scene
from topple.topology.sixim.pair import PairRelation
from topple.topology.sixim.relation_table import Extent, LoadedBasis, RelationTable, Rule, box_distance

RULES: Table[Callable[[Scene, float | None], Rule]] = Table(
    "topple.relations",
    "rule",
    {"robust": "topple.topology.relations.robust:robust", "plain": "topple.topology.sixim.fast.rule:plainly"},
)
"""What makes each rule for a scene, by the rule's name; the deviation [m] is None where it is not given."""

__all__ = ["RULES", "PairRelation", "Relations", "box_distance", "relate", "relate_all"]


class Relations(RelationTable):
    """The relations of all pairs of a scene, as `relate` found them or another program told them.

    Pairs whose boxes are far apart are not stored: they are made when asked for.

    Examples:
        >>> found = relate(scene)
        >>> str(found["cup", "book"].relation)
        'touch'
        >>> len(found)
        3
    """

    @staticmethod
    def from_json(document: Mapping[str, Any], scene: Scene) -> "Relations":
        """Read relations that were written as JSON, by `to_json` or by another program.

        Args:
            document: What `topple relate --json` prints: "relations" with "a", "b" and "relation" for every
                pair; a matrix, a gap and the rest where they are known. A pair that is not named is taken as
                `relate` finds it.
            scene: The scene they are about.

        Returns:
            The relations, which an order of this scene heeds.

        Raises:
            InvalidInput: The document is none of relations, names a pair twice, or has a relation or a number
                that is none.
            UnknownObject: A pair names an object that is not in the scene.
        """
        return told_in(document, relate(scene, deviation_of(document)))

    def _repr_html_(self) -> str | None:
        """Show the relations in a notebook."""
        return in_cell(self)


@checked_arguments
def relate(
    scene: AnyScene,
    deviation: float | None = None,
    plain: bool = False,
    max_objects: int | None = None,
    rule: str | None = None,
) -> Relations:
    """Decide the spatial relation of every pair of objects of a scene.

    Args:
        scene: The objects' clouds, or the path of a scene.
        deviation: The deviation factor δ [m]: points this close to a boundary lie on it. Estimated from
            the clouds' noise and spacing where not given; 0.002 for the plain rule, of which the paper says
            that it is "usually equal to the deviation of point clouds".
        plain: Use the paper's rule to the letter of Table 1 instead of the one that withstands noise,
            hidden surfaces and hollow objects.
        max_objects: How many objects the scene may have, `MOST_OBJECTS` where None, since the work grows
            with the square of it; of the pairs `NEAR_EACH` times as many may be near each other.
        rule: One of `RULES`: "robust", "plain", or what another package adds.

    Returns:
        One relation per unordered pair.

    Raises:
        InvalidInput: The deviation is no positive length below the size of the objects, there are more
            objects or near pairs than is allowed, or there is no such rule.

    Examples:
        >>> print(relate(scene)["cup", "book"])
        cup touch book 0.0 mm
    """
    scene, most = as_scene(scene), MOST_OBJECTS if max_objects is None else max_objects
    _check_count(len(scene.clouds), "objects", most)
    if deviation is not None:
        _check_deviation(scene, deviation)
    name = rule or ("plain" if plain else "robust")
    if plain and name != "plain":
        raise InvalidInput(f"the rule is plain and {name!r}: expected one of the two")
    with RULES.blame(name):
        chosen = RULES[name](scene, None if deviation is None else float(deviation))
        return chosen.conclude(scene, _relate_by(chosen, scene, NEAR_EACH * most))


@checked_arguments
def relate_all(
    scenes: Iterable[AnyScene],
    deviation: float | None = None,
    plain: bool = False,
    executor: Executor | None = None,
    max_objects: int | None = None,
    rule: str | None = None,
) -> list[Relations]:
    """Relate many scenes, on the workers of an executor where one is given.

    Args:
        scenes: Scenes, or paths of their files: the workers then read these, and clouds do not travel.
        deviation: As for `relate`.
        plain: As for `relate`.
        executor: Any executor of `concurrent.futures`, or that of a dask client; a worker that is lost costs
            its scene a second try.
        max_objects: As for `relate`.
        rule: As for `relate`.

    Returns:
        The relations of each scene, in order.

    Raises:
        InvalidInput: As `relate` and `load_scene`.
        WorkerLost: The worker of a scene was lost twice.

    Examples:
        >>> [str(found["cup", "book"].relation) for found in relate_all([scene])]
        ['touch']
    """
    each = partial(relate, deviation=deviation, plain=plain, max_objects=max_objects, rule=rule)
    if executor is None:
        return [each(as_scene(one)) for one in scenes]
    given = list(scenes)
    found = all_of(partial(_as_told, each), given, executor)
    make = RULES[rule or ("plain" if plain else "robust")]
    return [
        Relations(names, _LazyBasis(source, make, deviation), near, extents)
        for source, (names, deviation, near, extents) in zip(given, found, strict=True)
    ]


_Source = AnyScene
_Told = tuple[tuple[str, ...], float, Mapping[tuple[int, int], PairRelation], tuple[Extent, ...]]
"""What comes back from a worker: names, deviation, near pairs, boxes; the rest follows from the scene."""


def _as_told(each: Callable[[Scene], Relations], source: _Source) -> _Told:
    found = each(as_scene(source))
    return found.objects, found.deviation, found.near, tuple(map(Extent.of, found.extents))


@dataclass(frozen=True, eq=False)
class _LazyBasis:
    """The scene and the rule of a worker, which are read and made here only when they are asked for."""

    source: _Source = field(repr=False)
    make: Callable[[Scene, float | None], Rule]
    deviation: float

    @property
    def scene(self) -> Scene:
        """The related scene."""
        return self._scene

    @property
    def rule(self) -> Rule:
        """The rule that was used."""
        return self._rule

    @cached_property
    def _scene(self) -> Scene:
        return as_scene(self.source)

    @cached_property
    def _rule(self) -> Rule:
        return self.make(self.scene, self.deviation)


def _check_deviation(scene: Scene, deviation: float) -> None:
    judged = scene.movable or scene.names  # a table is larger than any mistake
    largest = max(float(np.ptp(scene.clouds[name], axis=0).max()) for name in judged)
    if not np.isfinite(deviation) or deviation <= 0:
        raise InvalidInput(f"deviation {deviation} is no length: give metres > 0, 0.002 for a depth camera")
    if deviation > max(largest, TOLERANCES.greatest_deviation):  # what noise alone may reach is no mistake
        raise InvalidInput(
            f"deviation {deviation:g} m is larger than every object (the largest measures {largest:.3g} m): "
            "give metres, 0.002 for a depth camera"
        )


def _check_count(count: int, what: str, most: int) -> None:
    if count > most:
        raise InvalidInput(
            f"the scene has {count} {what}, and {most} are allowed: leave out what is far from the targets, "
            "or relate it with max_objects=N"
        )


def _relate_by(rule: Rule, scene: Scene, most_pairs: int) -> Relations:
    prepared = tuple(rule.prepare(name, cloud) for name, cloud in scene.clouds.items())
    lower = np.array([one.lower for one in prepared]).reshape(-1, 3)
    upper = np.array([one.upper for one in prepared]).reshape(-1, 3)
    near: dict[tuple[int, int], PairRelation] = {}
    pairs = near_pairs(lower, upper, rule.reach)
    _check_count(len(pairs), "pairs of objects near each other", most_pairs)
    for i, j in pairs.tolist():
        near[i, j] = check_kind(rule.relate(prepared[i], prepared[j]), PairRelation)
    return Relations(tuple(scene.clouds), LoadedBasis(scene, rule), near, prepared, prepared)
