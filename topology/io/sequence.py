"""A tracked scene: one Scene per frame."""

import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from topple.topology.base.arguments import checked_arguments
from topple.topology.base.arrays import FloatArray
from topple.topology.base.checks import Names, as_names
from topple.topology.base.errors import InvalidInput
from topple.topology.base.public_names import with_new_names
from topple.topology.io.archive import Array, read_arrays
from topple.topology.io.assemble import Parts, assemble
from topple.topology.io.bag import frames, reads
from topple.topology.io.clouds import amounts_in
from topple.topology.io.limits import allow, check_place
from topple.topology.io.load import load_scene
from topple.topology.io.tolerances import FAR_OUT, TABLE_STEP, UNIT
from topple.topology.scene.scene import Scene

_POINTS, _ROWS = "_xyz_01mm", "_offsets"


@checked_arguments
def load_sequence(
    path: str | os.PathLike[str], *, fixed: Names = (), up: ArrayLike | None = None, **options: Any
) -> Iterator[Scene]:
    """Read the frames of a tracked scene, one after the other.

    Three kinds are read: a recording of ROS (`topple.topology.io.bag`, extra `ros`); a folder of scenes that
    `load_scene` reads, taken in the order of their names; and an `.npz` with all frames of an object in one
    array, `NAME_xyz_01mm` (N, 3) in tenths of a millimetre, whose rows `NAME_offsets[i]` to
    `NAME_offsets[i + 1]` are frame i; optional `table_plane`, `up`, `fixed`, `masses`, `friction` and
    `viewpoints` (the camera's frame, with its centre in the origin, where not given).

    Args:
        path: File or folder.
        fixed: Names of objects that never move, beside those the files name.
        up: Direction (3,) against gravity.
        **options: Of a recording, the topics: `depth`, `info`, `masks`; of a folder those of `load_scene`.

    Yields:
        A scene per frame. An object no point of which was seen in a frame is absent from it; clouds that do
        not change, as that of a table laid into `table_plane`, are the same object in all frames.

    Raises:
        InvalidInput: If the path holds no sequence; one line that names the file.

    Examples:
        >>> cloud = (1e4 * scene.clouds["cup"]).astype(np.int16)  # steps of 0.1 mm
        >>> np.savez("frames.npz", cup_xyz_01mm=cloud, cup_offsets=[0, 1000, 2000])
        >>> [len(frame.clouds["cup"]) for frame in load_sequence("frames.npz")]
        [1000, 1000]
    """
    place, fixed = Path(path), as_names(fixed)
    if (place.is_dir() or place.is_file()) and reads(place):
        try:
            options = with_new_names(options, ("masks",))
            yield from (assemble(parts, fixed, up) for parts in frames(place, **options))
        except InvalidInput as error:
            raise InvalidInput(f"{os.fspath(path)}: {error}") from error
        return
    if place.is_dir():
        files = sorted(file for file in place.iterdir() if not file.name.startswith("."))
        if not files:
            raise InvalidInput(f"{os.fspath(path)}: the folder is empty: expected one scene per frame")
        with allow(None, None if options.get("allow_outside") else place):
            for file in files:
                check_place(file, os.fspath(file))
        yield from (load_scene(file, fixed=fixed, up=up, **options) for file in files)
        return
    try:
        arrays = read_arrays(place)
        tracks = _tracks(arrays)
        whole = _with_table(arrays, tracks, fixed, up)
    except OSError as error:
        raise InvalidInput(f"{os.fspath(path)}: cannot be read: {error.strerror or error}") from error
    except InvalidInput as error:
        raise InvalidInput(f"{os.fspath(path)}: {error}") from error
    for frame in range(min(len(rows) for _, rows in tracks.values()) - 1):
        scene = whole
        for name, (points, rows) in tracks.items():
            cloud = points[rows[frame] : rows[frame + 1]] * UNIT
            scene = scene.with_cloud(name, cloud) if len(cloud) else scene.without(name)
        yield scene


def _tracks(arrays: Mapping[str, Array]) -> dict[str, tuple[Array, Array]]:
    """The rows and where the frames begin, by object."""
    tracks: dict[str, tuple[Array, Array]] = {}
    for key, points in arrays.items():
        if not key.endswith(_POINTS):
            continue
        name = key.removesuffix(_POINTS)
        if points.ndim != 2 or points.shape[1] != 3 or points.dtype.kind not in "iuf":
            raise InvalidInput(f"{key} is {points.shape} of {points.dtype}: expected numbers (N, 3)")
        rows = arrays.get(name + _ROWS)
        if rows is None or rows.ndim != 1 or rows.dtype.kind not in "iu" or len(rows) < 2:
            raise InvalidInput(f"object {name!r} has no {name + _ROWS}: expected the first row of each frame")
        if (np.diff(rows.astype(np.int64)) < 0).any() or rows[0] < 0 or rows[-1] > len(points):
            raise InvalidInput(f"{name + _ROWS} does not rise from 0 to the {len(points)} rows of {key}")
        tracks[name] = points, rows
    if not tracks:
        raise InvalidInput(
            f"no tracked objects among the arrays {sorted(arrays)}: expected NAME{_POINTS} and NAME{_ROWS}"
        )
    return tracks


def _with_table(
    arrays: Mapping[str, Array],
    tracks: Mapping[str, tuple[Array, Array]],
    fixed: list[str],
    up: ArrayLike | None,
) -> Scene:
    """All frames in one scene, with a table that reaches under all of them."""
    parts = Parts(
        clouds={name: _usual(points[::TABLE_STEP] * UNIT) for name, (points, _) in tracks.items()},
        fixed=[str(name) for name in np.ravel(arrays["fixed"])] if "fixed" in arrays else [],
        up=arrays.get("up"),
        viewpoints=arrays.get("viewpoints", np.zeros((1, 3))),
        table_plane=arrays.get("table_plane"),
        masses=amounts_in(arrays, "masses"),
        friction=amounts_in(arrays, "friction"),
    )
    return assemble(parts, fixed, up)


def _usual(points: FloatArray) -> FloatArray:
    """The points without those far out: stray ones would lay a table through the whole room."""
    lower, upper = np.quantile(points, (FAR_OUT, 1 - FAR_OUT), axis=0)
    inside = ((points >= lower) & (points <= upper)).all(axis=1)
    return points[inside] if np.count_nonzero(inside) > 1 else points
