"""Arrays and dicts of arrays as numpy stores them, read without running anything that a file asks for.

A dict in an .npy file is a pickle, and a pickle is a program: whoever unpickles it runs it. Here its
instructions are taken from `pickletools` and followed as far as dicts, lists, numbers, text and arrays of
numpy need them; nothing in between could call anything else.
"""

import io
import math
import pickletools
from collections.abc import Callable, Mapping
from typing import Any, cast

import numpy as np
from numpy.lib import format as npy

from topple.topology.base.errors import InvalidInput

MOST_BYTES = 1 << 28
"""Of one stored array or dict: four million grasps."""

MOST_STEPS = 1 << 20
"""Instructions that are followed: thirty thousand arrays."""

Key = int | float | str
Stored = np.ndarray[Any, Any] | dict[Key, np.ndarray[Any, Any]]

_NUMBERS = "biuf"
_NAMES = {
    *(f"numpy.{name}" for name in ("ndarray", "dtype")),
    *(f"numpy.{core}.multiarray.{name}" for core in ("core", "_core") for name in ("_reconstruct", "scalar")),
    *(f"numpy.{core}.numeric._frombuffer" for core in ("core", "_core")),
    "_codecs.encode",  # bytes, and none, as pickles have them before protocol 3
    "__builtin__.bytes",
}
_VALUES = (
    "BININT", "BININT1", "BININT2", "LONG1", "BINFLOAT", "SHORT_BINUNICODE", "BINUNICODE", "BINUNICODE8",
    "SHORT_BINBYTES", "BINBYTES", "BINBYTES8", "BYTEARRAY8",
)  # fmt: skip
_CONSTANTS = {"NONE": None, "NEWTRUE": True, "NEWFALSE": False, "EMPTY_TUPLE": ()}
_TUPLES = {"TUPLE1": 1, "TUPLE2": 2, "TUPLE3": 3}


def read_stored(data: bytes, name: str) -> Stored:
    """Read what an .npy file, or a member of an .npz file, holds.

    Args:
        data: The file's content.
        name: For messages.

    Returns:
        An array of numbers, or a dict of them by numbers or text.

    Raises:
        InvalidInput: It is something else, or larger than `MOST_BYTES`.
    """
    if len(data) > MOST_BYTES:
        raise InvalidInput(
            f"{name}: has {len(data) / 1e6:.0f} MB: expected at most {MOST_BYTES / 1e6:.0f} MB"
        )
    file = io.BytesIO(data)
    try:
        header = npy.read_array_header_1_0 if npy.read_magic(file) == (1, 0) else npy.read_array_header_2_0
        shape, fortran, dtype = header(file)
        rest = file.read()
        if dtype.hasobject:
            return _dict_of_arrays(_unpickle(rest))
        return _fill(rest, shape, dtype, fortran)
    except _Refused as error:
        raise InvalidInput(f"{name}: holds a pickle that is no dict of arrays: {error}") from error
    except Exception as error:  # the header is Python text, and what is wrong with it fails in many ways
        reason = " ".join(str(error).split())[:120] or type(error).__name__
        raise InvalidInput(f"{name}: is no stored array: {reason}") from error


class _Refused(Exception):
    """What a pickle asks for that no dict of arrays needs."""


class _Global:
    """A name that a pickle asks for."""

    def __init__(self, name: str) -> None:
        self.name = name


class _Dtype:
    """A dtype in the making: its code, and from its state on its byte order."""

    def __init__(self, code: str) -> None:
        self.code, self.order = code, "="

    def build(self) -> np.dtype[Any]:
        dtype = np.dtype(self.order + self.code if self.order in "<>" else self.code)
        if dtype.kind not in _NUMBERS:
            raise _Refused(f"its arrays are of {dtype}, expected numbers")
        return dtype


class _Array:
    """An array in the making: empty until its state comes."""

    def __init__(self) -> None:
        self.value: Any = None


def _fill(data: bytes, shape: tuple[int, ...], dtype: np.dtype[Any], fortran: bool) -> np.ndarray[Any, Any]:
    if dtype.kind not in _NUMBERS:
        raise ValueError(f"it is of {dtype}, expected numbers")
    if any(extent < 0 for extent in shape) or math.prod(shape) * dtype.itemsize != len(data):
        raise ValueError(f"{len(data)} bytes are no array {shape} of {dtype}")
    return np.frombuffer(data, dtype).reshape(shape, order="F" if fortran else "C")


def _dict_of_arrays(value: Any) -> dict[Key, np.ndarray[Any, Any]]:
    """Take out a dict of arrays by numbers or text; refuse any other value."""
    if isinstance(value, _Array):
        value = value.value
    if isinstance(value, list):  # numpy stores a dict as an array without axes, whose one value it is
        values = cast(list[Any], value)
        value = values[0] if len(values) == 1 else None
    if not isinstance(value, dict):
        raise _Refused("expected {id: array}")
    entries = cast(dict[Key, Any], value)
    arrays: dict[Key, np.ndarray[Any, Any]] = {}
    for key, one in entries.items():
        if not isinstance(one, _Array) or not isinstance(one.value, np.ndarray):
            raise _Refused(f"its entry {str(key)[:40]!r} is no array of numbers")
        arrays[key] = one.value
    if sum(one.nbytes for one in arrays.values()) > MOST_BYTES:
        raise _Refused(f"together its arrays have more than {MOST_BYTES / 1e6:.0f} MB")
    return arrays


def _unpickle(data: bytes) -> Any:
    """Follow a pickle's instructions as far as arrays and dicts need them."""
    machine = _Machine()
    for step, (opcode, argument, _) in enumerate(pickletools.genops(data)):
        if step > MOST_STEPS:
            raise _Refused("it is too long for one")
        if opcode.name == "STOP":
            return machine.pop()
        machine.follow(opcode.name, argument)
    raise _Refused("it ends early")


_MARK = object()


class _Machine:
    """A stack and a memo, as a pickle has them."""

    def __init__(self) -> None:
        self.stack: list[Any] = []
        self.memo: dict[int, Any] = {}

    def pop(self) -> Any:
        if not self.stack:
            raise _Refused("it takes what it did not put")
        return self.stack.pop()

    def to_mark(self) -> list[Any]:
        """Take what was put since the last mark."""
        for place in range(len(self.stack) - 1, -1, -1):
            if self.stack[place] is _MARK:
                taken = self.stack[place + 1 :]
                del self.stack[place:]
                return taken
        raise _Refused("it has no mark")

    def follow(self, name: str, argument: Any) -> None:
        """Do what one instruction says."""
        if name in _VALUES:
            self.stack.append(bytes(argument) if isinstance(argument, bytearray) else argument)
        elif name in _CONSTANTS:
            self.stack.append(_CONSTANTS[name])
        elif name in _TUPLES:
            self.stack.append(tuple(reversed([self.pop() for _ in range(_TUPLES[name])])))
        elif name in ("MEMOIZE", "BINPUT", "LONG_BINPUT"):
            self.memo[len(self.memo) if argument is None else argument] = self.top()
        elif name in ("BINGET", "LONG_BINGET"):
            if argument not in self.memo:
                raise _Refused("it takes what it did not put")
            self.stack.append(self.memo[argument])
        elif name in _STEPS:
            _STEPS[name](self, argument)
        elif name not in ("PROTO", "FRAME"):
            raise _Refused(f"it asks for {name}")

    def top(self) -> Any:
        value = self.pop()
        self.stack.append(value)
        return value

    def push_name(self, module: str, name: str = "") -> None:
        if f"{module}.{name}" not in _NAMES:
            raise _Refused(f"it asks for {module}.{name}"[:80] + ", which is not run")
        self.stack.append(_Global(str(name)))

    def stack_global(self) -> None:
        name, module = self.pop(), self.pop()
        if not isinstance(module, str) or not isinstance(name, str):
            raise _Refused("it asks for what is no name")
        self.push_name(module, name)

    def extend(self, values: list[Any]) -> None:
        target = self.top()
        if not isinstance(target, list):
            raise _Refused("it appends to what is no list")
        cast(list[Any], target).extend(values)

    def set_items(self, values: list[Any]) -> None:
        target = self.top()
        if not isinstance(target, dict) or len(values) % 2:
            raise _Refused("it sets entries of what is no dict")
        for key, value in zip(values[::2], values[1::2], strict=True):
            if isinstance(key, bool) or not isinstance(key, (int, float, str)):
                raise _Refused("a key is neither number nor text")
            target[key] = value

    def reduce(self) -> None:
        """Begin one of numpy's own things; nothing is called."""
        arguments, maker = self.pop(), self.pop()
        if not isinstance(maker, _Global) or not isinstance(arguments, tuple):
            raise _Refused("it calls what is no name")
        given = cast(tuple[Any, ...], arguments)
        if maker.name == "dtype" and given and isinstance(given[0], str):
            self.stack.append(_Dtype(given[0]))
        elif maker.name == "_reconstruct":
            self.stack.append(_Array())
        elif maker.name == "scalar" and len(given) == 2 and isinstance(given[0], _Dtype):
            self.stack.append(_fill(given[1], (), given[0].build(), False).item())
        elif maker.name == "encode" and given[1:] == ("latin1",) and isinstance(given[0], str):
            self.stack.append(given[0].encode("latin1"))
        elif maker.name == "bytes" and not given:
            self.stack.append(b"")
        elif maker.name == "_frombuffer" and len(given) == 4 and isinstance(given[1], _Dtype):
            data, dtype, shape, order = given
            array = _Array()
            array.value = _fill(data, shape, dtype.build(), order == "F")
            self.stack.append(array)
        else:
            raise _Refused(f"it asks for numpy's {maker.name} with what that does not take")

    def build(self) -> None:
        """Give a dtype its byte order, an array its content."""
        state, target = self.pop(), self.top()
        given = cast(tuple[Any, ...], state) if isinstance(state, tuple) else ()
        if isinstance(target, _Dtype) and len(given) > 2 and given[1] in ("<", ">", "|", "="):
            target.order = given[1]
        elif isinstance(target, _Array) and len(given) == 5 and isinstance(given[2], _Dtype):
            _, shape, dtype, fortran, content = given
            if dtype.code.startswith("O") and isinstance(content, list):
                target.value = content
            else:
                target.value = _fill(content, shape, dtype.build(), bool(fortran))
        else:
            raise _Refused("it changes what is no array")


_STEPS: Mapping[str, Callable[[_Machine, Any], None]] = {
    "MARK": lambda machine, _: machine.stack.append(_MARK),
    "EMPTY_DICT": lambda machine, _: machine.stack.append({}),
    "EMPTY_LIST": lambda machine, _: machine.stack.append([]),
    "TUPLE": lambda machine, _: machine.stack.append(tuple(machine.to_mark())),
    "APPEND": lambda machine, _: machine.extend([machine.pop()]),
    "APPENDS": lambda machine, _: machine.extend(machine.to_mark()),
    "SETITEM": lambda machine, _: machine.set_items([machine.pop(), machine.pop()][::-1]),
    "SETITEMS": lambda machine, _: machine.set_items(machine.to_mark()),
    "GLOBAL": lambda machine, argument: machine.push_name(*str(argument).split(" ", 1)),
    "STACK_GLOBAL": lambda machine, _: machine.stack_global(),
    "REDUCE": lambda machine, _: machine.reduce(),
    "BUILD": lambda machine, _: machine.build(),
}
