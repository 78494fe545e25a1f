"""What frozen types are made of: read-only mappings that travel, equality by value, and columns of print."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import fields
from enum import Enum
from typing import Any, NoReturn, TypeVar

import numpy as np

_Key = TypeVar("_Key")
_Value = TypeVar("_Value")


class Word(str, Enum):
    """Base of enumerations that are words: equal to their text, printed and written as it."""

    def __str__(self) -> str:
        return str(self.value)


class FrozenDict(dict[_Key, _Value]):
    """A dict that nobody can write to; unlike a mappingproxy it pickles, copies and is JSON."""

    def _refuse(self, *_: object, **__: object) -> NoReturn:
        raise TypeError("this mapping is read-only: make a dict of it to change it")

    __setitem__ = __delitem__ = __ior__ = clear = pop = popitem = setdefault = update = _refuse  # type: ignore[assignment]

    def __reduce__(self) -> tuple[object, ...]:
        """Pickle by value."""
        return (FrozenDict, (dict(self),))


def all_but(key: _Key, values: Mapping[_Key, _Value]) -> FrozenDict[_Key, _Value]:
    """A mapping without one of its keys, read-only."""
    return FrozenDict({other: value for other, value in values.items() if other != key})


class ByValue:
    """Equality of frozen dataclasses that hold arrays: equal where all their fields are."""

    def _comparison(self) -> list[Any]:
        """Values to compare: all fields, unless a class says otherwise."""
        return [getattr(self, each.name) for each in fields(self) if each.compare]  # type: ignore

    def __eq__(self, other: object) -> bool:
        """Compare field by field; arrays by shape, type and every value."""
        if type(other) is not type(self):
            return NotImplemented
        return self is other or same(self._comparison(), other._comparison())  # type: ignore[attr-defined]

    def __hash__(self) -> int:
        """Hash what is short of it: equal objects have equal hashes, and most others have not."""
        return hash((type(self).__name__, *(_short(part) for part in self._comparison())))


def _short(value: Any) -> str | int | float:
    """Stand-in for a value in a hash: itself, or its length where it has one."""
    if isinstance(value, (str, int, float)):
        return value
    return len(value) if isinstance(value, (tuple, Mapping)) else 0


def same(a: Any, b: Any) -> bool:
    """Whether two values are equal: arrays in every number, mappings and sequences entry by entry."""
    if isinstance(a, np.ndarray) or isinstance(b, np.ndarray):
        return (
            isinstance(a, np.ndarray)
            and isinstance(b, np.ndarray)
            and a.dtype == b.dtype
            and bool(np.array_equal(a, b, equal_nan=a.dtype.kind == "f"))
        )
    if isinstance(a, Mapping) and isinstance(b, Mapping):
        return list(a) == list(b) and all(same(a[key], b[key]) for key in a)
    if isinstance(a, (tuple, list)) and isinstance(b, (tuple, list)):
        return len(a) == len(b) and all(same(x, y) for x, y in zip(a, b, strict=True))
    return bool(a == b)


def in_columns(rows: Sequence[Sequence[str]]) -> list[str]:
    """Rows of texts as lines, each column as wide as its longest text."""
    wide = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return ["  ".join(map(str.ljust, row, wide)).rstrip() for row in rows]


def free_name(name: str, taken: Collection[str]) -> str:
    """A name, or with a number from 2 on behind it where it is taken."""
    free, number = name, 2
    while free in taken:
        free, number = f"{name}_{number}", number + 1
    return free


def decimal(value: float, digits: int = 0) -> str:
    """Write a number with so many digits after the point.

    Args:
        value: The number.
        digits: How many.

    Returns:
        The text; what rounds to zero has no sign, on which side of it the number may lie.
    """
    return f"{round(value, digits) + 0.0:.{digits}f}"
