"""The errors topple raises: one base, told apart by what the caller can do about them."""

from collections.abc import Iterable


class ToppleError(Exception):
    """Base of every error raised on purpose; its text is one line fit to be printed as it is."""


class InvalidInput(ToppleError):
    """Wrong use or unreadable input: says what is wrong, where, what was expected and what to do."""


class UnknownObject(InvalidInput):
    """A name that is not in the scene.

    Attributes:
        name: The name that was asked for.
        known: The names the scene has, sorted.
    """

    def __init__(self, name: str, known: Iterable[str], role: str = "object") -> None:
        self.name = name
        self.known = tuple(sorted(known))
        self._role = role
        super().__init__(f"unknown {role} {name!r}: the scene has {', '.join(self.known) or 'no objects'}")

    def __reduce__(self) -> tuple[object, ...]:
        """Pickle by its parts, so that it can come back from another process."""
        return (UnknownObject, (self.name, self.known, self._role))
