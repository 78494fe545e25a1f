"""One figure of a bench, with what it is compared to and the bar it has to clear."""

import operator
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

Progress = Callable[[str], None]
"""Told in a few words what is being measured."""

_COMPARED = {">=": operator.ge, "<=": operator.le}
_BAR = re.compile(r"(?P<sign>>=|<=|) ?(?P<bar>[0-9.]+)(?:/(?P<divisor>[0-9.]+))?(?P<times>x|)")


@dataclass(frozen=True)
class Row:
    """One figure.

    Attributes:
        what: What was measured.
        value: The figure.
        unit: Its unit, empty for a pure number.
        baseline: What it is compared to.
        baseline_value: The baseline's figure, in the same unit, from the same run.
        ratio: What a bar with an x or a fraction is about: baseline / value (times faster) where the bar is
            a least one, value / baseline (times as long) where it is a largest one.
        bar: What is aimed at, ">= 12x", "<= 1/15", ">= 0.93" or "0"; None where there is none.
        interval: 95 % interval of the figure, where it is a share of few cases.
        tried: On how many cases it was counted, where it counts cases.
        held: In how many of them all was well.
        wrong: What went wrong in the first of the others, in sentences.
        column: The column in which it stands where figures of several methods or kinds stand side by side,
            one line for each `what`; empty where the figure has a line of its own.
    """

    what: str
    value: float
    unit: str
    baseline: str | None = None
    baseline_value: float | None = None
    ratio: float | None = None
    bar: str | None = None
    interval: tuple[float, float] | None = None
    tried: int | None = None
    held: int | None = None
    wrong: tuple[str, ...] = ()
    column: str = ""

    @property
    def ok(self) -> bool | None:
        """Whether the bar is cleared, None where there is none."""
        if self.bar is None:
            return None
        parts = _BAR.fullmatch(self.bar)
        if parts is None:
            raise ValueError(f"{self.what}: {self.bar!r} is no bar")
        bar = float(parts["bar"]) / float(parts["divisor"] or 1)
        figure = self.ratio if parts["times"] or parts["divisor"] else self.value
        return figure is not None and bool(_COMPARED.get(parts["sign"], operator.eq)(figure, bar))

    def to_json(self) -> dict[str, Any]:
        """The row as the contract has it."""
        row: dict[str, Any] = {
            "what": self.what,
            "value": self.value,
            "unit": self.unit,
            "baseline": self.baseline,
            "baseline_value": self.baseline_value,
            "ratio": self.ratio,
            "bar": self.bar,
            "ok": self.ok,
        }
        if self.interval is not None:
            row["interval"] = list(self.interval)
        if self.tried is not None:
            row |= {"tried": self.tried, "held": self.held, "wrong": list(self.wrong)}
        if self.column:
            row["column"] = self.column
        return row


def faster(what: str, seconds: float, baseline: str, theirs: float, bar: str | None = None) -> Row:
    """A row of two times [s] whose ratio says how many times faster ours is."""
    return Row(what, seconds, "s", baseline, theirs, theirs / seconds, bar)


def longer(what: str, seconds: float, baseline: str, theirs: float, bar: str | None = None) -> Row:
    """A row of two times [s] whose ratio says how many times as long ours takes."""
    return Row(what, seconds, "s", baseline, theirs, seconds / theirs, bar)
