"""The point cloud library's PCD files: ascii, binary and binary_compressed.

Format: https://pointclouds.org/documentation/tutorials/pcd_file_format.html, version 0.7.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from topple.topology.base.arrays import FloatArray, whole_numbers
from topple.topology.base.errors import InvalidInput
from topple.topology.io.limits import check_size, read_bytes
from topple.topology.io.tolerances import VALUE_BYTES

_TYPES = {kind + size: f"<{kind.lower()}{size}" for kind in "IU" for size in "1248"} | {
    "F4": "<f4",
    "F8": "<f8",
}

LABELS = ("label", "object_id", "object", "instance")


@dataclass(frozen=True)
class _Header:
    record: np.dtype[Any]
    points: int
    storage: str
    organised: bool
    viewpoint: FloatArray


def read_pcd(path: Path, what: str) -> FloatArray:
    """Read the points of a PCD file.

    Args:
        path: The file.
        what: What it is, for the message.

    Returns:
        Points (N, 3), in the units and the frame of the file; NaN where the sensor saw nothing.

    Raises:
        InvalidInput: If the file is broken or has no x, y, z.
        OSError: If the file cannot be read.
    """
    return _points_of(_read(path, what)[1])


def is_pcd(path: Path) -> bool:
    """Tell a PCD file by how it begins: its version, which comments may precede."""
    with path.open("rb") as file:
        start = file.read(16)
    return start.startswith((b"# .PCD", b"VERSION"))


def read_labelled_pcd(path: Path) -> dict[str, np.ndarray]:
    """Read a PCD file that is a scene: a cloud with a label per point.

    Args:
        path: The file, with a field `label`, `object_id`, `object` or `instance` beside x, y, z.

    Returns:
        The arrays `points` (N, 3), `labels` (N,), and `viewpoints` (1, 3), the place in the header's
        VIEWPOINT; absent where the cloud is not organised and that is the origin, as it is by default.

    Raises:
        InvalidInput: If the file is broken, or its points have no label or several.
        OSError: If the file cannot be read.
    """
    header, records = _read(path, "the file")
    labels = [name for name in header.record.names or () if name in LABELS]
    if len(labels) != 1:
        found = " and ".join(labels) or "no label"
        raise InvalidInput(
            f"the PCD file has {found} with its points: expected one field {', '.join(LABELS)} for a whole "
            "scene; or put one file per object into a folder"
        )
    values = records[labels[0]].reshape(len(records))
    values = whole_numbers(values)
    arrays = {"points": _points_of(records), "labels": values}
    if header.organised or header.viewpoint.any():
        arrays["viewpoints"] = header.viewpoint[None]
    return arrays


def _read(path: Path, what: str) -> tuple[_Header, np.ndarray]:
    content = read_bytes(path, what)
    try:
        header, start = _read_header(content)
        return header, _read_records(content[start:], header)
    except (ValueError, KeyError, IndexError, TypeError) as error:
        reason = " ".join(str(error).split())[:120]
        raise InvalidInput(f"{what} is no readable PCD file: {reason}") from error


def _points_of(records: np.ndarray) -> FloatArray:
    with np.errstate(invalid="ignore"):  # a signalling NaN is a NaN like any other
        return np.stack([records[axis].astype(np.float64).reshape(len(records)) for axis in "xyz"], axis=1)


def _read_header(content: bytes) -> tuple[_Header, int]:
    entries: dict[str, list[str]] = {}
    position = 0
    while "DATA" not in entries:
        end = content.find(b"\n", position)
        if end < 0 or end - position > 10_000:
            raise ValueError("its header has no DATA line")
        words = content[position:end].decode("ascii", "replace").split("#", 1)[0].split()
        position = end + 1
        if words:
            entries[words[0].upper()] = words[1:]
    for needed in ("FIELDS", "SIZE", "TYPE"):
        if needed not in entries:
            raise ValueError(f"its header has no {needed} line")
    fields = entries["FIELDS"]
    counts = [int(count) for count in entries.get("COUNT", ["1"] * len(fields))]
    kinds = [kind.upper() + size for kind, size in zip(entries["TYPE"], entries["SIZE"], strict=True)]
    if not {"x", "y", "z"} <= set(fields):
        raise ValueError(f"its fields are {' '.join(fields)}, expected x y z among them")
    # Padding fields may all be called "_": only what is read needs its own name.
    kept = ("x", "y", "z", *LABELS)
    names = [field if field in kept else f"{field}#{place}" for place, field in enumerate(fields)]
    if not len(fields) == len(kinds) == len(counts):
        raise ValueError(f"it has {len(fields)} fields, {len(kinds)} types and {len(counts)} counts")
    layout = [(name, _TYPES[kind], (count,)) for name, kind, count in zip(names, kinds, counts, strict=True)]
    points = (
        int(entries["POINTS"][0])
        if "POINTS" in entries
        else int(entries["WIDTH"][0]) * int(entries["HEIGHT"][0])
    )
    if points < 0 or min(counts, default=1) < 1:
        raise ValueError(f"it declares {points} points of {' '.join(map(str, counts))} numbers a field")
    check_size(points * np.dtype(layout).itemsize, "the PCD file")
    organised = int(entries.get("HEIGHT", ["1"])[0]) > 1
    viewpoint = np.array([float(value) for value in entries.get("VIEWPOINT", ["0"] * 3)[:3]])
    return _Header(np.dtype(layout), points, entries["DATA"][0].lower(), organised, viewpoint), position


def _read_records(body: bytes, header: _Header) -> np.ndarray:
    for name in header.record.names or ():
        if name in ("x", "y", "z", *LABELS) and header.record[name].shape not in ((), (1,)):
            raise ValueError(f"its {name} has {header.record[name].shape} numbers a point, expected one")
    if header.storage == "ascii":
        return _read_ascii(body, header)
    if header.storage == "binary":
        return np.frombuffer(body, dtype=header.record, count=header.points)
    if header.storage != "binary_compressed":
        raise ValueError(f"its DATA is {header.storage!r}, expected ascii, binary or binary_compressed")
    packed, unpacked = np.frombuffer(body, dtype="<u4", count=2)
    wanted = header.points * header.record.itemsize
    if int(unpacked) != wanted or int(packed) > len(body) - 8:
        raise ValueError(f"it unpacks to {int(unpacked)} bytes, expected {wanted} of {header.points} points")
    flat = _decompress(body[8 : 8 + int(packed)], int(unpacked))
    records = np.empty(header.points, dtype=header.record)
    position = 0
    for name in header.record.names or ():  # stored field after field, not point after point
        column = records[name]
        values = np.frombuffer(flat, dtype=column.dtype, count=column.size, offset=position)
        records[name] = values.reshape(column.shape)
        position += column.nbytes
    return records


def _read_ascii(body: bytes, header: _Header) -> np.ndarray:
    names = header.record.names or ()
    width = sum(int(np.prod(header.record[name].shape)) for name in names)
    count = header.points * width
    check_size(VALUE_BYTES * count, "the PCD file")
    values = np.array(body.split(None, count), dtype=np.float64)  # what is more than declared stays whole
    if values.size != count:
        raise ValueError(f"it has {values.size} numbers, expected {header.points} points of {width}")
    table = values.reshape(header.points, width)
    records = np.empty(header.points, dtype=header.record)
    column = 0
    for name in names:
        size = int(np.prod(header.record[name].shape))
        if name in "xyz" or name in LABELS:
            given = table[:, column : column + size].reshape(records[name].shape)
            with np.errstate(over="ignore", invalid="ignore"):  # told below, or infinite and refused
                records[name] = given
            if records[name].dtype.kind in "iu" and not (records[name] == given).all():
                raise ValueError(f"its {name} has numbers that are no {records[name].dtype}")
        column += size
    return records


def _decompress(packed: bytes, size: int) -> bytes:
    """Undo LZF: runs of literals, and references to what was written up to 8 KiB before."""
    out = bytearray()
    position = 0
    while position < len(packed) and len(out) <= size:
        control = packed[position]
        position += 1
        if control < 32:
            out += packed[position : position + control + 1]
            position += control + 1
            continue
        length = control >> 5
        if length == 7:
            length += packed[position]
            position += 1
        start = len(out) - ((control & 31) << 8) - packed[position] - 1
        position += 1
        if start < 0:
            raise ValueError("its compressed data refers to before its beginning")
        length += 2
        run = out[start : start + length]
        out += run if len(run) == length else (run * (length // len(run) + 1))[:length]  # overlapping itself
    if len(out) != size:
        raise ValueError(f"its compressed data unpack to {len(out)} bytes, expected {size}")
    return bytes(out)
