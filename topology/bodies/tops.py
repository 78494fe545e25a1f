"""The tops of a body: its level surfaces that things can stand on, whatever else its cloud shows of it.

A table's cloud may be its top alone, both faces of a board, a board with its sides and legs, or the boards
and walls of a shelf. A top is a level surface wide enough to stand something on, with room above it: not the
underside of a board, nor the inside of something solid.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import binary_closing, binary_dilation, distance_transform_edt
from scipy.spatial import ConvexHull

from topple.topology.base.arrays import (
    BoolArray,
    FloatArray,
    IntArray,
    bounds,
    freeze,
    median_of,
    middle_of,
    quantiles_of,
)
from topple.topology.base.remembered import remember
from topple.topology.base.tolerances import DEPTH_NOISE
from topple.topology.bodies.tolerances import (
    FACES,
    FILLED,
    FLAT,
    GRAIN,
    HALF_WIDTH,
    MISSES,
    MOST_CELLS,
    MOST_LEVELS,
    OVERLAP,
    RAISED,
    ROOM,
    ROUNDS,
    SECTORS,
    SUNK,
    TOPS_CELL,
    TOPS_CLOSED,
    TOPS_FEWEST,
    TOPS_LEAST,
    TOPS_LEVEL,
    TWO_FACED,
    VOTE,
    WALLED,
    WIDEST_BAND,
)
from topple.topology.geometry.axes import perpendiculars
from topple.topology.geometry.pieces import pieces_of, surface_spacing
from topple.topology.geometry.plane import fit_plane, plane_through
from topple.topology.geometry.thin import spacing_of, voxel_means
from topple.topology.geometry.tolerances import ENOUGH, PIECE_FEWEST
from topple.topology.scene.tolerances import RISES

REMEMBERED = 64  # clouds whose tops are kept


@dataclass(frozen=True, eq=False)
class Top:
    """A level surface that things can stand on.

    Attributes:
        normal: (3,) unit normal, on the side of up.
        height: Of the surface along the normal [m].
        points: (N, 3) points on it [m].
        thickness: Distance to the underside of the board [m]; nan where that was not seen.
        walled: Whether walls stand around it and nothing covers it, as around the floor of a bin.
    """

    normal: FloatArray
    height: float
    points: FloatArray
    thickness: float = np.nan
    walled: bool = False

    def above(self, points: FloatArray) -> FloatArray:
        """(N,) heights of points (N, 3) above the surface [m]."""
        return points @ self.normal - self.height


@dataclass(frozen=True, eq=False)
class Tops:
    """A body taken apart into its tops and what is left.

    Attributes:
        tops: The highest first; none for a body without a level surface.
        rest: (M, 3) points on none of them: undersides, sides, legs, walls [m].
    """

    tops: tuple[Top, ...]
    rest: FloatArray

    @property
    def flat(self) -> bool:
        """Whether the cloud is one top and nothing else: a table seen from above, perhaps cut off."""
        return len(self.tops) == 1 and len(self.rest) == 0

    def under(self, points: FloatArray, margin: float = 0.05) -> Top | None:
        """The top that something stands on or over, if any.

        Args:
            points: (N, 3) points of it [m].
            margin: How far a top is taken to go on beyond what was seen of it [m].

        Returns:
            The highest top that lies below its middle and within whose box it is; without regard to the
            box where it is over none, as a cloud may be cut off.
        """
        middle = middle_of(points)
        below = [top for top in self.tops if float(top.above(middle[None])[0]) > -DEPTH_NOISE]
        over = [top for top in below if _beside(top, points, margin)]
        return next(iter(over or below), None)


def lowest_in_use(tops: Sequence[Top], clouds: Sequence[FloatArray]) -> Top:
    """The highest of some tops that no object reaches below; the lowest one where objects reach below all.

    Args:
        tops: At least one.
        clouds: (N, 3) points of each object [m].
    """
    carrying = [top for top in tops if all(float(top.above(cloud).min()) > -SUNK for cloud in clouds)]
    return max(carrying, key=lambda top: top.height) if carrying else min(tops, key=lambda top: top.height)


def tops_of(cloud: FloatArray, up: FloatArray) -> Tops:
    """Find the tops of a body.

    A cloud no thicker than depth noise is one top. Of any other, level planes are looked for (RANSAC) and
    kept where a disc of 6 cm fits on them; what lies closely under another level, or is closed off from all
    sides under one, is the underside of a board or of something solid.

    Args:
        cloud: (N, 3) points [m].
        up: (3,) unit vector.

    Returns:
        The tops and the rest of the points. Deterministic, and remembered.
    """
    rest = np.ones(len(cloud), dtype=np.bool_)
    tops: list[Top] = []
    for level in _levels(cloud, up):
        rest &= ~level.members
        points = cloud if level.members.all() else cloud[level.members]
        tops.append(Top(freeze(level.normal), level.height, points, level.thickness, level.walled))
    return Tops(tuple(tops), cloud[rest])


def _beside(top: Top, points: FloatArray, margin: float) -> bool:
    """Whether points (N, 3) lie, in part, over the box around a top."""
    axes = np.stack(perpendiculars(top.normal), axis=1)
    own, other = top.points @ axes, points @ axes
    (least, most), (lowest, highest) = bounds(own), bounds(other)
    return bool((highest > least - margin).all() and (lowest < most + margin).all())


def _surface(whole: FloatArray, up: FloatArray) -> tuple[FloatArray, float] | None:
    """Normal and height of a cloud that is one level surface, strays aside; None for any other."""
    cloud = whole[:: max(1, len(whole) // ENOUGH)]
    kept = cloud
    normal = up
    for _ in range(3):
        middle, normal = plane_through(kept)
        normal = normal if normal @ up >= 0 else -normal
        distance = np.abs((cloud - middle) @ normal)
        kept = cloud[distance <= quantiles_of(distance, 0.9)[0]]
        if len(kept) < 3:
            return None
    heights = kept @ normal
    if normal @ up < TOPS_LEVEL or float(np.ptp(heights)) > FLAT:
        return None
    height = median_of(heights)
    off = whole[np.abs(whole @ normal - height) > max(RISES, 4.0 * _spread(heights))]
    if len(off) >= PIECE_FEWEST and pieces_of(
        voxel_means(off, 2 * GRAIN, ahead=0.0), surface_spacing(off, spacing_of(whole))
    ):
        return None
    parting = _height_between_faces(cloud @ normal)
    if parting is None:
        return normal, height
    grid = _Grid.of(cloud, up)
    upper = cloud @ normal > parting
    board = grid.share_under(grid.cells(cloud[~upper]), grid.cells(cloud[upper])) > OVERLAP
    return None if board else (normal, height)


def _height_between_faces(heights: FloatArray) -> float | None:
    """Height between the two faces of a board whose points have these heights; None for one face."""
    low, high = quantiles_of(heights, 0.05, 0.95)
    middle = (low + high) / 2.0
    upper, lower = heights[heights > middle], heights[heights <= middle]
    if min(len(upper), len(lower)) < 0.15 * len(heights):
        return None
    apart = median_of(upper) - median_of(lower)
    return middle if apart > max(FACES, TWO_FACED * max(_spread(upper), _spread(lower))) else None


def _spread(values: FloatArray) -> float:
    """Standard deviation, strays aside."""
    return 1.4826 * median_of(np.abs(values - median_of(values)))


@dataclass(frozen=True, eq=False)
class _Grid:
    """Cells of a plan view, so large that hardly any inside a surface is empty.

    Attributes:
        axes: (3, 2) level directions.
        corner: (2,) of the grid [m].
        cell: Edge of a cell [m].
        shape: Number of cells along each axis.
    """

    axes: FloatArray
    corner: FloatArray
    cell: float
    shape: tuple[int, int]

    @staticmethod
    def of(cloud: FloatArray, up: FloatArray, level: FloatArray | None = None) -> "_Grid":
        """The grid for a cloud, with the spacing of (N, 3) points on one of its levels."""
        axes = np.stack(perpendiculars(up), axis=1)
        plan = cloud @ axes
        corner, upper = bounds(plan)
        extent = upper - corner
        spacing = spacing_of(plan if level is None else level @ axes)
        cell = max(TOPS_CELL, 2.0 * spacing, float(extent.max()) / MOST_CELLS)
        sides = np.floor(extent / cell).astype(np.int64) + 5
        return _Grid(axes, corner - 2.0 * cell, cell, (int(sides[0]), int(sides[1])))

    def index(self, points: FloatArray) -> tuple[IntArray, IntArray]:
        """Cells of points (N, 3)."""
        index = np.floor((points @ self.axes - self.corner) / self.cell).astype(np.int64)
        return index[:, 0], index[:, 1]

    def cells(self, points: FloatArray) -> BoolArray:
        """Which cells points (N, 3) lie in, single empty ones among them filled."""
        taken = np.zeros(self.shape, dtype=np.bool_)
        taken[self.index(points)] = True
        return np.asarray(binary_closing(taken), dtype=np.bool_)

    def wide(self, points: FloatArray) -> BoolArray:
        """Which of points (N, 3) lie where a disc fits on them all (a morphological opening)."""
        reach = max(HALF_WIDTH / self.cell, 2.0)
        core = np.asarray(distance_transform_edt(self.cells(points))) >= reach
        opened = np.asarray(distance_transform_edt(~core)) <= reach
        corners = np.argwhere(opened)[:, None] + np.array([[0, 0], [0, 1], [1, 0], [1, 1]])
        if not core.any() or opened.sum() < FILLED * ConvexHull(corners.reshape(-1, 2)).volume:
            return np.zeros(len(points), dtype=np.bool_)
        return np.asarray(opened[self.index(points)])

    @staticmethod
    def share_under(lower: BoolArray, upper: BoolArray) -> float:
        """Share of some cells that lie under others or beside those."""
        return float(binary_dilation(upper)[lower].mean()) if lower.any() else 0.0


@dataclass(eq=False)
class _Level:
    """A level surface in the making: `members` is a mask over the cloud."""

    normal: FloatArray
    height: float
    members: BoolArray
    thickness: float = np.nan
    walled: bool = False


@remember(REMEMBERED)
def _levels(cloud: FloatArray, up: FloatArray) -> tuple[_Level, ...]:
    """The tops of a cloud, highest first."""
    surface = _surface(cloud, up)
    if surface is not None:
        return (_Level(*surface, np.ones(len(cloud), dtype=np.bool_)),)
    found: list[_Level] = []
    left = np.ones(len(cloud), dtype=np.bool_)  # planes are drawn from these
    free = left.copy()  # on no level: a plane that cuts boards aslant takes nothing from them
    grid: _Grid | None = None
    misses = 0
    while misses < MISSES and len(found) < MOST_LEVELS and np.count_nonzero(left) >= TOPS_FEWEST:
        normal, height = _densest(cloud[left], up)
        inside = free & (np.abs(cloud @ normal - height) <= DEPTH_NOISE)
        if np.count_nonzero(inside) < max(TOPS_FEWEST, TOPS_LEAST * len(cloud)):
            break
        grid = _Grid.of(cloud, up, cloud[inside]) if grid is None else grid
        levels = _faces(cloud, inside, free, normal, grid)
        taken = np.any([inside, *(level.members for level in levels)], axis=0)
        left &= ~taken
        free &= ~taken | (not levels)
        misses = 0 if levels else misses + 1
        found += levels
    if grid is None:
        return ()
    found.sort(key=lambda level: -float(middle_of(cloud[level.members]) @ up))
    return _with_room(found, cloud, up, grid)


def _densest(points: FloatArray, up: FloatArray) -> tuple[FloatArray, float]:
    """Normal and height of the level plane with most points about it."""
    plane, _ = fit_plane(points, inlier=VOTE, up=up)
    normal, height = plane[:3], -float(plane[3])
    some = points[:: max(1, len(points) // ENOUGH)]
    for _ in range(ROUNDS):
        near = some[np.abs(some @ normal - height) <= DEPTH_NOISE]
        if len(near) < 3:
            break
        middle, normal = plane_through(near)
        height = float(middle @ normal)
    return (normal, height) if normal @ up > 0 else (-normal, -height)


def _faces(
    cloud: FloatArray, inside: BoolArray, left: BoolArray, normal: FloatArray, grid: _Grid
) -> list[_Level]:
    """The level surface of points about a plane, or both faces of a board that is as thin as that.

    Args:
        cloud: (N, 3) points [m].
        inside: (N,) which lie about the plane.
        left: (N,) which lie on no level that was found before, those inside among them.
        normal: (3,) of the plane.
        grid: Of the cloud's plan view.
    """
    heights = cloud @ normal
    parting = _height_between_faces(heights[inside])
    sides = [inside] if parting is None else [inside & (heights > parting), inside & (heights <= parting)]
    found: list[_Level] = []
    for side in sides:
        height = median_of(heights[side])
        if parting is None:  # noise beyond the band belongs to the level, too
            band = float(np.clip(4.0 * _spread(heights[side]), DEPTH_NOISE, WIDEST_BAND))
            side = left & (np.abs(heights - height) <= band)
        members = side.copy()
        members[side] = grid.wide(cloud[side])
        if np.count_nonzero(members) >= max(TOPS_FEWEST, TOPS_LEAST * len(cloud)):
            found.append(_Level(normal, median_of(heights[members]), members))
    return found


def _with_room(levels: list[_Level], cloud: FloatArray, up: FloatArray, grid: _Grid) -> tuple[_Level, ...]:
    """The levels that have room above them, highest first; the others are undersides of these."""
    plan, heights = cloud @ grid.axes, cloud @ up
    cells = [grid.cells(cloud[level.members]) for level in levels]
    middles = [float(heights[level.members].mean()) for level in levels]
    board: list[int] = []  # of each level, the top whose underside it is, or its own number
    for number, level in enumerate(levels):
        over = [k for k in range(number) if grid.share_under(cells[number], cells[k]) > OVERLAP]
        low, own = middles[number], plan[level.members]
        lid = middles[over[-1]] if over else np.inf
        inset = 0.2 * (lid - low) if over else RAISED
        around = _around(plan, heights, own, low + inset, lid - inset)
        if over and (lid - low < ROOM or around >= TOPS_CLOSED):
            board.append(board[over[-1]])
            levels[board[-1]].thickness = middles[board[-1]] - low
        else:
            board.append(number)
            level.walled = not over and around >= WALLED
    return tuple(levels[number] for number in sorted(set(board)))


def _around(plan: FloatArray, heights: FloatArray, own: FloatArray, low: float, high: float) -> int:
    """In how many directions from the middle of a level something stands between two heights."""
    between = (heights > low) & (heights < high)
    rays = plan[between] - np.add(*bounds(own)) / 2.0
    turns = np.arctan2(rays[:, 1], rays[:, 0]) / (2.0 * np.pi) + 0.5
    return len(np.unique(np.floor(turns * SECTORS).astype(np.int64) % SECTORS))
