"""Counts: how an answer to one scene does against its labels; figures of many of them, with their chance."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

import networkx as nx
import numpy as np

from topple.benchmarks.guesses import Guess
from topple.benchmarks.scores import DRAWS, Labels, judged, unsafe_steps
from topple.benchmarks.truth.geometry import RelationLabels
from topple.benchmarks.truth.mask_faults import NO_FAULTS, MaskFaults
from topple.planner.decide.words import how_sure
from topple.topology.sixim.table import Relation

UNNAMED = ("without a name", "no mask names")
"""What a sentence on what no mask names has in it."""

BINS = (0.0, 0.05, 0.1, 0.2, 0.4, 0.6, 0.8, 0.9, 0.95, 1.0)
"""Bounds of the bins of chances."""


@dataclass(frozen=True)
class Counts:
    """What was counted on one scene, or on several: counts add up.

    Attributes:
        scenes: Scenes.
        unanswered: Of these refused, or ended by a fault.
        pairs: Pairs whose relation is beyond doubt and that were seen.
        related: Of these told rightly.
        apart: Pairs that are apart.
        contacts: Of these told to meet: false contacts.
        touching: Pairs that touch, neither within the other.
        touched: Of these told to.
        nested: Pairs of which one lies within the other, wholly or partly.
        nests: Of these told rightly.
        right: Dependencies of the closure that had to be told and were.
        false: That were and had not to be.
        missed: That had to be and were not.
        told: Dependencies told directly whose label is known.
        wrong: Of these false.
        cycled: Objects in a group that are in no true cycle.
        safe: Scenes cleared in a safe order.
        asked: Targets whose first removal was asked for, less refused ones whose mask is wrong in kind.
        targets: Of these that got an answer.
        harmed: Of these with a first removal that disturbs what is not taken with it.
        free: Targets that disturb nothing if taken at once.
        needless: Of these before which something else is taken.
        steps: Objects taken whose risk was told.
        disturbed: Of these that moved something.
        risk: Sum of the risks told.
        brier: Sum of the squared differences of risk and what came.
        covered: Targets on which something without a mask lies that has to go first.
        bared: Of these taken at once all the same.
        silent: Of these where no sentence says that there is something without a name or a mask.
        faulty: Masks that are wrong in kind.
        said: Of these named in a sentence on masks.
        true: Objects of scenes all of whose masks are right, but for pixels at their borders.
        alarms: Of these named in a sentence on masks.
    """

    scenes: int = 0
    unanswered: int = 0
    pairs: int = 0
    related: int = 0
    apart: int = 0
    contacts: int = 0
    touching: int = 0
    touched: int = 0
    nested: int = 0
    nests: int = 0
    right: int = 0
    false: int = 0
    missed: int = 0
    told: int = 0
    wrong: int = 0
    cycled: int = 0
    safe: int = 0
    asked: int = 0
    targets: int = 0
    harmed: int = 0
    free: int = 0
    needless: int = 0
    steps: int = 0
    disturbed: int = 0
    risk: float = 0.0
    brier: float = 0.0
    covered: int = 0
    bared: int = 0
    silent: int = 0
    faulty: int = 0
    said: int = 0
    true: int = 0
    alarms: int = 0

    def array(self) -> np.ndarray[Any, Any]:
        """All of them, in the order of the fields."""
        return np.array([getattr(self, field.name) for field in fields(self)], dtype=np.float64)


COLUMN = {field.name: k for k, field in enumerate(fields(Counts))}


def count(
    found: Mapping[str, Any], labels: Labels, relations: RelationLabels, faults: MaskFaults = NO_FAULTS
) -> Counts:
    """Count one answer.

    Args:
        found: As `topple.benchmarks.truth.asked.answer` gives it.
        labels: What simulation says.
        relations: What the shapes say.
        faults: What is wrong with the masks.

    Returns:
        The counts; of a refusal, what was to be found is missed.
    """
    always = _of_relations(found, relations) | _of_masks(found, labels, faults) | {"scenes": 1}
    if "refused" in found:
        needed = sum(sign == 1 for firsts in labels.values() for sign in firsts.values())
        return Counts(**always, unanswered=1, missed=needed)
    guess, names = _guessed(found, labels)
    verdicts = judged(guess, labels, names)
    known = [pair for pair in guess.pairs if {*pair} <= {*names} and labels[pair[1]].get(pair[0]) is not None]
    cycles = _cycles(labels, names)
    unsafe = dict(unsafe_steps(guess, labels, names))
    risks = {
        name: float(found["risk"][name]) for name in guess.order if name in found["risk"] and name in names
    }
    firsts = {target: first for target, first in found["first"].items() if target in names and first}
    free = [target for target in firsts if not any(sign == 1 for sign in labels[target].values())]
    return Counts(
        **always,
        right=len(verdicts.right),
        false=len(verdicts.false),
        missed=len(verdicts.missed),
        told=len(known),
        wrong=sum(labels[then][first] == 0 for first, then in known),
        cycled=len(
            {name for group in guess.groups for name in group if name in names and name not in cycles}
        ),
        safe=int(set(names) <= set(guess.order) and not unsafe),
        asked=len((found["first"].keys() - (set(faults.wrong) - firsts.keys())) & set(names)),
        targets=len(firsts),
        harmed=sum(_harms(first, group, labels, cycles, names) for first, group, _ in firsts.values()),
        free=len(free),
        needless=sum(firsts[target][2] > 1 for target in free),
        steps=len(risks),
        disturbed=sum(name in unsafe for name in risks),
        risk=sum(risks.values()),
        brier=sum((risk - (name in unsafe)) ** 2 for name, risk in risks.items()),
    )


def words(found: Mapping[str, Any], labels: Labels) -> list[tuple[str, bool]]:
    """How sure each step of an answer is said to be, and whether it disturbs something."""
    if "refused" in found:
        return []
    guess, names = _guessed(found, labels)
    unsafe, risk = dict(unsafe_steps(guess, labels, names)), found["risk"]
    return [(how_sure(risk[name]), name in unsafe) for name in guess.order if name in risk and name in names]


def _guessed(found: Mapping[str, Any], labels: Labels) -> tuple[Guess, list[str]]:
    """An answer as it is judged, and the names that are."""
    direct = frozenset((first, then) for first, then, *_ in found["dependencies"])
    guess = Guess(direct, tuple(found["order"]), tuple(map(tuple, found["groups"])))
    return guess, [name for name in labels if name in found["objects"]]


def _of_relations(found: Mapping[str, Any], relations: RelationLabels) -> dict[str, int]:
    """Counts of pairs, by what they truly are."""
    told = {(a, b): relation for a, b, relation in found.get("relations", ())}
    told |= {(b, a): str(Relation(relation).converse) for (a, b), relation in told.items()}
    there = set(found.get("names", ()))
    rightly = {"disjoint": list[bool](), "touch": list[bool](), "within": list[bool]()}
    for pair, relation in relations.items():
        if there >= set(pair):
            rightly.get(relation, rightly["within"]).append(told.get(pair, "disjoint") == relation)
    apart, touching, nested = rightly.values()
    return {
        "pairs": len(apart) + len(touching) + len(nested),
        "related": sum(apart) + sum(touching) + sum(nested),
        "apart": len(apart), "contacts": len(apart) - sum(apart),
        "touching": len(touching), "touched": sum(touching), "nested": len(nested), "nests": sum(nested),
    }  # fmt: skip


def _of_masks(found: Mapping[str, Any], labels: Labels, faults: MaskFaults) -> dict[str, int]:
    """Counts of what is said of masks, and of what is taken from under what has none."""
    said = " ".join(text for text in found.get("assumptions", ()) if "mask" in text)
    doubted = {name for name in found.get("objects", ()) if repr(name) in said}
    covered = [then for then in labels if any(labels[then].get(name) == 1 for name in faults.without)]
    firsts = {then: found.get("first", {}).get(then) for then in covered}
    bared = sum(bool(first) and first[0] == then for then, first in firsts.items())
    silent = not any(text in said for said in found.get("assumptions", ()) for text in UNNAMED)
    right = not (faults.without or faults.wrong)
    return {
        "covered": len(covered), "bared": bared, "silent": bared * silent,
        "faulty": len(faults.wrong), "said": len(doubted & set(faults.wrong)),
        "true": len(found.get("objects", ())) * right, "alarms": len(doubted) * right,
    }  # fmt: skip


def chances(found: Mapping[str, Any], labels: Labels) -> list[tuple[float, int]]:
    """Chances told of dependencies, each with whether simulation has it."""
    told = [
        (chance, labels.get(then, {}).get(first)) for first, then, _, chance in found.get("dependencies", ())
    ]
    return [(float(chance), sign) for chance, sign in told if sign is not None]


def _cycles(labels: Labels, names: Sequence[str]) -> dict[str, set[str]]:
    """Objects that truly hold each other."""
    truth: nx.DiGraph[str] = nx.DiGraph([(x, y) for y in names for x in names if labels[y].get(x) == 1])
    return {name: c for c in nx.strongly_connected_components(truth) if len(c) > 1 for name in c}


def _harms(
    first: str, group: Sequence[str], labels: Labels, cycles: Mapping[str, set[str]], names: Sequence[str]
) -> bool:
    """Whether a first removal disturbs what is not taken with it; a group excuses only what truly cycles."""
    together = set(group) & cycles.get(first, set())
    return any(labels.get(first, {}).get(other) == 1 for other in names if other not in together)


@dataclass(frozen=True)
class Figure:
    """A figure of truth.

    Attributes:
        what: What it is.
        value: From summed counts: of one sum, or of sums in rows.
        better: 1 where more is better, -1 where less is.
        part, whole: Columns of a share, which gets Wilson's interval; empty where it is none.
        worst: What it may fall by against the reference, in its own unit; None: it decides nothing.
    """

    what: str
    value: Callable[[np.ndarray[Any, Any]], Any]
    better: int
    part: str = ""
    whole: str = ""
    worst: float | None = None

    def counted(self, sums: np.ndarray[Any, Any]) -> bool:
        """Whether there was anything to count it of in (..., K) sums: always, where it is no share."""
        return not self.whole or bool(np.any(sums[..., COLUMN[self.whole]]))


def _share(what: str, part: str, whole: str, better: int, worst: float | None = None) -> Figure:
    def value(sums: np.ndarray[Any, Any]) -> Any:
        return _over(sums[..., COLUMN[part]], sums[..., COLUMN[whole]], 0.0 if better < 0 else 1.0)

    return Figure(what, value, better, part, whole, worst)


def _over(part: Any, whole: Any, empty: float) -> Any:
    return np.divide(part, whole, out=np.full(np.shape(part), empty), where=np.asarray(whole) > 0)


def _f1(sums: np.ndarray[Any, Any]) -> Any:
    right, false, missed = (sums[..., COLUMN[key]] for key in ("right", "false", "missed"))
    return _over(2 * right, 2 * right + false + missed, 1.0)


def _recall(sums: np.ndarray[Any, Any]) -> Any:
    right, missed = (sums[..., COLUMN[key]] for key in ("right", "missed"))
    return _over(right, right + missed, 1.0)


FIGURES: tuple[Figure, ...] = (
    _share("relations right", "related", "pairs", 1, 0.01),
    _share("false contacts", "contacts", "apart", -1, 0.01),
    _share("touches told", "touched", "touching", 1, 0.02),
    _share("what lies in what, told", "nests", "nested", 1, 0.02),
    Figure("F1 of the closure", _f1, 1, worst=0.01),
    Figure("dependencies found", _recall, 1),
    _share("false dependencies", "wrong", "told", -1),
    Figure("objects in false cycles", lambda sums: _over(sums[..., COLUMN["cycled"]], sums[..., 0], 0.0), -1),
    _share("safe orders", "safe", "scenes", 1, 0.02),
    _share("first removals that disturb", "harmed", "targets", -1, 0.02),
    _share("needless removals", "needless", "free", -1, 0.02),
    Figure(
        "targets unanswered",
        lambda sums: 1.0 - _over(sums[..., COLUMN["targets"]], sums[..., COLUMN["asked"]], 1.0),
        -1,
        worst=0.02,
    ),
    _share("unanswered", "unanswered", "scenes", -1, 0.02),
    _share("taken at once from under what has no mask", "bared", "covered", -1),
    _share("taken at once from under what has no mask, in silence", "silent", "covered", -1, 0.0),
    _share("masks wrong in kind that are said", "said", "faulty", 1, 0.05),
    _share("true masks said to be wrong", "alarms", "true", -1, 0.02),
    Figure(
        "Brier score of risk",
        lambda sums: _over(sums[..., COLUMN["brier"]], sums[..., COLUMN["steps"]], 0.0),
        -1,
    ),
)
"""What is told of each view."""


def base_brier(sums: np.ndarray[Any, Any]) -> float:
    """Brier score of telling every step the same risk: that with which steps disturb."""
    rate = sums[COLUMN["disturbed"]] / max(sums[COLUMN["steps"]], 1.0)
    return float(rate * (1.0 - rate))


def interval(figure: Figure, counts: np.ndarray[Any, Any]) -> tuple[float, float]:
    """95 % interval of a figure over (N, K) counts, by drawing scenes anew."""
    low, high = np.percentile(figure.value(_drawn(counts)), [2.5, 97.5])
    return float(low), float(high)


def difference(
    figure: Figure, ours: np.ndarray[Any, Any], theirs: np.ndarray[Any, Any]
) -> tuple[float, tuple[float, float]]:
    """Paired difference of a figure over the same scenes, positive where ours is better, and its interval.

    Args:
        figure: The figure.
        ours: (N, K) counts.
        theirs: The same of the same scenes by another version.
    """
    value = figure.better * (figure.value(ours.sum(axis=0)) - figure.value(theirs.sum(axis=0)))
    both = _drawn(np.concatenate([ours, theirs], axis=1))
    k = ours.shape[1]
    drawn = figure.better * (figure.value(both[:, :k]) - figure.value(both[:, k:]))
    low, high = np.percentile(drawn, [2.5, 97.5])
    return float(value), (float(low), float(high))


def _drawn(counts: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """Sums (DRAWS, K) over scenes drawn anew."""
    weights = np.random.default_rng(0).multinomial(len(counts), np.full(len(counts), 1 / len(counts)), DRAWS)
    return weights @ counts
