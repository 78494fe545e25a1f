"""Bodies from observed clouds: convex parts of what was seen, drawn down where nobody could look."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike
from scipy import ndimage
from scipy.spatial import ConvexHull, QhullError

from topple.robots.bodies import DENSITY, FRICTION, GREY, ROLLING, Body, Color
from topple.robots.convex import hull_of
from topple.robots.tolerances import TOLERANCES
from topple.topology.arrays import BoolArray, FloatArray, IntArray
from topple.topology.checks import as_direction, as_points
from topple.topology.cloud import clean

CELL = 0.006  # [m] of the grid on which a part's shadow is compared with what was seen under it
OPEN = (
    0.3  # share of the shadow that must be seen from above for the part to hover: noise and gaps stay below
)
GAP = 0.006  # [m] between a part and what it stands on: depth noise and a strip that an edge hides
BESIDE = 2  # cells around the shadow in which things count as under it: an edge hides a strip of the size
HOLLOW = 0.006  # [m] hulls may stand out from the points by this: less cuts noise into pieces
GRAIN = 0.003  # [m] cubes whose points are averaged before parts are cut: halves 1 to 2 mm of depth noise


def body_from_cloud(
    name: str,
    points: ArrayLike,
    up: ArrayLike,
    floor: float | None = None,
    *,
    viewpoints: ArrayLike | None = None,
    seen_below: ArrayLike | None = None,
    density: float = DENSITY,
    friction: float = FRICTION,
    color: Color = GREY,
) -> tuple[Body, FloatArray]:
    """Make a body of what cameras saw of a thing.

    Cameras look from above, so undersides are missing. Each convex part of the cloud is drawn straight down
    to what was seen under it or right beside, else to the floor; where most of what lies under it was seen,
    there is room and it stays in the air, as a spoon's handle does.

    Args:
        name: Its name in the scene.
        points: (N, 3) points in the world in [m].
        up: (3,) direction against gravity.
        floor: Height along `up` in [m] of what it rests on; None: its own lowest point.
        viewpoints: (k, 3) camera centres in [m], which tell a hollow from a side nobody saw.
        seen_below: (M, 3) points of the other things, in the world in [m].
        density: In [kg/m^3].
        friction: Coulomb coefficient.
        color: Red, green, blue, opacity in 0..1.

    Returns:
        The body, and its pose (4, 4) body to world: axes as the world's, origin in the middle of the points.
    """
    from topple.topology.parts import convex_parts

    cloud, upward = as_points(points, f"the cloud of {name!r}"), as_direction(up, "up")
    cloud = clean(cloud)
    origin = cloud.mean(axis=0)
    seen = None if viewpoints is None or len(np.atleast_2d(viewpoints)) == 0 else np.atleast_2d(viewpoints)
    pieces = (
        [cloud] if len(cloud) < 12 else convex_parts(_averaged(cloud), HOLLOW, viewpoints=_as_centres(seen))
    )
    ground = float((cloud @ upward).min()) if floor is None else floor
    below = np.zeros((0, 3)) if seen_below is None else as_points(seen_below, "seen_below")
    solid = [piece - origin for piece in _completed(pieces, upward, ground, below)]
    pose = np.eye(4)
    pose[:3, 3] = origin
    body = Body.of(
        name, solid, density=density, friction=friction, color=color, kind="cloud", rolling=ROLLING
    )
    return body, pose


def _as_centres(viewpoints: ArrayLike | None) -> FloatArray | None:
    return None if viewpoints is None else as_points(viewpoints, "viewpoints")


def _averaged(cloud: FloatArray) -> FloatArray:
    """Means (M, 3) of the points in cubes of the grain; the cloud itself if that leaves too few."""
    cells = np.floor(cloud / GRAIN).astype(np.int64)
    _, which, count = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    sums = np.zeros((len(count), 3))
    np.add.at(sums, which.ravel(), cloud)
    return sums / count[:, None] if len(count) >= 12 else cloud


def _completed(
    pieces: Sequence[FloatArray], up: FloatArray, floor: float, below: FloatArray
) -> list[FloatArray]:
    """Parts (V, 3) drawn down to the floor or to what was seen under them; one at least stands."""
    found = [_under(part, up, below[below @ up < np.median(part @ up)], floor) for part in pieces]
    lowest = int(np.argmin([float((part @ up).min()) for part in pieces]))
    stands = any(not hovers or (part @ up).min() - rest < GAP
                 for part, (rest, hovers) in zip(pieces, found, strict=True))  # fmt: skip
    solids: list[FloatArray] = []
    for index, (part, (rest, hovers)) in enumerate(zip(pieces, found, strict=True)):
        drops = not hovers or (index == lowest and not stands)
        depth = part @ up - rest if drops else np.zeros(len(part))
        drawn = part - np.maximum(depth, TOLERANCES.thinnest)[:, None] * up
        solid = np.concatenate([part, drawn])
        sunk = np.maximum(floor - solid @ up, 0.0)  # noise that reaches below what it rests on
        solids.append(hull_of(solid + sunk[:, None] * up)[0])
    return solids


def _under(part: FloatArray, up: FloatArray, below: FloatArray, floor: float) -> tuple[float, bool]:
    """Height along up in [m] of what a part stands on, and whether most of that was seen under it."""
    if len(below) == 0:
        return floor, False
    aside = _level_axes(up)
    shadow = _cells_of_hull(part @ aside.T)
    lower = shadow.min(axis=0) - BESIDE
    under = np.zeros(shadow.max(axis=0) + BESIDE + 1 - lower, dtype=bool)
    under[tuple((shadow - lower).T)] = True
    square = np.ones((2 * BESIDE + 1, 2 * BESIDE + 1), dtype=bool)
    wide: BoolArray = np.asarray(ndimage.binary_dilation(under, square), dtype=bool)
    places = np.floor(below @ aside.T / CELL).astype(np.int64) - lower
    within = ((places >= 0) & (places < under.shape)).all(axis=1)
    row, column = (places[within, axis].astype(np.intp) for axis in (0, 1))
    near = wide[row, column]
    if not near.any():
        return floor, False
    seen = np.zeros_like(under)
    seen[row, column] = True
    rest = float(np.quantile(below[within][near] @ up, 0.8))
    rest = rest if rest > floor + GAP else floor  # the floor itself, with its noise
    return rest, int((seen & under).sum()) >= OPEN * len(shadow)


def _level_axes(up: FloatArray) -> FloatArray:
    """(2, 3) level directions, square to each other and to up."""
    first = np.cross(up, [1.0, 0.0, 0.0] if abs(up[0]) < 0.9 else [0.0, 1.0, 0.0])
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(up, first)])


def _cells_of_hull(flat: FloatArray) -> IntArray:
    """Grid cells (C, 2) whose middles lie in the hull of points (V, 2); at least those of the points."""
    own = np.floor(flat / CELL).astype(np.int64)
    lower, upper = own.min(axis=0), own.max(axis=0)
    grid = np.stack(np.meshgrid(*(np.arange(a, b + 1) for a, b in zip(lower, upper, strict=True))), axis=-1)
    cells: IntArray = grid.reshape(-1, 2)
    try:
        edges = ConvexHull(flat).equations
        inside = ((cells + 0.5) * CELL @ edges[:, :2].T + edges[:, 2]).max(axis=1) <= 0
    except QhullError:  # a line
        return np.unique(own, axis=0)
    return np.unique(np.concatenate([cells[inside], own]), axis=0)


def bodies_from_clouds(
    clouds: Sequence[tuple[str, FloatArray]],
    up: ArrayLike,
    floor: float,
    viewpoints: ArrayLike | None = None,
    table: ArrayLike | None = None,
) -> list[tuple[Body, FloatArray]]:
    """Bodies of all clouds of a scene, each one completed down to the floor where nothing is seen under it.

    Args:
        clouds: Name and points (N, 3) in [m] of everything that can move.
        up: (3,) direction against gravity.
        floor: Height along `up` in [m] of the table.
        viewpoints: (k, 3) camera centres in [m].
        table: (T, 3) points of the table in [m]: where it is seen, nothing is over it.

    Returns:
        Body and pose (4, 4) body to world of each cloud.
    """
    found: list[tuple[Body, FloatArray]] = []
    thin = {name: _averaged(as_points(points, f"the cloud of {name!r}")) for name, points in clouds}
    ground = [] if table is None else [_averaged(as_points(table, "the table's cloud"))]
    for name, points in clouds:
        others = ground + [other for another, other in thin.items() if another != name]
        below = np.concatenate(others) if others else None
        found.append(body_from_cloud(name, points, up, floor, viewpoints=viewpoints, seen_below=below))
    return found
