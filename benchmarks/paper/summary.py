"""Rows from outcomes: per scene as the paper's tables, sums, relation by relation, and from few views."""

from collections.abc import Callable, Sequence

import numpy as np

from topple.benchmarks.paper.case import Judged, Outcome
from topple.benchmarks.paper.columns import BOXES, CONTACT_POINTS, ESTIMATED, NINE, PLAIN, SUPPORT, TOPPLE
from topple.benchmarks.paper.looks import FEW, ONE, THREE, WHOLE
from topple.benchmarks.paper.truth import (
    AABB,
    FEATURES,
    LEARNING,
    PAPER_6IM,
    RGBD,
    SCENES,
    YCB,
    published,
    published_right,
)
from topple.benchmarks.row import Row
from topple.topology.sixim.table import Relation

PUBLISHED = {
    TOPPLE: PAPER_6IM, PLAIN: PAPER_6IM, ESTIMATED: PAPER_6IM,
    NINE: PAPER_6IM, BOXES: AABB, SUPPORT: FEATURES, CONTACT_POINTS: LEARNING,
}  # fmt: skip
"""The paper's column that stands beside each of ours."""
GROUPS = ((RGBD, FEW, "scenes 1-7, 2 views"), (YCB, WHOLE, "scenes 8-14, whole surfaces"))
BARS = {(RGBD, TOPPLE): ">= 54", (YCB, TOPPLE): ">= 75", (YCB, PLAIN): ">= 70"}
"""Pairs that are to be right."""
_T = (12.71, 4.30, 3.18, 2.78, 2.57, 2.45, 2.36, 2.31, 2.26)
"""Student's t for 95 % with 1 to 9 degrees of freedom."""


def report(outcomes: Sequence[Outcome], install: str | None = None) -> list[Row]:
    """All rows.

    Args:
        outcomes: Of every variant, way of looking and column.
        install: What to say in place of the learning column, None where it is there.

    Returns:
        Sums with their bars first, then views, classes, and every scene.
    """
    found: list[Row] = []
    names = list(dict.fromkeys(outcome.column for outcome in outcomes))
    for numbers, how, what in GROUPS:
        for column in names:
            found += _sums(outcomes, numbers, how, column, what)
    if install is not None:
        found.append(Row(f"{CONTACT_POINTS} column left out: {install}", 0.0, ""))
    for how in (ONE, THREE):
        for column in (TOPPLE, PLAIN, ESTIMATED):
            found += _views(outcomes, how, column)
    found += _classes(outcomes)
    for numbers, how, _ in GROUPS:
        for number in numbers:
            found += [_scene(outcomes, number, how, column) for column in names]
    return [row for row in found if not np.isnan(row.value)]


def _chosen(
    outcomes: Sequence[Outcome], numbers: Sequence[int], how: str, column: str
) -> list[list[Outcome]]:
    """The outcomes of a column, one list per variant."""
    variants: dict[int, list[Outcome]] = {}
    for one in outcomes:
        if one.number in numbers and one.how == how and one.column == column:
            variants.setdefault(one.variant, []).append(one)
    return [variants[key] for key in sorted(variants)]


def _mean(values: Sequence[float]) -> tuple[float, tuple[float, float] | None]:
    """Mean and 95 % interval of the mean."""
    if not values:
        return float("nan"), None
    mean = float(np.mean(values))
    if len(values) < 2:
        return mean, None
    wide = _T[min(len(values) - 2, len(_T) - 1)] * float(np.std(values, ddof=1)) / len(values) ** 0.5
    return mean, (mean - wide, mean + wide)


def _figure(
    what: str, unit: str, values: Sequence[float], theirs: str | None = None, their: float | None = None,
    bar: str | None = None, column: str = "",
) -> Row:  # fmt: skip
    value, interval = _mean(values)
    return Row(what, value, unit, theirs, their, None, bar, interval, column=column)


def _count(variants: Sequence[Sequence[Outcome]], wanted: Callable[[Judged], bool]) -> list[float]:
    """Per variant, how many pairs are wanted."""
    return [float(sum(wanted(pair) for one in found for pair in one.pairs)) for found in variants]


def _sums(
    outcomes: Sequence[Outcome], numbers: tuple[int, ...], how: str, column: str, what: str
) -> list[Row]:
    variants = _chosen(outcomes, numbers, how, column)
    total = sum(len(SCENES[number].pairs) for number in numbers)
    contacts = sum(len(SCENES[number].listed) for number in numbers)
    method = PUBLISHED[column]
    seconds = [sum(one.seconds for one in found) for found in variants]
    right = _count(variants, lambda pair: pair.right)
    return [
        _figure(
            f"{what}: right of {total}", "pairs", right, f"{method}, published",
            published_right(method, numbers), BARS.get((numbers, column)), column,
        ),
        _figure(
            f"{what}: not disjoint and right of {contacts}", "pairs",
            _count(variants, lambda pair: pair.right and pair.is_contact), column=column,
        ),
        _figure(
            f"{what}: CPU time", "s", seconds, f"{method}, published",
            sum(published(method, number).seconds for number in numbers), column=column,
        ),
    ]  # fmt: skip


def _views(outcomes: Sequence[Outcome], how: str, column: str) -> list[Row]:
    """Relations, contacts and false contacts of scenes 8 to 14 where cameras look."""
    variants = _chosen(outcomes, YCB, how, column)
    held = how == ONE and column == TOPPLE
    total = sum(len(SCENES[number].pairs) for number in YCB)
    contacts = sum(len(SCENES[number].listed) for number in YCB)
    what = f"scenes 8-14, {how}"
    right = [100 * value / total for value in _count(variants, lambda pair: pair.right)]
    return [
        _figure(f"{what}: relations right", "%", right, bar=">= 90" if held else None, column=column),
        _figure(
            f"{what}: contacts found of {contacts}", "pairs",
            _count(variants, lambda pair: pair.is_contact and pair.claimed), bar=">= 29" if held else None,
            column=column,
        ),
        _figure(
            f"{what}: false contacts", "pairs",
            _count(variants, lambda pair: pair.claimed and not pair.is_contact), bar="<= 1" if held else None,
            column=column,
        ),
    ]  # fmt: skip


def _classes(outcomes: Sequence[Outcome]) -> list[Row]:
    """Share of the pairs of each true relation that topple and the paper's rule have right."""
    found: list[Row] = []
    for numbers, how, what in GROUPS:
        for relation in (Relation.DISJOINT, Relation.TOUCH, Relation.PARTIAL_WITHIN, Relation.WITHIN):
            for column in (TOPPLE, PLAIN):
                variants = _chosen(outcomes, numbers, how, column)
                every = _count(variants, lambda pair, relation=relation: pair.true is relation)
                right = _count(variants, lambda pair, relation=relation: pair.true is relation and pair.right)
                shares = [100 * r / e for r, e in zip(right, every, strict=True) if e]
                found.append(_figure(f"{what}: right of the {relation} pairs", "%", shares, column=column))
    return found


def _scene(outcomes: Sequence[Outcome], number: int, how: str, column: str) -> Row:
    """Pairs of one scene that are right, beside the paper's."""
    right = _count(_chosen(outcomes, (number,), how, column), lambda pair: pair.right)
    method = PUBLISHED[column]
    return _figure(
        f"scene {number}: right of {len(SCENES[number].pairs)}", "pairs", right, f"{method}, published",
        published_right(method, (number,)), column=column,
    )  # fmt: skip
