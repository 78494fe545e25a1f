"""The errors topple raises: one base, told apart by what the caller can do about them."""

import re
from collections.abc import Iterable
from importlib.metadata import requires

DISTRIBUTION = "topple-planner"
"""The name topple is installed by; `topple` alone is another project's on PyPI."""


def packages_of(extra: str) -> list[str]:
    """List the packages of an extra, as pip takes them: topple itself is on no package index."""
    needed = requires(DISTRIBUTION) or ()
    return [
        each.partition(";")[0].strip() for each in needed if re.search(rf"extra == ['\"]{extra}['\"]", each)
    ]


def suggestion(name: str, known: Iterable[str]) -> str:
    """Ask whether a known name was meant, as "did you mean 'plate'? "; empty where none is like it."""
    from difflib import get_close_matches

    by_letters = {each.lower(): each for each in known}
    close = get_close_matches(name.lower(), by_letters, n=1)
    return f"did you mean {by_letters[close[0]]!r}? " if close else ""


class ToppleError(Exception):
    """Base of every error raised on purpose; its text is one line fit to be printed as it is.

    Examples:
        >>> issubclass(InvalidInput, ToppleError)
        True
    """

    def __init__(self, message: str = "", *more: object) -> None:
        super().__init__(" ".join(message.splitlines()), *more)


class InvalidInput(ToppleError):
    """Wrong use or unreadable input: says what is wrong, where, what was expected and what to do.

    Examples:
        >>> Hull.of([])
        Traceback (most recent call last):
            ...
        topple.topology.base.errors.InvalidInput: a hull needs finite points (N, 3), N >= 1, got an array (0,)
    """


class NotInstalled(InvalidInput):
    """A part of topple needs a package that is not installed.

    Attributes:
        what: What needs it, as "films need PyAV".
        extra: The extra of topple that brings it.

    Examples:
        >>> print(NotInstalled("live pages need viser", "view"))
        live pages need viser: pip install 'viser>=1.0'
    """

    def __init__(self, what: str, extra: str) -> None:
        self.what, self.extra = what, extra
        super().__init__(f"{what}: pip install {' '.join(map(repr, packages_of(extra)))}")

    def __reduce__(self) -> tuple[object, ...]:
        """Pickle by its parts, so that it can come back from another process."""
        return (NotInstalled, (self.what, self.extra))


class UnknownObject(InvalidInput):
    """A name that is not in the scene.

    Attributes:
        name: The name that was asked for.
        known: The names the scene has, sorted.

    Examples:
        >>> print(UnknownObject("cap", ["cup", "book"]))
        unknown object 'cap': did you mean 'cup'? the scene has book, cup
    """

    def __init__(self, name: str, known: Iterable[str], role: str = "object") -> None:
        self.name = name
        self.known = tuple(sorted(known))
        self._role = role
        has = f"the scene has {', '.join(self.known) or 'no objects'}"
        super().__init__(f"unknown {role} {name!r}: {suggestion(name, self.known)}{has}")

    def __reduce__(self) -> tuple[object, ...]:
        """Pickle by its parts, so that it can come back from another process."""
        return (UnknownObject, (self.name, self.known, self._role))
