"""What planning raises beside wrong input: that nothing safe exists, with the reason."""

from typing import TYPE_CHECKING, Any

from topple.topology.base.errors import ToppleError

if TYPE_CHECKING:
    from topple.planner.failure import TransferFailure


class NoSafePlan(ToppleError):
    """There is no safe way to do what was asked.

    Attributes:
        certificate: Why not, as lines fit to print: the cycle, the blocking pair, the object out of reach.
        failures: The objects that could not be moved, each with the step, the check and what barred it.

    Examples:
        >>> NoSafePlan("each holds the other", certificate=("cup", "plate")).certificate
        ('cup', 'plate')
    """

    def __init__(
        self,
        message: str,
        certificate: tuple[str, ...] = (),
        failures: "tuple[TransferFailure, ...]" = (),
    ) -> None:
        super().__init__(message)
        self.certificate, self.failures = certificate, failures


class ArmFault(ToppleError):
    """The arm cannot go on: its hand does not let go, or it is not where it should be."""


def refusal_json(command: str, error: ToppleError, goal: str) -> dict[str, Any]:
    """The object that `topple plan --json` and `topple run --json` print where nothing safe can be done.

    Args:
        command: "plan" or "run".
        error: Why not: `NoSafePlan`, or that the arm finds no place to stand.
        goal: What was wanted.

    Returns:
        `format` and `format_version` as with a plan or a run; `goal`; `steps`, empty; `safe` false for a
        plan, `success` false and the reasons as `violations` for a run; `kind`, the name of the error;
        `message`; `certificate`, the reasons as lines; `failures`, each the `object` that could not be moved,
        the `reasons` with how often each was met, and `blocked_by`, the object in the way or null.
    """
    certificate = list(getattr(error, "certificate", ())) or [str(error)]
    outcome = {"safe": False} if command == "plan" else {"success": False, "violations": certificate}
    failures: tuple[TransferFailure, ...] = getattr(error, "failures", ())
    return {
        "format": f"topple.{command}",
        "format_version": 1,
        "goal": goal,
        "steps": [],
        **outcome,
        "kind": type(error).__name__,
        "message": str(error),
        "certificate": certificate,
        "failures": [
            {"object": each.object, "reasons": dict(each.reasons), "blocked_by": each.blocking}
            for each in failures
        ],
    }
