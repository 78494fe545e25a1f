"""Counts what reasoning overlooks and simulated lifts get wrong: `python -m topple.benchmarks.rates`.

Seeded piles are made, lifted from in simulation as they truly are, and again as they are rebuilt from their
clouds. What comes out is what `topple.planner.decide.rates` holds; no score is reported on these piles.
"""

import argparse
from collections.abc import Iterable, Mapping, Sequence

import networkx as nx
import numpy as np

from topple.benchmarks.piles import make_pile, observe, truth
from topple.benchmarks.scores import Labels
from topple.planner.cli.console import print_json
from topple.planner.decide.dependency import dependencies
from topple.planner.decide.disturbance import Pair
from topple.planner.decide.rates import stances
from topple.planner.simulate.votes import Votes, ask
from topple.topology.base.arrays import FloatArray
from topple.topology.situation.situation import Situation

FIRST_PILE = 7_300_000
"""Seed of the first pile; every other one follows, those between are for trying things out."""


Counts = tuple[FloatArray, FloatArray]
"""(2, 4, 2) pairs by whether both bodies stood still by themselves or not and by how many of three trials
moved, and (3, 2, 2) pairs of which reasoning found nothing, by `topple.planner.decide.rates.stances`; of
each those with a dependency and those without."""


def counted(
    labels: Labels, votes: Votes, found: Iterable[Pair], stand: Mapping[Pair, tuple[int, int]]
) -> Counts:
    """Count one pile.

    Args:
        labels: What is true.
        votes: What simulation said, of all three trials.
        found: Of which pairs reasoning found a dependency.
        stand: How the objects stand to each other.
    """
    trials, overlooked = np.zeros((2, 4, 2)), np.zeros((3, 2, 2))
    implied = set(nx.transitive_closure(nx.DiGraph(list(found))).edges)
    for (first, then), moved in votes.moved.items():
        label = labels[then].get(first)
        if label is not None:
            trials[int(not votes.steady(first, then)), sum(moved), 1 - label] += 1
            if (first, then) not in implied:
                overlooked[(*stand[first, then], 1 - label)] += 1
    return trials, overlooked


def rates(counts: Sequence[Counts]) -> dict[str, list[list[float]]]:
    """The rates of counts, half a case added to each."""
    trials, overlooked = (np.sum(each, axis=0) + 0.5 for each in zip(*counts, strict=True))
    steady, shaky = (trials / trials.sum(axis=1, keepdims=True)).round(3).tolist()
    rows = (overlooked[..., 0] / overlooked.sum(axis=-1)).round(3).tolist()
    return {"steady": steady, "shaky": shaky, "overlooked": rows}


def count_pile(seed: int, view: int) -> Counts:
    """Make a pile and count.

    Args:
        seed: Of the pile.
        view: Cameras, 0 for whole surfaces.
    """
    pile = make_pile(seed)
    situation = Situation(observe(pile, view, seed))
    graph = dependencies(situation, direct=False)
    votes = ask(situation.statics, graph)
    found = [(edge.first, edge.then) for edge in graph.dependencies]
    return counted(truth(pile), votes, found, stances(situation.statics))


def main() -> None:
    """Count and print the rates as JSON."""
    parser = argparse.ArgumentParser(description="Count error rates of reasoning and of simulated lifts.")
    parser.add_argument("--cameras", type=int, choices=(0, 1, 3), default=0, help="0: whole surfaces")
    parser.add_argument("--piles", type=int, default=40, help="how many piles, about half a minute each")
    args = parser.parse_args()
    counts = [count_pile(FIRST_PILE + 2 * number, args.cameras) for number in range(args.piles)]
    print_json({"cameras": args.cameras, "piles": args.piles, **rates(counts)})


if __name__ == "__main__":
    main()
