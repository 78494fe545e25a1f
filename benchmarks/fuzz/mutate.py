"""Sound files made unsound: bits, bytes, numbers, words and lines that were not meant to be there."""

import io
import re
import struct
from collections.abc import Callable

import numpy as np

MOST = 4
"""Changes that one input has at most: of more nothing is left that a reader gets to."""
IN_PLACE = 0.4
"""Share of the inputs in which one place alone is changed."""
LONGEST = 1 << 16
"""Bytes that an input may come to: what is large is the business of limits, not of this."""

_NUMBER = re.compile(rb"[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?")
_WORD = re.compile(rb"[A-Za-z_][A-Za-z_0-9]*")
_VALUE = re.compile(
    rb"null|true|false|\"[^\"]*\"|\[[^\[\]]*\]|\{[^{}]*\}|[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?"
)
_NUMBERS = (
    b"0", b"1", b"-1", b"2", b"-0", b"nan", b"NaN", b"inf", b"-Infinity", b"1e308", b"1e999", b"-1e300",
    b"1e9", b"1e-320", b"255", b"65536", b"2147483648", b"4294967295", b"-9223372036854775809", b"9" * 30,
    b"0.5", b"1_0", b"0x10", b"", b"1.2.3", b"\xd9\xa3",
)  # fmt: skip
_VALUES = (
    b"null", b"true", b"[]", b"{}", b'""', b'"a"', b"0", b"-1", b"1e999", b"NaN", b"[[1, 2], [3]]", b"[null]",
    b"1e308", b'"a\\u0000b.xyz"', b'"\\ud800.xyz"', b'"../a.xyz"', b'"/dev/zero"', b"[" * 9999 + b"]" * 9999,
)  # fmt: skip
_PAIR = re.compile(rb'"[^"]*"\s*:\s*')
_POSTSCRIPT = b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 9 9\n%%EndComments\nshowpage\n"
_RAW = tuple(
    struct.pack(kind, value)
    for kind, value in (
        ("<f", np.nan), ("<f", np.inf), ("<f", 3e38), ("<d", np.nan), ("<d", -np.inf), ("<d", 1e300),
        ("<d", 1e-320), ("<I", 0), ("<I", 1), ("<I", 0xFFFFFFFF), ("<i", -1), ("<I", 0x7FFFFFFF),
        ("<Q", 1 << 62), ("<H", 0xFFFF), ("<B", 0), ("<B", 255),
    )
)  # fmt: skip
_INSERTED = (
    b"\n", b"\r\n", b"\0", b" ", b'"', b"#", b"{", b"]", b"<", b"\xff\xfe", b"\xc3", "\u2028".encode(),
)  # fmt: skip


def mutated(data: bytes, rng: np.random.Generator) -> bytes:
    """Change a file in some places.

    Args:
        data: The file's content.
        rng: Says what is changed and where.

    Returns:
        The content after one to `MOST` changes; in some cases one that moves nothing of what follows, as most
        readers refuse at once what is longer or shorter than it says.
    """
    if rng.random() < IN_PLACE:
        return (_flip if rng.random() < 0.5 else _overwrite)(data, rng)
    for _ in range(int(rng.integers(1, MOST + 1))):
        data = _CHANGES[int(rng.integers(len(_CHANGES)))](data, rng)[:LONGEST]
    return data


def _place(data: bytes, rng: np.random.Generator) -> int:
    """A place in a file: in a third of all cases among its first bytes, where it is declared what follows."""
    size = len(data) if rng.random() < 2 / 3 else min(len(data), 200)
    return int(rng.integers(size + 1))


def _span(data: bytes, rng: np.random.Generator) -> tuple[int, int]:
    start = _place(data, rng)
    return start, min(len(data), start + int(2 ** rng.uniform(0, 8)))


def _flip(data: bytes, rng: np.random.Generator) -> bytes:
    if not data:
        return data
    changed = bytearray(data)
    changed[min(_place(data, rng), len(data) - 1)] ^= 1 << int(rng.integers(8))
    return bytes(changed)


def _cut(data: bytes, rng: np.random.Generator) -> bytes:
    start, end = _span(data, rng)
    return data[:start] + data[end:] if rng.random() < 0.7 else data[:start]


def _repeat(data: bytes, rng: np.random.Generator) -> bytes:
    start, end = _span(data, rng)
    return data[:end] + data[start:end] * int(rng.integers(1, 4)) + data[end:]


def _insert(data: bytes, rng: np.random.Generator) -> bytes:
    start = _place(data, rng)
    some = _INSERTED[int(rng.integers(len(_INSERTED)))] if rng.random() < 0.6 else rng.bytes(4)
    return data[:start] + some + data[start:]


def _overwrite(data: bytes, rng: np.random.Generator) -> bytes:
    start = _place(data, rng)
    raw = _RAW[int(rng.integers(len(_RAW)))]
    return data[:start] + raw + data[start + len(raw) :]


def _replace(
    found: "re.Pattern[bytes]", others: tuple[bytes, ...]
) -> Callable[[bytes, np.random.Generator], bytes]:
    """A change that puts one of some words, or another one of the file, in the place of one."""

    def change(data: bytes, rng: np.random.Generator) -> bytes:
        places = list(found.finditer(data))
        if not places:
            return data
        early = rng.random() < 1 / 3  # what is declared stands first
        place = places[int(rng.integers(min(len(places), 8) if early else len(places)))]
        other = places[int(rng.integers(len(places)))].group()
        word = others[int(rng.integers(len(others)))] if others and rng.random() < 0.8 else other
        return data[: place.start()] + word + data[place.end() :]

    return change


def _double(data: bytes, rng: np.random.Generator) -> bytes:
    """Give a key of JSON twice."""
    found = list(_PAIR.finditer(data))
    if not found:
        return _flip(data, rng)
    pair = found[int(rng.integers(len(found)))]
    return data[: pair.start()] + pair.group() + b"0, " + data[pair.start() :]


def _other(data: bytes, rng: np.random.Generator) -> bytes:
    """Put something of another kind in the place of a picture or an array: a program, or text."""
    if not data.startswith(b"\x93NUMPY"):
        return _POSTSCRIPT if data.startswith(b"\x89PNG") else _flip(data, rng)
    buffer = io.BytesIO()
    shape = tuple(int(size) for size in rng.integers(1, 5, int(rng.integers(3))))
    np.save(buffer, np.full(shape, "1" if rng.random() < 0.5 else "mug"))
    return buffer.getvalue()


def _lines(data: bytes, rng: np.random.Generator) -> bytes:
    """Leave out, double or swap lines."""
    lines = data.split(b"\n")
    one, other = (int(rng.integers(len(lines))) for _ in range(2))
    kind = int(rng.integers(3))
    if kind == 0:
        del lines[one]
    elif kind == 1:
        lines.insert(one, lines[other])
    else:
        lines[one], lines[other] = lines[other], lines[one]
    return b"\n".join(lines)


_CHANGES = (
    _flip, _cut, _repeat, _insert, _overwrite, _lines, _double, _other,
    _replace(_NUMBER, _NUMBERS), _replace(_NUMBER, _NUMBERS), _replace(_VALUE, _VALUES), _replace(_WORD, ()),
)  # fmt: skip
