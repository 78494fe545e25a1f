"""What speaks for it that a removal disturbs: what the lift meets, and what falls without what was taken."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import permutations

import networkx as nx
import numpy as np

from topple.planner.decide.tolerances import BOARD, CARRIES, PRESSED
from topple.planner.tolerances import DISTURBED
from topple.topology.base.arrays import FloatArray, bounds
from topple.topology.geometry.broadphase import near_both_ways
from topple.topology.geometry.plane import tilted_share
from topple.topology.situation.situation import Situation
from topple.topology.statics.rest import Statics
from topple.topology.statics.sweep import Overlap, overlap
from topple.topology.statics.tolerances import GUESSED, SWEEP_CELL
from topple.topology.statics.way_out import along

Pair = tuple[str, str]
"""(first, then): whether taking `then` moves `first`."""


@dataclass(frozen=True, slots=True)
class Disturbance:
    """What speaks for it that taking `then` moves `first`.

    Attributes:
        over: How `first` hangs over `then`, both with their hidden sides, or stands before it where `then`
            goes out level; None where it does not.
        seen: The same of what was seen of them.
        unheld: Share of its weight that nothing carries without `then`, 0..1; where surfaces are whole, 1 of
            what falls.
        up: Upward part of the mean contact normal from `then` into `first`; None where they do not touch.
        depth: How deep [m] their completed surfaces lie in each other, of those that hang over each other.
        ahead: By how much [m] the near and the far end of `first` are further along the way out of `then`.
        tilted: How much of `first` was seen in one face that is neither level nor upright, 0..1: what stands
            so leans on something.
    """

    over: Overlap | None
    seen: Overlap | None
    unheld: float
    up: float | None
    depth: float
    ahead: tuple[float, float] = (0.0, 0.0)
    tilted: float = 0.0

    @property
    def meets(self) -> bool:
        """Whether a lift of `then` pushes `first` by more than counts as disturbed.

        Half of that is enough where it rests on it, since it tips once it is caught by an edge.
        """
        least = DISTURBED / 2 if (self.up or 0.0) > CARRIES else DISTURBED
        return self.over is not None and self.over.evasion > least

    @property
    def falls(self) -> bool:
        """Whether `first` falls without `then`."""
        return self.unheld > GUESSED

    @property
    def shows(self) -> bool:
        """Whether `first` lies on `then` or was seen to hang over it."""
        return (self.up or 0.0) > 0.0 or self.seen is not None


def disturbances(situation: Situation) -> dict[Pair, Disturbance]:
    """Ask of every pair whether the lift of the one meets the other, and whether that falls without it.

    Args:
        situation: The scene.

    Returns:
        What was found of those that hang together, or of which one lies over the other.
    """
    statics = situation.statics
    seen, touching = statics.upright.clouds, statics.touch_normals
    outwards = {then: situation.outwards(then) for then in situation.movable}
    over, unheld = _overhangs(statics, outwards), _unheld_shares(statics)
    depth = {frozenset((each.a, each.b)): max(0.0, -float(each.gaps.min())) for each in statics.contacts}
    tilted = {name: tilted_share(seen[name]) for name in situation.movable}
    place = {name: k for k, name in enumerate(situation.movable)}
    together = {pair for part in {*situation.islands.values()} for pair in permutations(part, 2)}
    found: dict[Pair, Disturbance] = {}
    for first, then in sorted(over.keys() | together, key=lambda pair: (place[pair[0]], place[pair[1]])):
        hangs, axes = over.get((first, then)), outwards[then]
        here, there = (along(axes, statics.surfaces[name])[:, 2] for name in (first, then))
        found[first, then] = Disturbance(
            hangs,
            None if hangs is None else overlap(along(axes, seen[first]), along(axes, seen[then])),
            unheld[then].get(first, 0.0) if (first, then) in together else 0.0,
            touching.get((then, first)),
            0.0 if hangs is None else depth.get(frozenset((first, then)), 0.0),
            (float(here.min() - there.min()), float(here.max() - there.max())),
            tilted[first],
        )
    return found


def without_cascades(
    asked: Mapping[Pair, Disturbance], edges: Collection[Pair], statics: Statics
) -> dict[Pair, Disturbance]:
    """Drop falls of objects that would stand once all is gone that goes before them anyway.

    Without one pier the bridge tips and throws the other over; but the bridge goes before either.

    Args:
        asked: What was found of pairs.
        edges: Those of which it is believed.
        statics: The scene at rest.
    """
    before: nx.DiGraph[str] = nx.DiGraph(list(edges))

    @cache
    def fall_of(away: frozenset[str]) -> Collection[str]:
        return fallen_without(statics, away).keys()

    def still(first: str, then: str) -> bool:
        others = nx.ancestors(nx.restricted_view(before, [first], []), then)
        return not others or first in fall_of(frozenset({then, *others}))

    thrown = [pair for pair in edges if not asked[pair].meets and not still(*pair)]
    return {**asked} | {pair: replace(asked[pair], unheld=0.0) for pair in thrown}


def _unheld_shares(statics: Statics) -> dict[str, dict[str, float]]:
    """Without `then`, by `first`: the share of its weight that nothing carries, as `Disturbance` has it."""
    names = statics.upright.movable
    if statics.sight is None:
        return {then: dict.fromkeys(fallen_without(statics, [then]), 1.0) for then in names}
    return {
        then: {first: min(max(more, 0.0), 1.0) for first, more in statics.unheld_without([then]).items()}
        for then in names
    }


def fallen_without(statics: Statics, away: Collection[str], held: Collection[str] = ()) -> dict[str, float]:
    """Find the objects that fall once others are gone.

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
    touching = statics.touch_normals
    normals = {name: [touching[gone, name] for gone in away if (gone, name) in touching] for name in lost}
    lowest = min((statics.weights[name].centre[2] for name in away), default=-np.inf)
    below = {name for name in lost if not normals[name] and statics.weights[name].centre[2] < lowest}
    freed = [name for name in lost if name in below or max(normals[name], default=0.0) < PRESSED]
    unheld = statics.unsteady_without(away, held) if freed else {}
    return {name: far for name, far in lost.items() if name not in freed or name in unheld}


def _overhangs(statics: Statics, outwards: Mapping[str, FloatArray]) -> dict[Pair, Overlap]:
    """(first, then) -> how first hangs over then, where no board that never moves is between them."""
    surfaces, movable = statics.surfaces, statics.upright.movable
    stands_at = {name: statics.upright.floor_under(surfaces[name]) for name in movable}
    found: dict[Pair, Overlap] = {}
    for axes in {frame.tobytes(): frame for frame in outwards.values()}.values():
        level = axes[2, 2] < 1.0
        bodies = {name: along(axes, surfaces[name]) for name in movable}
        for first, then in _over_each_other(bodies, movable):
            if not np.array_equal(outwards[then], axes):
                continue
            if level or float(surfaces[then][:, 2].max()) >= stands_at[first] - BOARD:
                over = overlap(bodies[first], bodies[then])
                found |= {} if over is None else {(first, then): over}
    return found


def _over_each_other(surfaces: Mapping[str, FloatArray], names: Sequence[str]) -> list[Pair]:
    """Ordered pairs of the names whose boxes meet in plan, or nearly: no others hang over each other."""
    plans = [(lower[:2], upper[:2]) for lower, upper in (bounds(surfaces[name]) for name in names)]
    return [(names[i], names[j]) for i, j in near_both_ways(plans, 3 * SWEEP_CELL)]
