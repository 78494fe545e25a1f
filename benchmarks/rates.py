"""Counts how often reasoning and simulated lifts are wrong: `python -m topple.benchmarks.rates --view 3`.

Seeded piles are made, lifted from in simulation as they truly are, and again as they are rebuilt from their
clouds. What comes out is what `topple.planner.decide.rates` holds; no score is reported on these piles.
"""

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import networkx as nx
import numpy as np

from topple.benchmarks.piles import make_pile, observe, truth
from topple.benchmarks.scores import Labels
from topple.planner.cli.console import print_json
from topple.planner.decide.chances import standing
from topple.planner.decide.dependency import dependencies, ways_found
from topple.planner.decide.rates import Rates
from topple.planner.simulate.votes import Votes, ask
from topple.topology.arrays import FloatArray
from topple.topology.situation import Situation

FIRST_PILE = 7_300_000
"""Seed of the first pile; every other one follows, those between are for trying things out."""


@dataclass(frozen=True, eq=False)
class Counts:
    """How often something happened, with a dependency and without (last axis).

    Attributes:
        steady: (4, 2) by how many of three trials moved, both bodies standing still by themselves.
        shaky: (4, 2) the same where one of them did not.
        overlooked: (3, 2, 2) pairs for which reasoning found nothing, by
            `topple.planner.decide.chances.standing`.
        found: (4, 2) pairs for which it found something, by `topple.planner.decide.rates.way_found`.
    """

    steady: FloatArray
    shaky: FloatArray
    overlooked: FloatArray
    found: FloatArray

    @staticmethod
    def of(
        labels: Labels,
        ways: Mapping[tuple[str, str], int],
        votes: Votes,
        stand: Mapping[tuple[str, str], tuple[int, int]],
    ) -> "Counts":
        """Count one pile.

        Args:
            labels: What is true.
            ways: (first, then) -> in which way reasoning found it, of all that it found.
            votes: What simulation said, of all three trials.
            stand: How the objects stand to each other.
        """
        steady, shaky, found = np.zeros((4, 2)), np.zeros((4, 2)), np.zeros((4, 2))
        overlooked = np.zeros((3, 2, 2))
        implied = set(nx.transitive_closure(nx.DiGraph(list(ways))).edges)
        for (first, then), moved in votes.moved.items():
            label = labels[then].get(first)
            if label is None:
                continue
            (steady if votes.steady(first, then) else shaky)[sum(moved), 1 - label] += 1
            if (first, then) in ways:
                found[ways[first, then], 1 - label] += 1
            if (first, then) not in implied:
                overlooked[(*stand[first, then], 1 - label)] += 1
        return Counts(steady, shaky, overlooked, found)

    def rates(self, others: Sequence["Counts"]) -> Rates:
        """The rates of these and other counts, half a case added to each."""
        every = (self, *others)
        steady = np.sum([counts.steady for counts in every], axis=0) + 0.5
        shaky = np.sum([counts.shaky for counts in every], axis=0) + 0.5
        overlooked = np.sum([counts.overlooked for counts in every], axis=0) + 0.5
        found = np.sum([counts.found for counts in every], axis=0) + 0.5
        both, wide, narrow, falls = (round(float(share), 3) for share in found[:, 0] / found.sum(axis=1))
        return Rates(
            _rows(steady / steady.sum(axis=0)),
            _rows(shaky / shaky.sum(axis=0)),
            _rows(overlooked[..., 0] / overlooked.sum(axis=-1)),
            (both, wide, narrow, falls),
        )


def _rows(table: FloatArray) -> tuple[tuple[float, float], ...]:
    """A (k, 2) table as tuples of three decimals."""
    return tuple((round(float(row[0]), 3), round(float(row[1]), 3)) for row in table)


def count_pile(seed: int, view: int) -> Counts:
    """Make a pile and count.

    Args:
        seed: Of the pile.
        view: Cameras, 0 for whole surfaces.
    """
    pile = make_pile(seed)
    situation = Situation(observe(pile, view, seed))
    statics, graph = situation.statics, dependencies(situation, direct=False)
    votes = ask(statics, graph)
    return Counts.of(truth(pile), ways_found(situation), votes, standing(statics))


def main() -> None:
    """Count and print the rates as JSON."""
    parser = argparse.ArgumentParser(description="Count error rates of reasoning and of simulated lifts.")
    parser.add_argument("--view", type=int, choices=(0, 1, 3), default=0, help="cameras, 0: whole surfaces")
    parser.add_argument("--piles", type=int, default=40, help="how many piles, about half a minute each")
    args = parser.parse_args()
    first, *others = (count_pile(FIRST_PILE + 2 * number, args.view) for number in range(args.piles))
    rates = first.rates(others)
    print_json(
        {"view": args.view, "piles": args.piles, "steady": rates.steady, "shaky": rates.shaky,
         "overlooked": rates.overlooked, "found": rates.found}
    )  # fmt: skip


if __name__ == "__main__":
    main()
