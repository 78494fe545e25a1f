"""What watches a run from outside: it may judge, and never decides."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

from topple.planner.decide.goal import Goal
from topple.planner.transfer.transfer import Transfer


@dataclass(frozen=True)
class Verdict:
    """What one action did besides what it was meant to do.

    Attributes:
        violations: One sentence for each thing that was moved, turned, dropped or hit.
        disturbed: Distance [m] and angle [rad] by which everything else moved, by name.
        severity: How far the middle of what moved by more than counts fell [m], and with which energy [J].
        tilts: How far the others were tipped [rad], by name.
        forces: Largest contact force of the robot on an object not handled [N], by name.
        impulses: What that contact amounted to over time [N s], by name.
        slip: Distance [m] and angle [rad] by which the object moved in the hand; None where it was not held.
        dropped: Whether the object fell out of the hand, further than crockery survives.
        robot_seconds: How long the arm took; None where not measured.
    """

    violations: tuple[str, ...] = ()
    disturbed: Mapping[str, tuple[float, float]] = field(default_factory=dict[str, tuple[float, float]])
    severity: Mapping[str, tuple[float, float]] = field(default_factory=dict[str, tuple[float, float]])
    tilts: Mapping[str, float] = field(default_factory=dict[str, float])
    forces: Mapping[str, float] = field(default_factory=dict[str, float])
    impulses: Mapping[str, float] = field(default_factory=dict[str, float])
    slip: tuple[float, float] | None = None
    dropped: bool = False
    robot_seconds: float | None = None


@runtime_checkable
class Monitor(Protocol):
    """Looks on from before an action until the arm has withdrawn, and at the end of a run."""

    def begin(self, transfer: Transfer, held: str | None = None, by_second: bool = False) -> None:
        """Look before an action.

        Args:
            transfer: What is about to be done.
            held: What the other arm holds meanwhile, which counts like everything else.
            by_second: Whether the second arm does it.
        """
        ...

    def moment(self, moment: str, tool: str) -> None:
        """Look at the hand at a moment of `topple.planner.execution.execute`."""
        ...

    def verdict(self) -> Verdict:
        """Say what the action did, now that all has come to rest."""
        ...

    def unmet(self, goal: Goal) -> tuple[str, ...]:
        """Say in words what of a goal does not hold, whatever the cameras make of it."""
        ...


class NoMonitor:
    """Looks on at nothing: for an arm whose surroundings nobody but its own cameras sees."""

    def begin(self, transfer: Transfer, held: str | None = None, by_second: bool = False) -> None:
        """Look away."""

    def moment(self, moment: str, tool: str) -> None:
        """Look away."""

    def verdict(self) -> Verdict:
        """Know of nothing."""
        return Verdict()

    def unmet(self, goal: Goal) -> tuple[str, ...]:
        """Know of nothing."""
        return ()
