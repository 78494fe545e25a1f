"""Counts how often relations and supports are true: `python -m topple.benchmarks.confidence > FILE`.

Seeded piles are settled, where the simulation knows which surfaces are within `NEAR` of each other and what
carries what. The result is topology's `confidence.json`; no score is reported on these piles.
"""

import argparse
import os
from collections import Counter, defaultdict
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from itertools import combinations
from multiprocessing import get_context

from topple.benchmarks.piles import Pile, make_pile, observe
from topple.planner.cli.console import print_json
from topple.robots.engine import pybullet
from topple.topology.relations.inferred import FLOATS
from topple.topology.relations.robust import inner_share
from topple.topology.situation.situation import Situation
from topple.topology.sixim.confidence import EDGES, Evidence, bin_of, view_of
from topple.topology.sixim.pair import PairRelation
from topple.topology.sixim.table import Relation

FIRST_PILE = 7_500_000
"""Seed of the first pile."""
NEAR = 0.002
"""Distance [m] up to which surfaces count as touching: the deviation of a depth camera."""
CARRIED = 0.02
"""Upward force [N] from which one carries: the weight of two grams."""
VIEWS = (0, 1, 3)
"""Cameras that look."""

Case = tuple[str, Evidence, int, bool]
"""View, kind of evidence, bin, and whether it told the truth."""


def count_pile(seed: int) -> Counter[Case]:
    """Make a pile, relate what is seen of it, and count.

    Args:
        seed: Of the pile.
    """
    pile = make_pile(seed)
    near, carries = _true(pile)
    found: Counter[Case] = Counter()
    for view in VIEWS:
        situation = Situation(observe(pile, view, seed))
        deviation = situation.relations.deviation
        for pair in situation.relations:
            if pair.gap_exact:
                kind, measure = evidence_of(pair, deviation)
                apart = pair.relation is Relation.DISJOINT
                right = apart != (frozenset((pair.a, pair.b)) in near)
                found[view_of(view), kind, bin_of(kind, measure), right] += 1
        for support in situation.supports:
            kind = Evidence.CARRIES_UNSEEN if support.inferred else Evidence.CARRIES
            right = (support.supporter, support.supported) in carries
            found[view_of(view), kind, bin_of(kind, support.gap), right] += 1
    return found


def evidence_of(pair: PairRelation, deviation: float) -> tuple[Evidence, float]:
    """Kind and measure of the evidence that a pair's relation rests on."""
    if pair.inferred:
        return (Evidence.FLOATS if pair.reason == FLOATS else Evidence.MEETS), 0.0
    if pair.relation is Relation.DISJOINT:
        return (Evidence.APART, pair.gap / deviation) if pair.observed else (Evidence.APART_UNSEEN, pair.gap)
    if pair.relation is Relation.TOUCH:
        return Evidence.TOUCH, pair.gap / deviation
    return Evidence.INSIDE, inner_share(pair.matrix)


def _true(pile: Pile) -> tuple[set[frozenset[str]], set[tuple[str, str]]]:
    """Pairs within `NEAR`, and (supporter, supported)."""
    near: set[frozenset[str]] = set()
    lifted: defaultdict[tuple[str, str], float] = defaultdict(float)
    with pile.world() as world:
        world.settle(1.0)
        for a, b in combinations(world.names, 2):
            if pybullet.getClosestPoints(world.ids[a], world.ids[b], NEAR, physicsClientId=world.client):
                near.add(frozenset((a, b)))
        for contact in world.contacts():
            lift = contact.force * float(contact.normal[2])  # on the first of the two
            lifted[contact.b, contact.a] += lift
            lifted[contact.a, contact.b] -= lift
    return near, {pair for pair, lift in lifted.items() if lift > CARRIED}


def _table(cases: Counter[Case]) -> dict[str, dict[str, list[list[int]]]]:
    """Right and wrong ones by view, kind and bin."""
    return {
        view_of(view): {
            str(kind): [
                [cases[view_of(view), kind, number, right] for right in (True, False)]
                for number in range(len(EDGES.get(kind, ())) + 1)
            ]
            for kind in Evidence
        }
        for view in VIEWS
    }


def _counts(seeds: range) -> Iterator[Counter[Case]]:
    with ProcessPoolExecutor(os.cpu_count() or 1, get_context("spawn")) as pool:
        yield from pool.map(count_pile, seeds)


def main() -> None:
    """Count and print as JSON."""
    parser = argparse.ArgumentParser(description="Count how often relations and supports are true.")
    parser.add_argument("--piles", type=int, default=60, help="how many piles, a few seconds each")
    piles = parser.parse_args().piles
    cases: Counter[Case] = Counter()
    for counted in _counts(range(FIRST_PILE, FIRST_PILE + piles)):
        cases.update(counted)
    print_json(
        {"made_by": f"python -m topple.benchmarks.confidence --piles {piles}", "first_seed": FIRST_PILE,
         "near": NEAR, "counted": _table(cases)}
    )  # fmt: skip


if __name__ == "__main__":
    main()
