"""Arguments held against the annotations of what they are given to: what is of no such kind is refused."""

import builtins
import inspect
import os
import reprlib
from collections.abc import Callable, Collection, Mapping, Sequence
from functools import wraps
from itertools import repeat
from numbers import Integral, Real
from pathlib import Path
from types import UnionType
from typing import Annotated, Any, Literal, TypeVar, Union, cast, get_args, get_origin

import numpy as np
from numpy.typing import ArrayLike

from topple.topology.base.arrays import FloatArray
from topple.topology.base.checks import numeric
from topple.topology.base.errors import InvalidInput
from topple.topology.base.public_names import with_new_names
from topple.topology.base.values import FrozenDict

_Target = TypeVar("_Target", bound=Callable[..., Any])

_NUMBERS: dict[Any, type] = {int: Integral, float: Real}
_MADE_OF: dict[Any, Any] = {Path: (str, os.PathLike), **dict.fromkeys((list, tuple, Sequence), Collection)}
"""What is made of what: paths of their text, sequences of collections that have an order."""
_ORDERLESS = (set, frozenset, Mapping)
_ANY_ARRAY = set(get_args(ArrayLike)) or {ArrayLike}


def checked_arguments(target: _Target) -> _Target:
    """Have the arguments of a function, or of a class's constructor, held against its annotations.

    Args:
        target: One that users call.

    Returns:
        The same. What it is given arrives as annotated: numbers of numpy as Python's, text as a Path, any
        collection as a sequence; anything else raises InvalidInput, which names the argument. What may be
        any array is left to the function.
    """
    if isinstance(target, type):
        target.__init__ = checked_arguments(target.__init__)
        return cast(_Target, target)
    function: Callable[..., Any] = target
    parameters = inspect.signature(function).parameters.values()
    ordered = [each.name for each in parameters if each.kind < each.VAR_POSITIONAL]
    hints: dict[str, Any] = {}

    @wraps(function)
    def call(*args: Any, **keywords: Any) -> Any:
        if not hints:
            names = _Names(inspect.unwrap(function).__globals__)
            hints.update({each.name: _hint(each.annotation, names) for each in parameters})  # in one go
        taken = [_take(name, value, hints[name]) for name, value in zip(ordered, args, strict=False)]
        if not hints.keys() >= keywords.keys():
            keywords = with_new_names(keywords, hints)
        more = {name: _take(name, value, hints.get(name, Any)) for name, value in keywords.items()}
        return function(*taken, *args[len(ordered) :], **more)

    return cast(_Target, call)


class _Unloaded(type):
    """Stands for a class of topple that a module imports for its annotations alone: the name tells it."""

    def __instancecheck__(cls, value: object) -> bool:
        kinds = type(value).__mro__
        return any(kind.__name__ == cls.__name__ and kind.__module__.startswith("topple.") for kind in kinds)


class _Names(dict[str, Any]):
    """What the annotations of a module name."""

    def __missing__(self, name: str) -> Any:
        return getattr(builtins, name, None) or _Unloaded(name, (), {})


def _hint(given: Any, names: _Names) -> Any:
    """Resolve an annotation, also one given as text; `Any` where there is none."""
    if isinstance(given, str):
        return eval(given, {}, names)
    return Any if given is inspect.Parameter.empty else given


def _bare_kind(hint: Any) -> Any:
    """Strip a kind of its parameters; kinds of numpy 2.5 are names of others."""
    kind = get_origin(hint) or hint
    value = getattr(kind, "__value__", kind)
    return get_origin(value) or value


class _Misfit(Exception):
    """What is of another kind: what it is called, itself, and the kind it should be of."""


def _take(name: str, value: Any, hint: Any) -> Any:
    """An argument as it is annotated.

    Raises:
        InvalidInput: It is of another kind.
    """
    try:
        return _convert(name, value, hint)
    except _Misfit as error:
        what, found, wanted = error.args
        plain = isinstance(found, (str, bool, int, float, type(None)))
        shown = reprlib.repr(found) if plain else f"of {type(found)}"
        raise InvalidInput(f"{what} is {shown}: expected {_said(wanted)}") from None


def _said(hint: Any) -> str:
    """A kind as people write it, and how one is made where that is annotated."""
    kind, args = _bare_kind(hint), get_args(hint)
    if kind is np.ndarray:
        return "array"
    if kind in (Union, UnionType):
        arrays = _ANY_ARRAY if _ANY_ARRAY <= set(args) else set()
        return " | ".join([*["array"][: len(arrays)], *(_said(each) for each in args if each not in arrays)])
    if kind is Annotated:
        return f"{_said(args[0])} ({args[1]})"
    if kind in (type(None), ...):
        return "None" if kind is type(None) else "..."
    if kind is float:
        return "number"
    of = f"[{', '.join(map(_said, args))}]" if args and kind is not Callable else ""
    return getattr(kind, "__name__", str(kind)) + of


def _convert(what: str, value: Any, hint: Any) -> Any:
    """A value as it is annotated; the parts of a collection are as they are.

    Raises:
        InvalidInput: It is no array of numbers where there has to be one.
        _Misfit: It, or a part of it, is of another kind.
    """
    kind, args = _bare_kind(hint), get_args(hint)
    one = isinstance(value, np.generic) or (isinstance(value, np.ndarray) and value.ndim == 0)
    value = value.item() if one else value
    if hint is ArrayLike or (kind in (Union, UnionType) and _ANY_ARRAY <= set(args)):
        return value
    if kind in (Union, UnionType, Annotated):
        return _fitted_to_any(what, value, args[:1] if kind is Annotated else args, hint)
    if kind is np.ndarray:
        as_it_is = hint != FloatArray or getattr(value, "dtype", None) == np.float64
        return value if as_it_is else numeric(value, what)
    if kind in _MADE_OF and not isinstance(value, (kind, *_ORDERLESS)) and isinstance(value, _MADE_OF[kind]):
        value = cast(Any, list if kind is Sequence else kind)(value)
    if not _is(value, kind, args):
        raise _Misfit(what, value, hint)
    if isinstance(value, Mapping) and len(args) == 2:
        # what is in a FrozenDict was looked at when topple made it
        entries = cast(Mapping[Any, Any], {} if isinstance(value, FrozenDict) else value)
        for key, part in entries.items():
            _convert(f"a key of {what}", key, args[0])
            _convert(f"{what}[{key!r}]", part, args[1])
    elif isinstance(value, Collection) and args and kind is not Literal:
        parts = cast(Collection[Any], value)
        fixed = kind is tuple and args[-1] is not ...
        if fixed and len(parts) != len(args):
            raise _Misfit(what, value, hint)
        for number, (part, its) in enumerate(zip(parts, args if fixed else repeat(args[0]), strict=False)):
            _convert(f"{what}[{number}]", part, its)
    return value


def _fitted_to_any(what: str, value: Any, kinds: tuple[Any, ...], hint: Any) -> Any:
    """A value as the first of several kinds that it is of."""
    refused: list[_Misfit | InvalidInput] = []
    for kind in kinds:
        try:
            return _convert(what, value, kind)
        except (_Misfit, InvalidInput) as error:
            refused.append(error)
    told = [error for error in refused if error.args[0] != what]  # what is not of it, or of a part of it
    raise told[0] if told else _Misfit(what, value, hint)


def _is(value: Any, kind: Any, args: tuple[Any, ...]) -> bool:
    """Whether a value is of a kind, whatever its parts are."""
    if kind is None or kind is Any or kind is Literal:
        return value in args if kind is Literal else kind is Any or value is None
    if kind in _NUMBERS:
        return isinstance(value, _NUMBERS[kind]) and not isinstance(value, bool) and value == value
    if getattr(kind, "_is_protocol", False) and not getattr(kind, "_is_runtime_protocol", False):
        return True
    if not isinstance(kind, type):
        return True
    mixed = (isinstance(value, str) and str not in args) or (isinstance(value, Mapping) and len(args) == 1)
    return isinstance(value, kind) and not (args and mixed)  # letters, or names of what is something else
