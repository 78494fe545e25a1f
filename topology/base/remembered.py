"""What was worked out of arrays, kept for whoever asks again: most of a scene is where it was a look ago."""

import hashlib
from collections import OrderedDict
from collections.abc import Callable, Hashable
from contextlib import suppress
from functools import wraps
from typing import Any, ParamSpec, TypeVar
from weakref import ref

import numpy as np

_Given = ParamSpec("_Given")
_Made = TypeVar("_Made")
_MISSING: Any = object()
_DIGESTS: dict[int, tuple["ref[Any]", Hashable]] = {}
"""What stands for read-only arrays, while there are any, by their places in memory."""


def remember(most: int) -> Callable[[Callable[_Given, _Made]], Callable[_Given, _Made]]:
    """Keep the answers of a function that has no side effects.

    Arrays count by what is in them, so that a copy or the same cloud in another scene finds the answer. What
    is answered is shared: nobody may write to it.

    Args:
        most: How many answers are kept; what was not asked for the longest goes first.

    Returns:
        What makes such a function of one that takes arrays and what can be hashed.
    """

    def wrap(work: Callable[_Given, _Made]) -> Callable[_Given, _Made]:
        kept: OrderedDict[tuple[Hashable, ...], Any] = OrderedDict()

        @wraps(work)
        def answer(*given: _Given.args, **named: _Given.kwargs) -> _Made:
            by_name = ((name, _standing_for(value)) for name, value in sorted(named.items()))
            key = (*map(_standing_for, given), *by_name)
            made = kept.get(key, _MISSING)
            if made is _MISSING:
                made = kept[key] = work(*given, **named)
                if len(kept) > most:
                    kept.popitem(last=False)
            else:
                with suppress(KeyError):  # another thread dropped it
                    kept.move_to_end(key)
            return made

        return answer

    return wrap


def _standing_for(value: Any) -> Hashable:
    """Make a key of an argument: of an array, its shape and a digest of its numbers."""
    if not isinstance(value, np.ndarray):
        return value
    known = _DIGESTS.get(id(value))
    if known is not None and known[0]() is value:
        return known[1]
    told = value.shape, value.dtype.char, hashlib.sha256(np.ascontiguousarray(value).data).digest()
    if not value.flags.writeable and value.base is None:  # nobody can change it under us
        key = id(value)
        _DIGESTS[key] = ref(value, lambda _: _DIGESTS.pop(key, None)), told
    return told
