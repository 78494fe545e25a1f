"""What a removal disturbs: what the lift meets, and what falls without what was taken."""

from collections.abc import Collection, Mapping, Sequence
from functools import cache
from itertools import combinations

import networkx as nx
import numpy as np

from topple.planner.decide.tolerances import BOARD, CLEARLY, PRESSED
from topple.planner.tolerances import DISTURBED
from topple.topology.arrays import FloatArray, bounds
from topple.topology.geometry.broadphase import near_both_ways
from topple.topology.situation import Situation
from topple.topology.statics.rest import Statics
from topple.topology.statics.sweep import Overlap, overlap
from topple.topology.statics.tolerances import SWEEP_CELL

Pair = tuple[str, str]
"""(first, then): whether taking `then` moves `first`."""


def disturbances(situation: Situation) -> tuple[dict[Pair, Overlap], dict[Pair, float]]:
    """Ask of every pair whether the lift of the one meets the other, and whether that falls without it.

    Args:
        situation: The scene.

    Returns:
        (first, then) -> how first hangs over then, for those that a lift of then would push aside; and by how
        much first falls without then, for those that do and hang together with it.
    """
    hanging = _hanging(situation.statics)
    return hanging, _falling_still(hanging, _lost(situation), situation.statics)


def _falling_still(
    hanging: Mapping[Pair, Overlap], lost: Mapping[Pair, float], statics: Statics
) -> dict[Pair, float]:
    """What falls without something also once all is gone that has to go before that anyway.

    Without one pier the bridge tips and throws the other over; but the bridge goes before either.
    """
    before: nx.DiGraph[str] = nx.DiGraph((*hanging, *lost))

    @cache
    def fallen(away: frozenset[str]) -> Collection[str]:
        return fallen_without(statics, away).keys()

    def still(first: str, then: str) -> bool:
        others = nx.ancestors(before.subgraph(before.nodes - {first}), then)
        return not others or first in fallen(frozenset({then, *others}))

    return {pair: far for pair, far in lost.items() if pair in hanging or still(*pair)}


def _lost(situation: Situation) -> dict[Pair, float]:
    """(first, then) -> by how much first falls without then, for those that do and hang together with it."""
    return {
        (first, then): missing
        for then in situation.movable
        for first, missing in fallen_without(situation.statics, [then]).items()
        if situation.hang_together(first, then)
    }


def fallen_without(statics: Statics, away: Collection[str], held: Collection[str] = ()) -> dict[str, float]:
    """What falls once objects are gone.

    Whole surfaces tell how far something falls; where half of a body is a guess, only that it may. That a
    body falls once a weight is taken off it, or off what it carries, is believed where no forces hold it,
    either: sparse feet tilt.

    Args:
        statics: The scene at rest.
        away: Names taken out of it.
        held: Names that a hand keeps still.

    Returns:
        name -> by how much more it falls than what just counts, or the share of its weight nothing holds.
    """
    if statics.sight is not None:
        return statics.unsteady_without(away, held)
    lost = {name: far - 1.0 for name, far in statics.fallen_without(away, held).items()}
    touching = statics.touching
    normals = {name: [touching[gone, name] for gone in away if (gone, name) in touching] for name in lost}
    lowest = min((statics.weights[name].centre[2] for name in away), default=-np.inf)
    below = {name for name in lost if not normals[name] and statics.weights[name].centre[2] < lowest}
    freed = [name for name in lost if name in below or max(normals[name], default=0.0) < PRESSED]
    unheld = statics.unsteady_without(away, held) if freed else {}
    return {name: far for name, far in lost.items() if name not in freed or name in unheld}


def _hanging(statics: Statics) -> dict[tuple[str, str], Overlap]:
    """(first, then) -> how first hangs over then, for those that a lift of then would push aside.

    Where each of two objects seems to hang over the other, one of them often does so only by the surface that
    was guessed for it, or by a few pixels on the wrong side of a mask's edge: what was seen then decides.
    """
    surfaces, seen = statics.surfaces, statics.upright.clouds
    stands_at = {name: statics.upright.floor_under(surfaces[name]) for name in statics.upright.movable}
    hanging: dict[tuple[str, str], Overlap] = {}
    for first, then in _over_each_other(surfaces, statics.upright.movable):
        if float(surfaces[then][:, 2].max()) < stands_at[first] - BOARD:
            continue  # a board that never moves is between them
        over = overlap(surfaces[first], surfaces[then])
        if over is not None and over.evasion > DISTURBED:
            hanging[first, then] = over
    for first, then in combinations(statics.upright.movable, 2):
        if (first, then) in hanging and (then, first) in hanging:
            views = (overlap(seen[a], seen[b]) for a, b in ((first, then), (then, first)))
            forth, back = (0.0 if view is None else view.area for view in views)
            if back < CLEARLY * forth:
                del hanging[then, first]
            elif forth < CLEARLY * back:
                del hanging[first, then]
    return hanging


def _over_each_other(surfaces: Mapping[str, FloatArray], names: Sequence[str]) -> list[tuple[str, str]]:
    """Ordered pairs of the names whose boxes meet in plan, or nearly: no others hang over each other."""
    plans = [(lower[:2], upper[:2]) for lower, upper in (bounds(surfaces[name]) for name in names)]
    return [(names[i], names[j]) for i, j in near_both_ways(plans, 3 * SWEEP_CELL)]
