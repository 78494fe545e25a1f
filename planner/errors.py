"""What planning raises beside wrong input: that nothing safe exists, with the reason."""

from topple.topology.errors import ToppleError


class NoSafePlan(ToppleError):
    """There is no safe way to do what was asked.

    Attributes:
        certificate: Why not, as lines fit to print: the cycle, the blocking pair, the object out of reach.
    """

    def __init__(self, message: str, certificate: tuple[str, ...] = ()) -> None:
        super().__init__(message)
        self.certificate = certificate
