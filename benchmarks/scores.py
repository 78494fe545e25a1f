"""How an answer to "what must go first" is scored against what simulation says."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import networkx as nx
import numpy as np

from topple.benchmarks.guesses import Guess
from topple.benchmarks.row import Row

Labels = Mapping[str, Mapping[str, int | None]]
"""then -> first -> 1 had to go first, 0 not, None too close to call."""

DRAWS = 2000
"""Times the piles are drawn anew for an interval."""


@dataclass(frozen=True)
class Score:
    """Counts of one pile, or of several: scores add up.

    Attributes:
        right: Pairs found that had to be.
        false: Pairs found that had not.
        missed: Pairs that had to be and were not found.
        safe: Piles whose order was safe.
        piles: Piles.
        lean: Targets for which nothing is removed beyond what simulation demands.
        targets: Targets.
        unsafe: Objects taken while something was there that would move.
        steps: Objects taken.
    """

    right: int = 0
    false: int = 0
    missed: int = 0
    safe: int = 0
    piles: int = 0
    lean: int = 0
    targets: int = 0
    unsafe: int = 0
    steps: int = 0

    def __add__(self, other: "Score") -> "Score":
        """Counts of both."""
        return Score(*(getattr(self, key) + getattr(other, key) for key in self.__dataclass_fields__))

    @property
    def precision(self) -> float:
        """Share of the pairs found that had to be; 1 where none was found."""
        return self.right / (self.right + self.false) if self.right + self.false else 1.0

    @property
    def recall(self) -> float:
        """Share of the pairs that had to be that were found; 1 where there is none."""
        return self.right / (self.right + self.missed) if self.right + self.missed else 1.0

    @property
    def f1(self) -> float:
        """Harmonic mean of precision and recall."""
        wrong = self.false + self.missed
        return 2 * self.right / (2 * self.right + wrong) if self.right + wrong else 1.0


def score(guess: Guess, labels: Labels, seen: Collection[str]) -> Score:
    """Score an answer to one pile.

    Args:
        guess: The answer.
        labels: What simulation says.
        seen: Objects that are in the scene; others are left out.

    Returns:
        The counts; a pair simulation could not call counts nowhere, and excuses an extra removal.
    """
    names = [name for name in labels if name in seen]
    closure = _closure(names, guess.pairs)
    verdicts = judged(guess, labels, names)
    removed = {name: {first for first, then in closure if then == name} for name in names}
    excused = _closure(names, [(x, y) for y in names for x in names if x != y and labels[y].get(x) != 0])
    return Score(
        right=len(verdicts.right),
        false=len(verdicts.false),
        missed=len(verdicts.missed),
        safe=int(is_safe(guess, labels, names)),
        piles=1,
        lean=sum(all((x, name) in excused for x in removed[name]) for name in names),
        targets=len(names),
        unsafe=len(unsafe_steps(guess, labels, names)),
        steps=sum(name in names for name in guess.order),
    )


@dataclass(frozen=True)
class Verdicts:
    """The pairs (first, then) of an answer against what is true; those too close to call are in none.

    Attributes:
        right: Found, and had to be.
        false: Found, and had not to be.
        missed: Had to be, and were not found.
    """

    right: tuple[tuple[str, str], ...]
    false: tuple[tuple[str, str], ...]
    missed: tuple[tuple[str, str], ...]


def judged(guess: Guess, labels: Labels, seen: Collection[str]) -> Verdicts:
    """Hold what follows from an answer's pairs against the labels.

    Args:
        guess: The answer.
        labels: What is true.
        seen: Objects that are in the scene; others are left out.
    """
    names = [name for name in labels if name in seen]
    closure = _closure(names, guess.pairs)
    found: dict[tuple[object, bool], list[tuple[str, str]]] = {}
    for then in names:
        for first in names:
            if first != then:
                key = (labels[then].get(first), (first, then) in closure)
                found.setdefault(key, []).append((first, then))
    return Verdicts(*(tuple(found.get(key, ())) for key in ((1, True), (0, True), (1, False))))


def is_safe(guess: Guess, labels: Labels, names: Collection[str]) -> bool:
    """Whether an order takes everything, and nothing while something is there that would move.

    Args:
        guess: The order and its groups; a group excuses objects simulation has in one cycle.
        labels: What simulation says.
        names: Everything there is to take.
    """
    return set(names) <= set(guess.order) and not unsafe_steps(guess, labels, names)


def unsafe_steps(
    guess: Guess, labels: Labels, names: Collection[str]
) -> tuple[tuple[str, tuple[str, ...]], ...]:
    """What an order takes while something is there that would move.

    Args:
        guess: The order and its groups; a group excuses objects simulation has in one cycle.
        labels: What simulation says.
        names: Everything there is to take; what else the order takes is passed over.

    Returns:
        Each such object with those that would move.
    """
    truth: nx.DiGraph[str] = nx.DiGraph([(x, y) for y in names for x in names if labels[y].get(x) == 1])
    cycle = {name: c for c in nx.strongly_connected_components(truth) for name in c}
    left, unsafe = set(names), list[tuple[str, tuple[str, ...]]]()
    for name in guess.order:
        if name not in left:
            continue
        together = {other for group in guess.groups if name in group for other in group}
        staying = left - {name} - (together & cycle.get(name, set()))
        if moved := tuple(sorted(other for other in staying if labels[name].get(other) == 1)):
            unsafe.append((name, moved))
        left.discard(name)
    return tuple(unsafe)


def _closure(names: Collection[str], pairs: Collection[tuple[str, str]]) -> set[tuple[str, str]]:
    """All (first, then) that follow from some."""
    graph: nx.DiGraph[str] = nx.DiGraph()
    graph.add_nodes_from(names)
    graph.add_edges_from(pairs)
    return {(x, y) for x, y in nx.transitive_closure(graph).edges if x != y}


def f1_interval(scores: Sequence[Score]) -> tuple[float, float]:
    """95 % interval of the pooled F1, by drawing piles anew."""
    counts = np.array([(s.right, s.false + s.missed) for s in scores])
    drawn = np.random.default_rng(0).integers(len(scores), size=(DRAWS, len(scores)))
    right, wrong = counts[drawn].sum(axis=1).T
    f1 = np.divide(2 * right, 2 * right + wrong, out=np.ones(DRAWS), where=right + wrong > 0)
    low, high = np.percentile(f1, [2.5, 97.5])
    return float(low), float(high)


def share(
    what: str,
    held: int,
    tried: int,
    bar: str | None = None,
    *,
    against: tuple[str, int, int] | None = None,
    counted: bool = False,
    wrong: Sequence[str] = (),
    column: str = "",
) -> Row:
    """A row of a share in percent with Wilson's interval, beside a baseline's.

    Args:
        what: What was counted.
        held: How often it held.
        tried: Of how many.
        bar: What is aimed at.
        against: A baseline, and the same two counts of it.
        counted: Whether both counts have columns of their own.
        wrong: What went wrong in the first of the others.
        column: As in a `Row`.
    """
    name, part, whole = against or (None, 0, 0)
    return Row(
        what, percent(held, tried), "%", name, percent(part, whole) if name else None, bar=bar,
        interval=share_interval(held, tried), tried=tried if counted else None,
        held=held if counted else None, wrong=tuple(wrong), column=column,
    )  # fmt: skip


def percent(part: int, whole: int) -> float:
    """A share in percent; none of nothing."""
    return 100 * part / max(whole, 1)


def share_interval(part: int, whole: int) -> tuple[float, float]:
    """Wilson's 95 % interval of a share, in percent."""
    if whole == 0:
        return 0.0, 100.0
    z, share = 1.96, part / whole
    centre = (share + z**2 / (2 * whole)) / (1 + z**2 / whole)
    half = z / (1 + z**2 / whole) * np.sqrt(share * (1 - share) / whole + z**2 / (4 * whole**2))
    return 100 * max(centre - float(half), 0.0), 100 * min(centre + float(half), 1.0)
