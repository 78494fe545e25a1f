"""Contacts that no camera saw and gravity demands: what floats in the clouds is held by something."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from topple.topology.base.arrays import FloatArray, median_of, middle_of
from topple.topology.base.tolerances import TOLERANCES
from topple.topology.bodies.surfaces import carry_over, surfaces_of
from topple.topology.geometry.axes import level_axes
from topple.topology.geometry.outline import amid, covers, outline
from topple.topology.geometry.tolerances import ENOUGH
from topple.topology.relations.tolerances import CLOSE, FEW_IN_PLAN
from topple.topology.scene.scene import Scene
from topple.topology.sixim.confidence import Evidence, confidence
from topple.topology.sixim.pair import PairRelation
from topple.topology.sixim.relation_table import AnyTable, RelationTable
from topple.topology.sixim.table import Relation
from topple.topology.statics.contact import TOLERANCES as CONTACT
from topple.topology.statics.contact import find_contacts

if TYPE_CHECKING:
    from topple.topology.statics.support import Support

MEET = "inferred: their surfaces meet between the points"
FLOATS = "inferred: it floats otherwise"
"""Why two objects touch of which no point shows it."""

_HELD_BY = frozenset({Relation.WITHIN, Relation.PARTIAL_WITHIN, Relation.CROSS})


def infer_contacts(
    scene: Scene, relations: AnyTable, apart: Callable[[PairRelation], bool] = lambda pair: False
) -> AnyTable:
    """Add the hidden contacts that hold objects with nothing seen below them.

    Who holds them follows from static equilibrium and from the space the cameras saw to be empty. Where
    everything rests on something seen, nothing is computed.

    Args:
        scene: The scene; one that does not know where up is stays as it is.
        relations: Its relations.
        apart: Says of a pair without a visible contact whether the cameras saw that it has none.

    Returns:
        The relations, with disjoint pairs that must be in contact turned into `touch`, marked inferred.
    """
    if scene.up is None or len(scene.clouds) < 2:
        return relations
    if scene is not relations.scene:  # strays of some are left out
        own = surfaces_of(relations.scene)
        before = own.before_without_strays()
        carry_over(scene, relations.scene if before is None else before)
        own.without_strays = scene
    relations = _meeting_between_points(scene, relations)
    floating = floating_objects(scene, relations)
    open_pairs = [pair for name in floating for pair in relations.of(name) if _may_touch(pair)]
    open_pairs = [pair for pair in open_pairs if not apart(pair)]
    hidden = {frozenset((pair.a, pair.b)) for pair in open_pairs}
    if not hidden:
        return relations
    from topple.topology.statics.rest import Statics  # heavy, and needed by few scenes
    from topple.topology.statics.support import supports

    concerned = _hanging_together(floating.union(*hidden), scene, relations)
    found = supports(Statics.of(scene, concerned), relations)
    for name in sorted(floating):
        below = [support for support in found if support.supported == name]
        for support in _uppermost(name, below, scene, relations):
            if frozenset((name, support.supporter)) in hidden:
                pair = relations.between(support.supporter, name)
                relations = relations.with_pair(
                    _as_touching(pair, confidence(Evidence.FLOATS, len(scene.viewpoints)), FLOATS)
                )
    return relations


def _meeting_between_points(scene: Scene, relations: AnyTable) -> AnyTable:
    """Relations in which near misses touch whose surfaces meet between the points that show them.

    Points of a surface are further from another surface than its plane is: the planes through the points
    around the narrowest place tell whether the two carry each other. A gap that no camera saw is none where
    it is no wider than what clouds lack at their borders.
    """
    narrow = {
        frozenset((pair.a, pair.b)): pair
        for pair in relations.near.values()
        if pair.relation is Relation.DISJOINT and pair.within(CONTACT.search)
    }
    if not narrow:
        return relations
    most = 2 * relations.deviation  # each ends by up to the deviation short of where it turns away
    meeting = {each for each, pair in narrow.items() if not pair.observed and pair.gap <= most}
    for contact in find_contacts(surfaces_of(scene).upright, among=frozenset(narrow) - meeting):
        if float(contact.gaps.min()) <= CONTACT.tight:
            meeting.add(frozenset((contact.a, contact.b)))
    sure = confidence(Evidence.MEETS, len(scene.viewpoints))
    for each, pair in narrow.items():
        if each in meeting:
            relations = relations.with_pair(_as_touching(pair, sure, MEET))
    return relations


def _uppermost(
    name: str, below: Sequence["Support"], scene: Scene, relations: RelationTable
) -> list["Support"]:
    """Drop supports that lie under another one which reaches below the object's middle already.

    Between the two lies the upper one, hidden as it may be: a bowl on two plates meets the upper plate.
    """
    up = np.asarray(scene.up)
    middle = middle_of(scene.clouds[name]) @ np.stack(level_axes(up), axis=1)
    height = cache(lambda name: _height(scene.clouds[name], up))
    seen = {pair.b for pair in relations.of(name) if _holds(pair, height, scene.fixed)}
    reaching = [
        height(other)
        for other in seen.union(one.supporter for one in below) - scene.fixed
        if height(other) < height(name)
        and covers([outline(scene.clouds[other], up)], middle, TOLERANCES.flat)
    ]
    return [one for one in below if height(one.supporter) >= max(reaching, default=-np.inf)]


def _hanging_together(names: Collection[str], scene: Scene, relations: RelationTable) -> frozenset[str]:
    """Some objects and the movable ones that meet them, or others that do: what gravity sees as one."""
    found = set(names)
    border = found - scene.fixed
    while border:
        meeting = {pair.b for name in border for pair in relations.of(name) if pair.within(CLOSE)}
        border = meeting - found - scene.fixed
        found |= border
    return frozenset(found)


def floating_objects(scene: Scene, relations: RelationTable) -> frozenset[str]:
    """Movable objects that are in nothing and that nothing lower they touch can carry alone.

    What is carried has its carriers below its middle; what leans has its middle beside what it leans on, and
    must stand on something else besides.

    Args:
        scene: The scene, with `up`.
        relations: Its relations.
    """
    up = np.asarray(scene.up)
    height = cache(lambda name: _height(scene.clouds[name], up))
    return frozenset(name for name in scene.movable if not _is_held(name, scene, relations, up, height))


def _is_held(
    name: str, scene: Scene, relations: RelationTable, up: FloatArray, height: Callable[[str], float]
) -> bool:
    """Whether an object is in something, stands on what is fixed, or has its middle over what it touches."""
    holders = [pair for pair in relations.of(name) if _holds(pair, height, scene.fixed)]
    if any(pair.relation in _HELD_BY or pair.b in scene.fixed for pair in holders):
        return True
    if not holders:
        return False
    level = np.stack(level_axes(up), axis=1)
    middle = middle_of(scene.clouds[name]) @ level
    below = [scene.clouds[pair.b] for pair in holders]
    if amid(np.concatenate([some[:: -(-len(some) // FEW_IN_PLAN)] for some in below]) @ level, middle):
        return True
    return covers([outline(points, up) for points in below], middle, TOLERANCES.flat)


def _holds(pair: PairRelation, height: Callable[[str], float], fixed: frozenset[str]) -> bool:
    """Whether b may carry a: a is in b, or touches it and lies higher."""
    if pair.relation in _HELD_BY:
        return True
    if pair.relation is not Relation.TOUCH:
        return False
    return pair.b in fixed or height(pair.b) < height(pair.a)


def _height(points: FloatArray, up: FloatArray) -> float:
    """Middle height of points (N, 3) along `up` [m]: strays do not move it."""
    return median_of(points[:: -(-len(points) // ENOUGH)] @ up)


def _may_touch(pair: PairRelation) -> bool:
    """Whether two objects that seem apart are near enough to meet where no camera looks."""
    return pair.relation is Relation.DISJOINT and pair.within(TOLERANCES.reach)


def _as_touching(pair: PairRelation, sure: float, reason: str) -> PairRelation:
    """The pair in contact, at a place that no point shows."""
    return replace(
        pair,
        relation=Relation.TOUCH,
        confidence=sure,
        observed=False,
        kind=None,
        inferred=True,
        reason=reason,
    )
