"""What checks found: residuals, at most 0 where all is well, and what they prove of each step."""

import math
from dataclasses import dataclass
from typing import Any

import msgspec


@dataclass(frozen=True)
class Residual:
    """One thing that was checked.

    Attributes:
        name: What.
        value: How far it is beyond what is allowed, at most 0 where all is well; `inf` where not evaluated.
        unit: m, rad, or 1 for counts and shares.
        witness: Where the worst was found, or why it was not evaluated.
        allowed: What was allowed, in the unit.
        steps: Indices of the steps in which more than that was found.
    """

    name: str
    value: float
    unit: str
    witness: str = ""
    allowed: float = 0.0
    steps: tuple[int, ...] = ()

    @property
    def evaluated(self) -> bool:
        """Whether it was checked."""
        return math.isfinite(self.value)

    @property
    def ok(self) -> bool:
        """Whether it was checked and found well."""
        return self.value <= 0.0


@dataclass(frozen=True)
class Proof:
    """Something that a plan claims, and whether a check bears it out.

    Attributes:
        what: What is claimed, in a few words.
        means: By which means it is looked at.
        shown: True where they bear it out, False where they refute it, None where they do not tell.
        detail: Figures; where it is refuted by what, and where it is not told why not.
    """

    what: str
    means: str
    shown: bool | None
    detail: str = ""


@dataclass(frozen=True)
class StepProofs:
    """What is proven of one step, and what is not.

    Attributes:
        step: Its index, from 0.
        object: What it moves.
        action: What it does with that.
        proofs: What is claimed of it, in the order in which it happens.
    """

    step: int
    object: str
    action: str
    proofs: tuple[Proof, ...]

    @property
    def proven(self) -> tuple[Proof, ...]:
        """Claims that were confirmed."""
        return tuple(proof for proof in self.proofs if proof.shown)

    @property
    def refuted(self) -> tuple[Proof, ...]:
        """Claims that are false."""
        return tuple(proof for proof in self.proofs if proof.shown is False)

    @property
    def unchecked(self) -> tuple[Proof, ...]:
        """Claims that were neither confirmed nor refuted."""
        return tuple(proof for proof in self.proofs if proof.shown is None)


@dataclass(frozen=True)
class Verification:
    """All residuals of a plan.

    Attributes:
        residuals: One for each check.
        states: How many arm states were looked at.
        allowed: What a step says that it allows and no residual counts: drops, in sentences.
        steps: What this proves of each step, and what not.
        whole: What it proves of the plan as a whole.
        unasked: What is asked of no plan.
    """

    residuals: tuple[Residual, ...]
    states: int = 0
    allowed: tuple[str, ...] = ()
    steps: tuple[StepProofs, ...] = ()
    whole: tuple[Proof, ...] = ()
    unasked: tuple[str, ...] = ()

    @property
    def ok(self) -> bool:
        """Whether every check was done and found well."""
        return all(residual.ok for residual in self.residuals)

    @property
    def failed(self) -> tuple[Residual, ...]:
        """Residuals that were evaluated and are beyond their limit."""
        return tuple(residual for residual in self.residuals if residual.evaluated and not residual.ok)

    @property
    def refuted(self) -> tuple[Proof, ...]:
        """Claims of the plan that are false, of its steps and as a whole."""
        of_steps = (proof for step in self.steps for proof in step.refuted)
        return (*of_steps, *(proof for proof in self.whole if proof.shown is False))

    @property
    def left_out(self) -> tuple[Residual, ...]:
        """Residuals that were not evaluated."""
        return tuple(residual for residual in self.residuals if not residual.evaluated)

    def __getitem__(self, name: str) -> float:
        """The value of a residual.

        Raises:
            KeyError: There is none of that name.
        """
        return {residual.name: residual.value for residual in self.residuals}[name]

    def to_json(self) -> dict[str, Any]:
        """As JSON has it; what was not evaluated is null."""
        return {"ok": self.ok, **msgspec.json.decode(msgspec.json.encode(self))}
