"""Clouds as text, told from other numbers in text: matrices, trajectories, planes."""

import re
from pathlib import Path

import numpy as np

from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput
from topple.topology.base.tolerances import FEWEST_SEEN
from topple.topology.io.limits import check_size, open_file, read_text
from topple.topology.io.tolerances import EARLIEST, LINE_BYTES, LOOKED_AT, UNIT_ROW

TEXTS = (".xyz", ".txt", ".csv", ".pts", ".asc")
NOTES = "notes"

_COMMENT = re.compile("#|//")
_DECIMAL = re.compile(r"[-+]?\d+(,\d+(e[-+]?\d+)?)?", re.IGNORECASE)
_BROKEN = re.compile(r"[-+]?\d*\.\d[-+.\de]*", re.IGNORECASE)  # whole ones, too
_NAMED = re.compile(r"(?:p|pos|position|points?|coords?)?[\W_]*([xyz012])(?:[\W_]*coords?)?")
_UNIT = re.compile(r"\[.*?\]|\(.*?\)|[\"']")
_PLAIN = str.maketrans(",;", "  ")


def read_points(path: Path, what: str) -> FloatArray:
    """Read a cloud: a point a row, its numbers apart by blanks, commas or semicolons.

    x, y and z are the first three columns, or those that a heading calls so; a heading of one whole number
    says how many points there are. # and // begin comments. Decimals may have commas in place of points.

    Args:
        path: The file.
        what: What it is, for the message.

    Returns:
        Points (N, 3) as they are stored.

    Raises:
        InvalidInput: If a line is no point, or there are other than as many as are declared.
        OSError: If the file cannot be read.
    """
    text = read_text(path, what)
    check_size(LINE_BYTES * text.count("\n"), what)
    lines = text.splitlines()
    first, columns, declared = _head(lines)
    if first == len(lines):
        first = 0  # without any row its first line is told, unless there is nothing at all
    rows = [_plain(line) for line in lines[first:]]
    count = sum(map(bool, rows))
    try:
        points = np.loadtxt(rows, np.float64, usecols=columns, ndmin=2) if count else np.empty((0, 3))
    except ValueError:  # the line is looked for, and what Python alone reads is read
        points = np.array([_point(*row, columns, what) for row in enumerate(rows, start=first + 1) if row[1]])
    if declared not in (None, count):
        raise InvalidInput(f"{what} declares {declared} points and has {count}: write it again")
    return points


def no_cloud(path: Path) -> str | None:
    """Tell what a text holds that is no cloud.

    Args:
        path: The file.

    Returns:
        `NOTES` where most lines are no rows of numbers; "a 4 x 4 matrix", "a trajectory" or the like; None
        where it is a cloud, or what shall be refused as one.
    """
    with open_file(path, path.name) as file:
        start = file.read(LOOKED_AT)
    lines = start.decode("utf-8-sig", "replace").splitlines()
    lines = lines[:-1] if len(start) == LOOKED_AT else lines  # which is cut short
    rows = [row for line in lines[_head(lines)[0] :] if (row := _plain(line).split())]
    if sum(map(_is_row, rows)) * 2 <= len(rows):
        return NOTES
    try:
        table = np.array(rows, dtype=np.float64)
    except ValueError:  # ragged, or with words in it
        return None
    height, width = table.shape
    last, named = np.eye(width)[-1], path.suffix.lower() == ".xyz"  # where three points are a cloud
    if (height, width) in ((3, 3), (3, 4), (4, 4)) and (not named or (table[-1] == last).all()):
        return f"a {height} x {width} matrix"
    if (width == 4 and height % 4 == 0 and (table[3::4] == last).all()) or _are_poses(table):
        return "a trajectory" if height > 1 else "a pose"
    return f"{height} x {width} numbers" if height < FEWEST_SEEN and not named else None


def _are_poses(table: FloatArray) -> bool:
    """Whether rows are matrices of poses, or a place and a quaternion after a time, perhaps, or begin so."""
    if table.shape[1] in (12, 16):
        turns = table.reshape(len(table), -1, 4)[:, :3, :3]
        return bool(np.abs(turns @ turns.transpose(0, 2, 1) - np.eye(3)).max() < UNIT_ROW)
    if table.shape[1] == 7:  # of a normal and its curvature, which is 0 where it is flat, the first three are
        return _are_units(table[:, 3:]) and not _are_units(table[:, 3:6])
    later = len(table) > 1 and bool((np.diff(table[:, 0]) > 0).all())
    return later and (table[0, 0] > EARLIEST or (table.shape[1] > 7 and _are_units(table[:, 4:8])))


def _are_units(rows: FloatArray) -> bool:
    return bool(np.abs(np.linalg.norm(rows, axis=1) - 1.0).max() < UNIT_ROW)


def _head(lines: list[str]) -> tuple[int, tuple[int, ...], int | None]:
    """Where the rows begin, the columns of x, y and z, and how many points are declared, if it is said."""
    heading, declared = list[str](), None
    for first, line in enumerate(lines):
        words = _plain(line).split()
        if len(words) == 1 and words[0].isdecimal():
            declared = int(words[0])
        elif (
            not _is_meant_as_row(words) or line.lstrip()[0] in ",;" or words == [*map(str, range(len(words)))]
        ):
            heading.append(line)  # the last two are numbers of columns
        else:
            named = (found for above in reversed(heading) if (found := _columns(above, len(words))))
            return first, next(named, (0, 1, 2)), declared
    return len(lines), (0, 1, 2), declared


def _columns(heading: str, count: int) -> tuple[int, ...]:
    """Which of as many columns a heading calls x, y and z; none where it does not."""
    said = _UNIT.sub("", heading).strip("#/ ").lower()
    mark = next((mark for mark in ",;\t" if mark in said), None)
    names = [found[1] if (found := _NAMED.fullmatch(name.strip())) else "" for name in said.split(mark)]
    axes = "xyz" if "x" in names else "012"
    return tuple(map(names.index, axes)) if len(names) == count and set(axes) <= set(names) else ()


def _plain(line: str) -> str:
    """A line without its comment, its words apart by blanks, its decimals with points."""
    line = _COMMENT.split(line, maxsplit=1)[0].strip()
    if "," in line and "." not in line:
        apart = line.replace(";", " ").split()
        if len(apart) > 1 and all(map(_DECIMAL.fullmatch, apart)):
            line = line.replace(",", ".")
    return line.translate(_PLAIN).strip()


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def _is_row(words: list[str]) -> bool:
    return len(words) > 2 and all(map(_is_number, words[:3]))


def _is_meant_as_row(words: list[str]) -> bool:
    """Whether words are a row, a broken one too: two numbers of three, or digits in all of them."""
    if sum(map(_is_number, words[:3])) > 1 and len(words) > 2:
        return True
    numbers = any(_is_number(word) or _BROKEN.fullmatch(word) for word in words)
    return numbers and all(_is_number(word) or re.search(r"\d", word) for word in words)


def _point(number: int, row: str, columns: tuple[int, ...], what: str) -> list[float]:
    words = row.split()
    try:
        return [float(words[column]) for column in columns]
    except (ValueError, IndexError) as error:
        raise InvalidInput(f"{what} reads {row[:40]!r} in line {number}: expected x y z") from error
