"""Relations of all pairs of a scene: broad phase, then a closer look at the pairs that are near."""

from collections.abc import Iterable
from concurrent.futures import Executor
from functools import partial

import numpy as np

from topple.topology.cloud import estimate_deviation
from topple.topology.errors import InvalidInput
from topple.topology.geometry.broadphase import near_pairs
from topple.topology.pair import PairRelation
from topple.topology.relations import Relations, Rule
from topple.topology.rule.robust import RobustRule
from topple.topology.scene import Scene
from topple.topology.sixim.fast.rule import PlainRule
from topple.topology.tolerances import TOLERANCES
from topple.topology.views.visibility import Visibility

__all__ = ["PairRelation", "Relations", "relate", "relate_all"]


def relate(scene: Scene, deviation: float | None = None, plain: bool = False) -> Relations:
    """Decide the spatial relation of every pair of objects of a scene.

    Args:
        scene: The objects' clouds.
        deviation: The deviation factor δ [m]: points this close to a boundary lie on it. Estimated from
            the clouds' noise and spacing where not given; 0.002 for the plain rule, of which the paper says
            that it is "usually equal to the deviation of point clouds".
        plain: Use the paper's rule to the letter of Table 1 instead of the one that withstands noise,
            hidden surfaces and hollow objects.

    Returns:
        One relation per unordered pair.

    Raises:
        InvalidInput: The deviation is no positive length below the size of the objects.
    """
    rule = _rule(scene, deviation, plain)
    return rule.conclude(scene, _relate_by(rule, scene))


def relate_all(
    scenes: Iterable[Scene],
    deviation: float | None = None,
    plain: bool = False,
    executor: Executor | None = None,
) -> list[Relations]:
    """Relate many scenes, on the workers of an executor where one is given.

    Args:
        scenes: The scenes.
        deviation: As for `relate`.
        plain: As for `relate`.
        executor: Any executor of `concurrent.futures`, or one with the same `map`.

    Returns:
        The relations of each scene, in order.
    """
    each = partial(relate, deviation=deviation, plain=plain)
    return list(map(each, scenes) if executor is None else executor.map(each, scenes))


def _rule(scene: Scene, deviation: float | None, plain: bool) -> Rule:
    if deviation is not None:
        _check_deviation(scene, deviation)
    if plain:
        return PlainRule(TOLERANCES.plain_deviation if deviation is None else float(deviation))
    sight = Visibility(scene.clouds, scene.viewpoints, scene.images)
    return RobustRule(
        deviation=estimate_deviation(scene) if deviation is None else float(deviation),
        up=scene.up,
        sight=sight if sight.known else None,
    )


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


def _relate_by(rule: Rule, scene: Scene) -> Relations:
    prepared = tuple(rule.prepare(name, cloud) for name, cloud in scene.clouds.items())
    lower = np.array([one.lower for one in prepared]).reshape(-1, 3)
    upper = np.array([one.upper for one in prepared]).reshape(-1, 3)
    near: dict[tuple[int, int], PairRelation] = {}
    for i, j in near_pairs(lower, upper, rule.reach).tolist():
        near[i, j] = rule.relate(prepared[i], prepared[j])
    return Relations(tuple(scene.clouds), rule, near, prepared, scene)
