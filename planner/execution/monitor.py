"""What watches a run from outside: it may judge, and never decides."""

from typing import Protocol, runtime_checkable

from topple.planner.decide.goal import Goal
from topple.planner.formats.run_record import Verdict
from topple.planner.transfer.transfer import Transfer


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
