"""DepthImage: one look of a depth camera, with a mask that says which pixel is which object."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from topple.topology.base.arguments import checked_arguments
from topple.topology.base.arrays import (
    BoolArray,
    FloatArray,
    IntArray,
    freeze,
    frozen_int,
    round_off,
    whole_numbers,
)
from topple.topology.base.checks import as_intrinsics, as_name, as_pose, numeric
from topple.topology.base.errors import InvalidInput
from topple.topology.base.tolerances import (
    BENT,
    FARTHEST_DEPTH,
    FEWEST_SEEN,
    LIKELY_AWAY,
    OFF_CENTRE,
    STRAIGHTER,
)
from topple.topology.base.values import ByValue, FrozenDict
from topple.topology.kernels.tolerances import NEAREST
from topple.topology.views.borders import Borders, borders
from topple.topology.views.tolerances import FEWEST

_Value = TypeVar("_Value")

_UNITS = {1000: "millimetres", 10_000: "tenths of a millimetre", 100: "centimetres"}
IGNORED = "ignore"
"""Name of pixels that are of nothing in the scene."""


@checked_arguments
@dataclass(frozen=True, eq=False)
class DepthImage(ByValue):
    """A depth image with instance labels.

    Attributes:
        depth: Distance along the optical axis (H, W) in [m]; 0 where there is none.
        K: Intrinsic matrix (3, 3) in pixels.
        label: Instance labels (H, W); 0 is background.
        pose_camera_to_world: Camera pose (4, 4); camera axes x right, y down, z forward.
        names: Name of each label; a label without one is named by its number. What is called "ignore" is
            nobody's and in nobody's way: a robot in its own picture.
        rgb: Colours (H, W, 3), or None.

    Raises:
        InvalidInput: If the parts do not fit together or are not what they should be.

    Examples:
        >>> DepthImage(depth, K, mask, names={1: "cup"}).pixels()
        {'cup': 400}
    """

    depth: FloatArray
    K: FloatArray
    label: IntArray
    pose_camera_to_world: FloatArray = field(default_factory=lambda: np.eye(4))
    names: Mapping[int, str] = field(default_factory=dict[int, str])
    rgb: NDArray[np.uint8] | None = None

    def __post_init__(self) -> None:
        """Check every part and make it read-only."""
        depth = _as_depth(self.depth)
        label = _as_label(self.label)
        if label.shape != depth.shape:
            raise InvalidInput(
                f"the mask is {label.shape} and the depth {depth.shape}: "
                "expected one label per depth pixel, (H, W) both"
            )
        names = {int(number): as_name(name) for number, name in self.names.items()}
        if len(set(names.values())) < len(names):
            raise InvalidInput(
                f"two labels share a name: {sorted(names.values())}; expected one name per label"
            )
        object.__setattr__(self, "depth", depth)
        object.__setattr__(self, "K", as_intrinsics(self.K, depth.shape[1]))
        object.__setattr__(self, "label", label)
        object.__setattr__(
            self, "pose_camera_to_world", as_pose(self.pose_camera_to_world, "pose_camera_to_world")
        )
        object.__setattr__(self, "names", FrozenDict(names))
        object.__setattr__(self, "rgb", _as_rgb(self.rgb, depth.shape))

    def __reduce__(self) -> tuple[object, ...]:
        """Pickle by parts, so that an image can go to another process."""
        parts = (self.depth, self.K, self.label, self.pose_camera_to_world, dict(self.names), self.rgb)
        return (DepthImage, parts)

    @property
    def viewpoint(self) -> FloatArray:
        """Centre of the camera (3,) in world coordinates, in [m]."""
        return self.pose_camera_to_world[:3, 3]

    def enlarged(self, factor: float) -> "DepthImage":
        """The picture that the same things enlarged by a factor would give from as much further away."""
        pose = self.pose_camera_to_world.copy()
        pose[:3, 3] *= factor
        own = {each.name: getattr(self, each.name) for each in fields(self)}
        changed = {"depth": freeze(self.depth * factor), "pose_camera_to_world": freeze(pose)}
        larger = object.__new__(DepthImage)
        vars(larger).update(own | changed | {"borders": self.borders})  # whose a pixel is hangs on no size
        return larger

    @cached_property
    def borders(self) -> Borders:
        """Borders of the masks judged by depth: whose surface each pixel is by its depth."""
        return borders(self.depth, self.label)

    def points(self) -> FloatArray:
        """Lift every pixel into the world.

        Returns:
            Points (H, W, 3) in world coordinates in [m], NaN where there is no depth.
        """
        rows, columns = np.indices(self.depth.shape)
        points = self.lifted(rows.ravel(), columns.ravel()).reshape(*self.depth.shape, 3)
        points[self.depth <= 0] = np.nan
        return points

    def clouds(self) -> dict[str, FloatArray]:
        """Lift the pixels that have depth, each for the object whose surface it is of (see `borders`).

        Returns:
            Points (N, 3) in world coordinates in [m] per object, by ascending label; an object
            without a single pixel of depth is absent.
        """
        owner = self.borders.owner
        rows, columns = np.nonzero((owner > 0) & (self.depth > 0))
        labels = owner[rows, columns]
        by_label = np.argsort(labels, kind="stable")
        points = self.lifted(rows[by_label], columns[by_label])
        present, starts = np.unique(labels[by_label], return_index=True)
        pieces = np.split(points, starts[1:]) if len(present) else []
        return self._by_name(present, pieces)

    def background(self) -> FloatArray:
        """Lift the pixels that have depth and are of no object.

        Returns:
            Points (N, 3) in world coordinates in [m].
        """
        return self.lifted(*np.nonzero((self.borders.owner == 0) & (self.depth > 0)))

    def in_view(self, places: FloatArray) -> BoolArray:
        """Which places (N, 3) in world coordinates [m] lie within the picture's edges, hidden or not."""
        return self.pixels_of(places)[3]

    def depth_past(self, places: FloatArray, around: bool = False) -> FloatArray:
        """How much further than places the camera saw in their directions.

        Args:
            places: (N, 3) in world coordinates [m].
            around: Whether the pixels beside have to have seen as far: at an outline one alone may belong to
                what is behind.

        Returns:
            (N,) measured depth less that of the place [m]; -inf out of view and where nothing was measured.
        """
        rows, columns, depth, seen = self.pixels_of(places)
        past = np.full(len(places), -np.inf)
        measured = (self._nearest_around if around else self.depth)[rows[seen], columns[seen]]
        past[seen] = np.where(measured > 0, measured - depth[seen], -np.inf)
        return past

    def shows(self, places: FloatArray, slack: float) -> BoolArray:
        """Which places (N, 3) [m] are at most a slack [m] behind what was seen there, or a pixel beside."""
        rows, columns, depth, seen = self.pixels_of(places)
        farthest = self._farthest_around[rows, columns]
        return seen & (farthest > 0.0) & (depth < farthest + slack)

    @cached_property
    def _farthest_around(self) -> FloatArray:
        """(H, W) largest depth of each pixel and those beside it, any of which may have none [m]."""
        return ndimage.maximum_filter(self.depth, 3, mode="nearest")

    @cached_property
    def _nearest_around(self) -> FloatArray:
        """(H, W) least depth of each pixel and those beside it that have any; 0 where it has none [m]."""
        far = np.where(self.depth > 0, self.depth, np.inf)
        nearest = ndimage.minimum_filter(far, 3, mode="nearest")
        return np.where(self.depth > 0, nearest, 0.0)

    def labels_at(self, places: FloatArray, off: float) -> IntArray:
        """Whose surface this camera sees at places.

        Args:
            places: (N, 3) in world coordinates [m].
            off: Depth [m] by which a surface may be off a place.

        Returns:
            (N,) labels; 0 where another surface is seen, or none.
        """
        rows, columns, depth, seen = self.pixels_of(places)
        there = seen & (np.abs(self.depth[rows, columns] - depth) <= off)
        return np.where(there, self.borders.owner[rows, columns], 0)

    def pixels_of(self, places: FloatArray) -> tuple[IntArray, IntArray, FloatArray, BoolArray]:
        """Row, column and depth [m] of places (N, 3), and which of them are in the picture."""
        local = (places - self.viewpoint) @ self.pose_camera_to_world[:3, :3]
        ahead = local[:, 2] > 1e-6
        pixel = local @ self.K.T / np.where(ahead, local[:, 2], 1.0)[:, None]
        column, row = np.floor(pixel[:, :2].T + 0.5)
        height, width = self.depth.shape
        inside = ahead & (column >= 0) & (column < width) & (row >= 0) & (row < height)
        rows, columns = (np.where(inside, each, 0).astype(np.int64) for each in (row, column))
        return rows, columns, local[:, 2], inside

    def pixels(self) -> dict[str, int]:
        """Count the pixels of each object, with depth or without.

        Returns:
            Number of mask pixels per object, by ascending label.
        """
        present, counts = np.unique(self.label[self.label > 0], return_counts=True)
        return self._by_name(present, counts.tolist())

    def _by_name(self, numbers: IntArray, values: Iterable[_Value]) -> dict[str, _Value]:
        """Values of labels by name, without what is to be ignored."""
        named = zip(map(self.name_of, numbers.tolist()), values, strict=True)
        return {name: value for name, value in named if name != IGNORED}

    def name_of(self, number: int) -> str:
        """Name of a label: the one given, or the number itself."""
        return self.names.get(number, str(number))

    def lifted(self, rows: NDArray[np.intp], columns: NDArray[np.intp]) -> FloatArray:
        """Lift pixels that have depth: (k,) rows and columns to points (k, 3) in world coordinates [m]."""
        depth = self.depth[rows, columns]
        y = (rows - self.K[1, 2]) * depth / self.K[1, 1]
        x = ((columns - self.K[0, 2]) * depth - self.K[0, 1] * y) / self.K[0, 0]
        in_camera = np.stack([x, y, depth], axis=1)
        return round_off(in_camera @ self.pose_camera_to_world[:3, :3].T + self.viewpoint)


def _as_depth(depth: FloatArray) -> FloatArray:
    array = numeric(depth, "depth")
    if array.ndim != 2 or array.size == 0:
        raise InvalidInput(f"depth has shape {array.shape}: expected an image (H, W) in metres")
    array = np.where(np.isfinite(array), array, 0.0)  # depth cameras write "no return" as NaN, infinity or 0
    if array.min() < 0:
        raise InvalidInput(
            f"depth is negative in {int((array < 0).sum())} pixels: expected metres, 0 where there is none"
        )
    if array.max() > FARTHEST_DEPTH:
        middle = float(np.median(array[array > 0]))
        likely = {
            factor: unit
            for factor, unit in _UNITS.items()
            if LIKELY_AWAY[0] <= middle / factor <= LIKELY_AWAY[1]
        } or {1000: _UNITS[1000]}
        raise InvalidInput(
            f"depth reaches {array.max():.4g}, more than {FARTHEST_DEPTH:g} m: it looks like "
            f"{' or '.join(likely.values())}; topple takes metres, so divide by "
            f"{' or '.join(map(str, likely))}"
        )
    return freeze(array)


def _as_label(label: IntArray) -> IntArray:
    array = np.asarray(label)
    if array.ndim != 2:
        raise InvalidInput(
            f"the mask has shape {array.shape}: expected one label per pixel (H, W), 0 = background"
        )
    array = whole_numbers(array)
    if array.dtype.kind not in "iub":
        raise InvalidInput(f"the mask holds {array.dtype} values: expected whole numbers, 0 = background")
    if array.size and array.min() < 0:
        raise InvalidInput(
            f"the mask holds the label {array.min()}: expected 0 = background and objects from 1 on"
        )
    if array.size and int(array.max()) >= 1 << 63:
        raise InvalidInput(f"the mask holds the label {array.max()}: expected numbers of objects from 1 on")
    return frozen_int(array)


def _as_rgb(rgb: NDArray[np.uint8] | None, shape: tuple[int, ...]) -> NDArray[np.uint8] | None:
    if rgb is None:
        return None
    array = np.asarray(rgb)
    if array.shape != (*shape, 3) or array.dtype != np.uint8:
        raise InvalidInput(
            f"rgb has shape {array.shape} of {array.dtype}: expected ({shape[0]}, {shape[1]}, 3) of uint8"
        )
    colours = array.copy()
    colours.setflags(write=False)
    return colours


def said_of_images(images: Sequence[DepthImage]) -> list[str]:
    """Sentences on masks that are off and centres far from the middle, by picture where there are several."""
    said = [(number, note) for number, image in enumerate(images, 1) for note in _said_of(image)]
    return [note if len(images) == 1 else f"camera {number}: {note}" for number, note in said]


def _said_of(image: DepthImage) -> list[str]:
    size = np.array(image.depth.shape[::-1])
    centre, middle = image.K[:2, 2], (size - 1) / 2
    said = [note for note in [image.borders.said()] if note is not None]
    if (np.abs(centre - middle) > OFF_CENTRE * size).any():
        swapped = (np.abs(centre[::-1] - middle) < OFF_CENTRE / 2 * size).all()
        of = " x ".join(f"{2 * value + 1:.0f}" for value in centre)
        guess = (
            "are cx and cy swapped?"
            if swapped
            else f"is K of a picture of {of}? scale it; or is this a crop?"
        )
        said.append(
            f"K's centre ({centre[0]:g}, {centre[1]:g}) is far from the middle of the picture "
            f"({middle[0]:g}, {middle[1]:g}): {guess}"
        )
    return said


def _check_z_buffer(image: DepthImage) -> None:
    """Refuse depth as graphics cards keep it, in which planes are straight over the picture as they are."""
    seen = image.depth > 0
    if not seen.any() or image.depth.max() > 1.0:
        return
    rows, columns = np.nonzero(seen & (image.label == np.bincount(image.label[seen]).argmax()))
    over = np.column_stack([rows, columns, np.ones(len(rows))])
    depth = np.maximum(image.depth[rows, columns], NEAREST)
    off = [np.abs(over @ np.linalg.lstsq(over, each, rcond=None)[0] - each) for each in (depth, 1.0 / depth)]
    straight, bent = float(np.median(off[0])), float(np.median(off[1] * depth**2))
    if bent > BENT and straight < STRAIGHTER * bent:
        raise InvalidInput(
            f"depth looks like a raw z-buffer, 0..1, not metres: it reaches {image.depth.max():.3g}, and "
            "planes would be bent; give near * far / (far - depth * (far - near)), 0 where there is none"
        )


def check_depth(images: Sequence[DepthImage], clouds: Mapping[str, FloatArray], fewest: int = FEWEST) -> None:
    """Refuse raw z-buffers, and objects that masks show and depth does not: what carries them would go first.

    Args:
        images: The pictures.
        clouds: What they show of each object, (N, 3).
        fewest: Pixels of a mask from which an object is no sliver that hardly shows.

    Raises:
        InvalidInput: An object has so many pixels and next to no depth of its own, or depth is a z-buffer.
    """
    pixels = Counter[str]()
    for image in images:
        _check_z_buffer(image)
        pixels.update(image.pixels())
    for name, count in pixels.items():
        seen = len(clouds.get(name, ()))
        if seen < FEWEST_SEEN and count >= fewest:
            raise InvalidInput(
                f"object {name!r} has {count} pixel{'s' * (count > 1)} in its mask and depth of its own in "
                f"{seen or 'none'} of them, too few for a body (glass?): give their depth; or, only if "
                "nothing is there, set them to 0 (background)"
            )


@dataclass(frozen=True, eq=False)
class Photo(ByValue):
    """A picture for people, and what is where in it.

    Attributes:
        rgb: (H, W, 3) uint8.
        label: (H, W) which thing a pixel shows, 0 where none has a name.
        names: Label -> name.
    """

    rgb: Any
    label: IntArray
    names: Mapping[int, str] = field(default_factory=dict[int, str])
