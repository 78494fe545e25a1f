"""Arrays of an `.npz` or `.npy` file, never a pickle."""

import math
import os
import sys
import zipfile
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import IO, Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from topple.topology.base.errors import InvalidInput
from topple.topology.io.limits import check_size, open_file

Array = NDArray[Any]

MASK_KEYS = ("label", "segmap", "seg")
STACK_KEY = "masks"

_MEMBER = ".npy"
_ZIP = b"PK"
_NPY = b"\x93NUMPY"
_KNOWN = {
    b"ply": "a PLY file: put it into a folder, one file per object",
    b"glTF": "a GLB file: put it into a folder, one file per object",
    b"\x89PNG": "a PNG picture",
    b"\xff\xd8\xff": "a JPEG picture",
    b"%PDF": "a PDF",
    b"\x89HDF": "an HDF5 file",
    b"\x1f\x8b": "a gzip file: unpack it first",
    b"\x80": "a Python pickle, which is never loaded: save plain arrays with numpy.savez",
}
_EXPECTED = (
    "an .npz of clouds, an RGB-D .npz or .npy, a labelled .pcd, a recording of ROS (.mcap, .db3, .bag), or a "
    "folder"
)


def read_arrays(path: Path, plain: str = "") -> dict[str, Array]:
    """Read the named arrays of a file, whatever its name ends in.

    Args:
        path: An `.npz`, or an `.npy` that holds one record with named fields.
        plain: What an array without fields is called, where an `.npy` may hold one.

    Returns:
        The arrays by name.

    Raises:
        InvalidInput: If the file is neither, is broken, holds a pickle, or names an array twice.
        OSError: If the file cannot be read.
    """
    with open_file(path, "the file") as file:
        start = file.read(16)
        file.seek(0)
        if start.startswith(_ZIP):
            return _read_npz(file)
        if start.startswith(_NPY):
            return _read_npy(file, plain)
    if not start:
        raise InvalidInput(f"the file is empty: expected {_EXPECTED}")
    what = next((text for magic, text in _KNOWN.items() if start.startswith(magic)), "of no known format")
    raise InvalidInput(f"the file is {what}; expected {_EXPECTED}")


def is_rgbd(arrays: Mapping[str, Array]) -> bool:
    """Tell an RGB-D frame from clouds: it has an image of depth, or two of depth, K and a mask.

    Args:
        arrays: The file's arrays.

    Returns:
        True for an RGB-D frame, complete or not.
    """
    if is_labelled(arrays):
        return False
    if "depth" in arrays and not (arrays["depth"].ndim == 2 and arrays["depth"].shape[1] == 3):
        return True
    masked = any(key in arrays for key in (*MASK_KEYS, STACK_KEY))
    return sum(("depth" in arrays, "K" in arrays, masked)) >= 2


def is_labelled(arrays: Mapping[str, Array]) -> bool:
    """Tell one cloud with a label per point from a cloud per object: `points` (N, 3) and `labels` (N,).

    Args:
        arrays: The file's arrays.

    Returns:
        True where both are there and `labels` is no cloud of an object so named.
    """
    return "points" in arrays and "labels" in arrays and arrays["labels"].ndim != 2


def _read_npz(file: BinaryIO) -> dict[str, Array]:
    try:
        with zipfile.ZipFile(file) as archive:
            members = [name for name in archive.namelist() if not name.endswith("/")]
            foreign = [name for name in members if not name.endswith(_MEMBER)]
            if foreign:
                raise InvalidInput(
                    f"the file is a zip with {foreign[0]!r} in it, no .npz: expected arrays only"
                )
            twice = [name for name, count in Counter(members).items() if count > 1]
            if twice:
                name = twice[0].removesuffix(_MEMBER)
                raise InvalidInput(
                    f"the name {name!r} occurs twice: expected one array per name, so rename one"
                )
            check_size(sum(archive.getinfo(name).file_size for name in members), "the file")
            arrays: dict[str, Array] = {}
            held = 0
            for name in members:
                arrays[name.removesuffix(_MEMBER)] = array = _read_member(archive, name, held)
                held += _bytes_of(array.shape, array.dtype)
            return arrays
    except (OSError, InvalidInput):
        raise
    except Exception as error:  # zipfile fails on altered bytes in many ways
        raise InvalidInput(f"the file is a broken .npz ({_reason(error)}): write it again") from error


def _read_member(archive: zipfile.ZipFile, member: str, held: int) -> Array:
    what = f"array {member.removesuffix(_MEMBER)!r}"
    try:
        with archive.open(member) as file:
            _check_header(file, archive.getinfo(member).file_size, what, held)
        with archive.open(member) as file:
            array = np.lib.format.read_array(file, allow_pickle=False)
        if array.dtype.kind == "U" and array.nbytes:
            letters = np.ascontiguousarray(array).ravel().view(array.dtype.str[0] + "u4")
            if letters.max() > sys.maxunicode:
                raise InvalidInput(f"{what} of {array.dtype} holds what is no text: write it again")
        return array
    except InvalidInput:
        raise
    except Exception as error:  # zipfile, its codecs and numpy fail on altered bytes in many ways
        raise InvalidInput(_refusal(error, what)) from error


def _bytes_of(shape: tuple[int, ...], kind: "np.dtype[Any]") -> int:
    """Bytes that an array takes; one of points (N, 3) is held with eight for each number."""
    points = len(shape) == 2 and shape[1] == 3 and kind.kind in "iuf"
    return math.prod(shape) * (max(kind.itemsize, 8) if points else kind.itemsize)


def _check_header(file: IO[bytes], size: int, what: str, held: int = 0) -> None:
    """Refuse an array that declares more than there is of it, or too much beside what is held already."""
    version = np.lib.format.read_magic(file)
    read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    shape, _, kind = read(file)
    declared = math.prod(shape) * kind.itemsize
    check_size(held + _bytes_of(shape, kind), what)
    if declared > size and not kind.hasobject:
        raise InvalidInput(f"{what} is broken (it declares {declared} bytes and has {size}): write it again")


def _read_npy(file: BinaryIO, plain: str) -> dict[str, Array]:
    try:
        _check_header(file, os.fstat(file.fileno()).st_size, "the .npy file")
        file.seek(0)
        array = np.load(file, allow_pickle=False)
    except (OSError, InvalidInput):
        raise
    except Exception as error:  # numpy fails on altered bytes in many ways
        raise InvalidInput(_refusal(error, "the .npy file")) from error
    if array.dtype.names is None and plain:
        return {plain: array}
    if array.dtype.names is None:
        raise InvalidInput(
            f"the .npy file holds one array {array.shape}: expected a record with the fields depth, K and "
            "label; for clouds, numpy.savez(file, name=points, ...)"
        )
    if array.size != 1:
        raise InvalidInput(f"the .npy file holds {array.size} records: expected one RGB-D frame")
    record = array.reshape(())
    return {name: np.asarray(record[name]) for name in array.dtype.names}


def _refusal(error: Exception, what: str) -> str:
    if "pickle" in str(error).lower() or "object array" in str(error).lower():
        return (
            f"{what} holds a Python pickle, which is never loaded because it can run any code: "
            "save plain arrays of numbers, numpy.savez(file, name=points, ...)"
        )
    return f"{what} is broken ({_reason(error)}): write the file again"


def _reason(error: Exception) -> str:
    return " ".join(str(error).split())[:120] or type(error).__name__
