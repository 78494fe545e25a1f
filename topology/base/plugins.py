"""What there are several of by name: topple's own, and what installed packages add by entry points."""

import logging
from collections.abc import Callable, Generator, Iterator, Mapping
from contextlib import contextmanager
from functools import cached_property, partial
from importlib.metadata import EntryPoint, entry_points
from typing import Any, Generic, TypeVar, cast

from topple.topology.base.errors import InvalidInput, ToppleError, suggestion

log = logging.getLogger(__name__)

Kind = TypeVar("Kind")


def check_kind(found: object, kind: type[Kind]) -> Kind:
    """Refuse the result of another package's function unless it is of the expected kind.

    Raises:
        TypeError: It is something else.
    """
    if not isinstance(found, kind):
        raise TypeError(f"it gave {type(found).__name__}, expected {kind.__name__}")
    return found


class Table(Generic[Kind]):
    """Things of one kind by name, each imported when it is first asked for.

    A package adds one in its pyproject.toml, `[project.entry-points."topple.relations"]`, in the same words
    in which topple names its own. What cannot be imported is named in a warning and left out.

    Attributes:
        group: Of the entry points, such as "topple.relations".
        role: What one of them is, for messages: "rule".
        gives: What a function among them gives.
    """

    def __init__(self, group: str, role: str, own: Mapping[str, str], gives: type = object) -> None:
        """List topple's own.

        Args:
            group: Of the entry points.
            role: What one of them is.
            own: name -> "module:attribute", or "module" where that is the thing itself.
            gives: What a function among them gives.
        """
        self.group, self.role, self.gives = group, role, gives
        self._own = {name: EntryPoint(name, value, group) for name, value in own.items()}

    @cached_property
    def _entries(self) -> dict[str, EntryPoint]:
        """Others' first: those that read files look at them before topple's own, which take any folder."""
        added: dict[str, EntryPoint] = {}
        for entry in entry_points(group=self.group):
            if entry.name in self._own or entry.name in added:
                log.warning("%s is left out: there is one of that name", self._name_of(entry))
            else:
                added[entry.name] = entry
        return {**added, **self._own}

    def __iter__(self) -> Iterator[str]:
        """All names, topple's own first; what they name may turn out broken."""
        return iter((*self._own, *(name for name in self._entries if name not in self._own)))

    def __contains__(self, name: object) -> bool:
        return name in self._entries

    def __getitem__(self, name: str) -> Kind:
        """Load the entry of a name; what another package's function raises names that package.

        Raises:
            InvalidInput: There is nothing of that name, or it cannot be imported.
        """
        if name not in self:
            meant = suggestion(name, self)
            raise InvalidInput(f"there is no {self.role} {name!r}: {meant}expected {', '.join(self)}")
        if name in self._own:
            return self._own[name].load()
        with self.blame(name):
            found = self._entries[name].load()
        return cast(Kind, partial(_call, self, name, found)) if callable(found) else found

    def first(self, fits: Callable[[Kind], bool]) -> tuple[str, Kind] | None:
        """The first that fits, others' before topple's own; a warning names what is broken and is left out.

        Args:
            fits: Whether one of them is what is looked for.

        Returns:
            Its name and what it is; None where none fits.
        """
        for name in tuple(self._entries):
            try:
                with self.blame(name):
                    found = self[name]
                    if fits(found):
                        return name, found
            except InvalidInput as error:
                if name in self._own:
                    raise
                log.warning("%s; it is left out", error)
                del self._entries[name]  # said once
        return None

    @contextmanager
    def blame(self, name: str) -> Generator[None, None, None]:
        """Say in a block whose fault it is when something of another package fails.

        Args:
            name: Which of them is at work.

        Raises:
            InvalidInput: It raised something that is no error of topple's.
        """
        try:
            yield
        except ToppleError:
            raise
        except Exception as error:  # whatever strangers raise
            if name in self._own:
                raise
            what = " ".join(f"{type(error).__name__}: {error}".split())[:200]
            raise InvalidInput(f"{self._name_of(self._entries[name])} failed: {what}") from error

    def _name_of(self, entry: EntryPoint) -> str:
        package = f" of package {entry.dist.name} {entry.dist.version}" if entry.dist else ""
        return f"{self.role} {entry.name!r}{package} ({entry.value})"


def _call(table: Table[Any], name: str, function: Callable[..., Any], *args: Any, **keywords: Any) -> Any:
    with table.blame(name):
        return check_kind(function(*args, **keywords), table.gives)
