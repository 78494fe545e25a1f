"""What planning raises beside wrong input: that nothing safe exists, with the reason."""

from typing import TYPE_CHECKING

from topple.topology.errors import ToppleError

if TYPE_CHECKING:
    from topple.planner.pick_place.failure import TransferFailure


class NoSafePlan(ToppleError):
    """There is no safe way to do what was asked.

    Attributes:
        certificate: Why not, as lines fit to print: the cycle, the blocking pair, the object out of reach.
        failures: The objects that could not be moved, each with the step, the check and who barred it.
    """

    def __init__(
        self,
        message: str,
        certificate: tuple[str, ...] = (),
        failures: "tuple[TransferFailure, ...]" = (),
    ) -> None:
        super().__init__(message)
        self.certificate, self.failures = certificate, failures
