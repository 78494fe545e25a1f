"""A stand-in for a transfer, with what the judge of a run asks about it."""


class Handled:
    """A transfer of one object, in which nothing rides."""

    def __init__(self, name: str) -> None:
        self.object = name
        self.riding = ()
