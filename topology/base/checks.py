"""Validation of what comes in: numbers are refused where they enter, in the user's words."""

from collections.abc import Collection, Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from topple.topology.base.arrays import FloatArray, bounds, freeze
from topple.topology.base.errors import InvalidInput
from topple.topology.base.tolerances import (
    DUPLICATE_NEAR,
    DUPLICATE_OFFSET,
    DUPLICATE_POINTS,
    DUPLICATE_SHARE,
    FARTHEST,
    FEWEST_SEEN,
    LARGEST_EXTENT,
    LARGEST_HELD,
    RIGID,
    SMALLEST_SEEN,
)
from topple.topology.kernels.neighbours import PointTree


def numeric(values: ArrayLike, what: str) -> FloatArray:
    """Read real numbers.

    Args:
        values: Numbers of any shape.
        what: What they are, for the message.

    Returns:
        The values as float64.

    Raises:
        InvalidInput: If they are not real numbers, or their rows differ in length.
    """
    if isinstance(values, np.ma.MaskedArray) and np.ma.getmaskarray(values).any():
        raise InvalidInput(f"{what} has masked entries, which would count: leave these rows out")
    try:
        array = np.asarray(values)
    except ValueError as error:  # ragged nested lists
        raise InvalidInput(f"{what} is ragged: its rows differ in length; give a plain array") from error
    if array.dtype.kind not in "fiub":
        raise InvalidInput(f"{what} holds {_kind(array)}, expected real numbers")
    with np.errstate(invalid="ignore"):  # a signalling NaN is a NaN like any other
        read = array.astype(np.float64, copy=False)
        beyond = bool((np.abs(read) > FARTHEST).any()) and bool(np.isfinite(read).all())
    if beyond:
        raise InvalidInput(
            f"{what} has a number of {float(np.abs(read).max()):.3g}, beyond {FARTHEST:g}: there "
            "millimetres are lost; expected metres near the objects"
        )
    return read


def _kind(array: np.ndarray) -> str:
    names = {"O": "Python objects", "U": "text", "S": "text", "c": "complex numbers", "V": "records"}
    return names.get(array.dtype.kind, f"values of type {array.dtype}")


def as_points(points: ArrayLike, what: str) -> FloatArray:
    """Check one object's cloud.

    Args:
        points: Points (N, 3) in [m].
        what: What they are, for the message, e.g. "cloud 'mug'".

    Returns:
        A read-only copy (N, 3), N >= 1.

    Raises:
        InvalidInput: If the cloud is empty, not (N, 3), not finite, or so large that it is not in metres.
    """
    array = numeric(points, what)
    if array.size == 0:
        raise InvalidInput(
            f"{what} is empty: expected points (N, 3) in metres; leave the object out or give points"
        )
    if array.ndim != 2 or array.shape[1] != 3:
        raise InvalidInput(f"{what} has shape {array.shape}: expected points (N, 3), one x y z per row")
    if not np.isfinite(array).all():
        broken = int((~np.isfinite(array)).any(axis=1).sum())
        raise InvalidInput(
            f"{what} has NaN or infinity in {broken} of {len(array)} points: "
            "drop them, points[numpy.isfinite(points).all(axis=1)]"
        )
    lower, upper = bounds(array)
    extent = float((upper - lower).max())
    if extent > LARGEST_EXTENT:
        raise InvalidInput(
            f"{what} extends over {extent:.4g} m, more than {LARGEST_EXTENT:g} m: it looks like millimetres "
            "or another unit; topple takes metres, so scale it (millimetres: points / 1000)"
        )
    return freeze(array)


def as_direction(direction: ArrayLike, what: str) -> FloatArray:
    """Check a direction and give it unit length.

    Args:
        direction: Three numbers, not all zero.
        what: What it is, for the message.

    Returns:
        The unit vector (3,), read-only.

    Raises:
        InvalidInput: If it is not three finite numbers, or zero.
    """
    vector = numeric(direction, what)
    if vector.shape != (3,):
        raise InvalidInput(f"{what} has shape {vector.shape}: expected three numbers, such as 0 0 1")
    length = float(np.linalg.norm(vector))
    if not np.isfinite(vector).all() or not np.isfinite(length):
        raise InvalidInput(f"{what} is {_list_names(vector)}: expected finite numbers, such as 0 0 1")
    if length < 1e-9:
        raise InvalidInput(
            f"{what} is {_list_names(vector)}, which points nowhere: expected a direction, such as 0 0 1"
        )
    return freeze(vector / length)


def as_plane(plane: ArrayLike, what: str = "table_plane") -> FloatArray:
    """Check a plane and give its normal unit length.

    Args:
        plane: (n, d), four numbers: n.x + d is the height of x above the plane, in [m] for a unit n.
        what: What it is, for the message.

    Returns:
        The plane (4,) with a unit normal, read-only.

    Raises:
        InvalidInput: If it is not four finite numbers, or its normal is zero.
    """
    values = numeric(plane, what)
    if values.shape != (4,):
        raise InvalidInput(
            f"{what} has shape {values.shape}: expected four numbers (n, d), n.x + d = height in metres"
        )
    length = float(np.linalg.norm(values[:3]))
    if not np.isfinite(values).all() or length < 1e-9:
        raise InvalidInput(
            f"{what} is {_list_names(values)}: expected a finite, non-zero normal and its offset (n, d)"
        )
    return freeze(values / length)


def as_viewpoints(viewpoints: ArrayLike, what: str = "viewpoints") -> FloatArray:
    """Check camera centres.

    Args:
        viewpoints: Camera centres (k, 3) in [m], in the frame of the clouds; one centre may be (3,).
        what: What they are, for the message.

    Returns:
        A read-only copy (k, 3); k may be 0.

    Raises:
        InvalidInput: If they are not (k, 3) finite numbers.
    """
    array = numeric(viewpoints, what)
    if array.size == 0:
        return freeze(np.empty((0, 3)))
    if array.ndim == 1:
        array = array[None]
    if array.ndim != 2 or array.shape[1] != 3:
        raise InvalidInput(f"{what} has shape {array.shape}: expected camera centres (k, 3)")
    if not np.isfinite(array).all():
        raise InvalidInput(f"{what} holds NaN or infinity: expected finite camera centres (k, 3) in metres")
    return freeze(array)


def as_pose(pose: ArrayLike, what: str) -> FloatArray:
    """Check a rigid transform.

    Args:
        pose: Homogeneous transform (4, 4), translation in [m].
        what: What it is, for the message.

    Returns:
        A read-only copy (4, 4).

    Raises:
        InvalidInput: If it is not (4, 4) and finite, or it scales, shears or mirrors.
    """
    matrix = numeric(pose, what)
    if matrix.shape != (4, 4):
        raise InvalidInput(f"{what} has shape {matrix.shape}: expected a 4x4 transform")
    if not np.isfinite(matrix).all():
        raise InvalidInput(f"{what} holds NaN or infinity: expected a finite 4x4 transform")
    if np.abs(matrix[3] - [0.0, 0.0, 0.0, 1.0]).max() > RIGID:
        raise InvalidInput(
            f"{what} ends in the row {_list_names(matrix[3])}: expected 0 0 0 1; transpose it if it is"
        )
    rotation = matrix[:3, :3]
    if np.abs(rotation @ rotation.T - np.eye(3)).max() > RIGID:
        raise InvalidInput(
            f"{what} is not rigid: its rotation scales or shears; expected orthonormal columns: "
            "scale the points instead, and leave rotation and translation here"
        )
    if np.linalg.det(rotation) < 0:
        raise InvalidInput(
            f"{what} is mirrored: its rotation has determinant -1; expected a right-handed frame, +1: "
            "turn one axis round, or mirror the points instead"
        )
    return freeze(matrix)


def as_intrinsics(matrix: ArrayLike, width: int, what: str = "K") -> FloatArray:
    """Check a camera's intrinsic matrix.

    Args:
        matrix: [[fx, skew, cx], [0, fy, cy], [0, 0, 1]] in pixels.
        width: Width of the image it belongs to, in pixels.
        what: What it is, for the message.

    Returns:
        A read-only copy (3, 3).

    Raises:
        InvalidInput: If it is not a pinhole camera's matrix in pixels.
    """
    wanted = "expected [[fx, 0, cx], [0, fy, cy], [0, 0, 1]] in pixels"
    intrinsics = numeric(matrix, what)
    if intrinsics.shape != (3, 3):
        raise InvalidInput(f"{what} has shape {intrinsics.shape}: {wanted}")
    if not np.isfinite(intrinsics).all():
        raise InvalidInput(f"{what} is no intrinsic matrix: it holds NaN or infinity; {wanted}")
    if np.abs(intrinsics[2] - [0.0, 0.0, 1.0]).max() > 1e-6 or abs(intrinsics[1, 0]) > 1e-6:
        raise InvalidInput(f"{what} is no intrinsic matrix: its lower triangle is not 0, 0 0 1; {wanted}")
    focal = float(min(intrinsics[0, 0], intrinsics[1, 1]))
    if focal <= 0:
        raise InvalidInput(
            f"{what} is no intrinsic matrix: its focal length is {focal:g}; {wanted}, fx and fy > 0"
        )
    if focal < width / 20:  # a field of view beyond 168 degrees: metres or an identity, not pixels
        raise InvalidInput(
            f"{what} is no intrinsic matrix of an image {width} pixels wide: "
            f"its focal length is {focal:g} pixels; {wanted}"
        )
    return freeze(intrinsics)


def as_name(name: object, what: str = "object") -> str:
    """Check an object's name.

    Args:
        name: The name.
        what: What it names, for the message.

    Returns:
        The name itself.

    Raises:
        InvalidInput: If it is not text, is blank, or would not fit on one line.
    """
    if not isinstance(name, str):
        raise InvalidInput(f"{what} name {name!r} is not text")
    if not name.strip() or not name.isprintable():
        raise InvalidInput(
            f"{what} name {name!r} is blank or has unprintable characters: give it a plain name"
        )
    return name


def _list_names(values: FloatArray) -> str:
    return "[" + " ".join(f"{value:g}" for value in values) + "]"


Names = Iterable[str] | str | None
"""Names in a collection of any kind, one of them, or none."""


def as_names(names: Names) -> list[str]:
    """Names as a list, whether they are given as one text, none, or a collection of any kind."""
    given: Any = names.tolist() if isinstance(names, (np.ndarray, np.generic)) else names
    return [] if given is None else [given] if isinstance(given, str) else list(given)


def as_clouds(clouds: Mapping[str, ArrayLike]) -> dict[str, FloatArray]:
    """Check the clouds of a scene.

    Args:
        clouds: Points (N, 3) in [m] by name.

    Returns:
        Read-only copies.

    Raises:
        InvalidInput: If there is none, or a name or cloud is not what it should be.
    """
    if not clouds:
        raise InvalidInput("the scene has no objects: expected at least one named cloud (N, 3) in metres")
    return {as_name(name): as_points(points, f"cloud {name!r}") for name, points in clouds.items()}


def check_unit(movable: Mapping[str, FloatArray]) -> None:
    """Refuse a scene whose objects are too large for metres: three quarters of them, as a floor may be one.

    Raises:
        InvalidInput: Most objects are longer than anything an arm takes.
    """
    if not movable:
        return
    seen = {name: points for name, points in movable.items() if len(points) > FEWEST_SEEN}
    widths = {name: float(np.ptp(points, axis=0).max()) for name, points in seen.items()}
    if 0.0 < max(widths.values(), default=0.0) < SMALLEST_SEEN:  # points in one place tell no unit
        name = max(widths, key=widths.__getitem__)
        raise InvalidInput(
            f"no object is larger than {1e3 * SMALLEST_SEEN:g} mm, {name!r} has {1e3 * widths[name]:.3g}: "
            "too small; topple takes metres, so scale the scene (kilometres: points * 1000)"
        )
    ends = {name: np.quantile(points, (0.05, 0.95), axis=0) for name, points in movable.items()}  # no strays
    extents = {name: float((high - low).max()) for name, (low, high) in ends.items()}
    name = sorted(extents, key=extents.__getitem__)[(len(extents) - 1) // 4]
    if extents[name] > LARGEST_HELD:
        raise InvalidInput(
            f"most objects are longer than {LARGEST_HELD:g} m, {name!r} {extents[name]:.4g} m: centimetres? "
            "topple takes metres, so scale the scene (centimetres: points / 100); what never moves may be "
            "larger: name it with fixed=NAME"
        )


def duplicates(clouds: Mapping[str, FloatArray], fixed: Collection[str]) -> list[str]:
    """Sentences on things that are there under two names: copies, with noise or of a part."""
    names, said, trees = list(clouds), list[str](), dict[int, PointTree]()
    low, high = np.array([bounds(cloud) for cloud in clouds.values()]).swapaxes(0, 1)
    least, most = low - DUPLICATE_NEAR, high + DUPLICATE_NEAR
    for a, name in enumerate(names):
        within = ((low[a] >= least) & (high[a] <= most)).all(axis=1)
        around = ((least[a] <= low) & (most[a] >= high)).all(axis=1)  # and is told from there
        within[: a + 1] &= ~around[: a + 1]
        for b in np.flatnonzero(within).tolist():
            if b == a or {name, names[b]} <= set(fixed):
                continue
            points = clouds[name][:: 1 + len(clouds[name]) // DUPLICATE_POINTS]
            tree = trees[b] if b in trees else trees.setdefault(b, PointTree(clouds[names[b]]))
            distance, nearest = tree.query(points)
            near = distance <= DUPLICATE_NEAR
            if near.mean() < DUPLICATE_SHARE:
                continue
            aside = (points - clouds[names[b]][nearest])[near].mean(axis=0)
            if np.linalg.norm(aside) < DUPLICATE_OFFSET:
                said.append(f"{name!r} lies where {names[b]!r} is: one thing under two names? leave one out")
                break  # of many copies each is told once
    return said
