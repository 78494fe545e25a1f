"""What a check found: named residuals, at most 0 where all is well, and a witness for the worst of each."""

import math
from dataclasses import dataclass
from typing import Any

BROKEN = "dependencies of the scene broken"
"""The check that holds a plan's order against the dependencies found in the scene."""


@dataclass(frozen=True)
class Residual:
    """One thing that was checked.

    Attributes:
        name: What.
        value: How far it is beyond what is allowed, at most 0 where all is well; `inf` where not evaluated.
        unit: m, rad, or 1 for counts and shares.
        witness: Where the worst was found, or why it was not evaluated.
        allowed: What was allowed, in the unit.
    """

    name: str
    value: float
    unit: str
    witness: str = ""
    allowed: float = 0.0

    @property
    def evaluated(self) -> bool:
        """Whether it was checked."""
        return math.isfinite(self.value)

    @property
    def ok(self) -> bool:
        """Whether it was checked and found well."""
        return self.value <= 0.0


@dataclass(frozen=True)
class Verification:
    """All residuals of a plan.

    Attributes:
        residuals: One for each check.
        states: How many arm states were looked at.
        allowed: What a step says that it allows and no residual counts: drops, in sentences.
    """

    residuals: tuple[Residual, ...]
    states: int = 0
    allowed: tuple[str, ...] = ()

    @property
    def ok(self) -> bool:
        """Whether every check was done and found well."""
        return all(residual.ok for residual in self.residuals)

    @property
    def failed(self) -> tuple[Residual, ...]:
        """What was checked and is not well."""
        return tuple(residual for residual in self.residuals if residual.evaluated and not residual.ok)

    @property
    def left_out(self) -> tuple[Residual, ...]:
        """What was not evaluated."""
        return tuple(residual for residual in self.residuals if not residual.evaluated)

    def __getitem__(self, name: str) -> float:
        """The value of a residual.

        Raises:
            KeyError: There is none of that name.
        """
        return {residual.name: residual.value for residual in self.residuals}[name]

    def to_json(self) -> dict[str, Any]:
        """As JSON has it; what was not evaluated is null."""
        return {
            "ok": self.ok,
            "states": self.states,
            "allowed": list(self.allowed),
            "residuals": [
                {
                    "name": residual.name,
                    "value": residual.value if residual.evaluated else None,
                    "unit": residual.unit,
                    "allowed": residual.allowed,
                    "witness": residual.witness,
                }
                for residual in self.residuals
            ],
        }


@dataclass
class Worst:
    """The worst of many values of one thing, in the making.

    Attributes:
        name: What.
        unit: Its unit.
        allowed: What is allowed.
        value: The worst so far.
        witness: Where that was.
    """

    name: str
    unit: str
    allowed: float = 0.0
    value: float = 0.0
    witness: str = ""

    def note(self, value: float, witness: str) -> None:
        """Take a value into account."""
        if value > self.value or not math.isfinite(value):
            self.value, self.witness = value, witness

    def residual(self) -> Residual:
        """The residual: the worst value beyond what is allowed."""
        return Residual(self.name, self.value - self.allowed, self.unit, self.witness, self.allowed)


def not_evaluated(name: str, unit: str, why: str) -> Residual:
    """A residual of what could not be checked."""
    return Residual(name, math.inf, unit, why)
