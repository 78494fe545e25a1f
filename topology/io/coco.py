"""Scenes of a depth image and masks as COCO has them: polygons, run lengths, compressed run lengths.

Format: https://cocodataset.org/#format-data; run lengths go down the columns, zeros first.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from topple.topology.base.arguments import checked_arguments
from topple.topology.base.arrays import BoolArray
from topple.topology.base.checks import Names, numeric
from topple.topology.base.errors import InvalidInput
from topple.topology.base.values import free_name
from topple.topology.io.rgbd import scene_from_rgbd
from topple.topology.scene.scene import Scene

_ZERO, _BITS, _MORE, _SIGN = 48, 0x1F, 0x20, 0x10  # of a character of compressed run lengths


@checked_arguments
def scene_from_coco(
    depth: ArrayLike,
    K: ArrayLike,
    annotations: Sequence[Mapping[str, Any]],
    categories: Mapping[int, str] | Sequence[Mapping[str, Any]] = (),
    *,
    pose_camera_to_world: ArrayLike | None = None,
    fixed: Names = (),
    up: ArrayLike | None = None,
) -> Scene:
    """Make a scene of what a depth camera saw and a segmentation cut out.

    Args:
        depth: (H, W) in [m], 0 where there is none.
        K: (3, 3) intrinsic matrix in pixels.
        annotations: Of one image, or detections: each with `segmentation`, a list of polygons or {"size",
            "counts"}, and perhaps `category_id` and `name`. Where masks overlap the smaller one is in front.
        categories: What categories are called: {id: name}, or [{"id", "name"}] as COCO lists them.
        pose_camera_to_world: (4, 4); the camera's own frame where None.
        fixed: Names of what never moves.
        up: Direction (3,) against gravity.

    Returns:
        The scene: an object is called as its category, a second one cup_2; or by its place, from 1 on. The
        table is looked for in what no mask claims.

    Raises:
        InvalidInput: A mask is none or does not fit the image, or no object has depth.

    Examples:
        >>> outline = {"segmentation": [[30, 20, 50, 20, 50, 40, 30, 40]], "category": "cup"}
        >>> scene_from_coco(depth, K, [outline]).names
        ('1', 'table')
    """
    image = numeric(depth, "depth")
    if image.ndim != 2:
        raise InvalidInput(f"depth has shape {image.shape}: expected an image (H, W) in metres")
    kinds = _kinds(categories)
    masks = [
        mask_of(each.get("segmentation"), image.shape, f"annotation {k}")
        for k, each in enumerate(annotations)
    ]
    names: list[str] = []
    for place, each in enumerate(annotations):
        (category,) = _whole([each.get("category_id", -1)], f"annotation {place}: category_id")
        names.append(free_name(str(each.get("name") or kinds.get(category, place + 1)), names))
    given = {} if up is None else {"up": up}
    stack = np.array(masks) if masks else np.zeros(image.shape)
    return scene_from_rgbd(image, K, stack, names, pose_camera_to_world, fixed=fixed, **given)


def _kinds(categories: Mapping[int, str] | Sequence[Mapping[str, Any]]) -> dict[int, str]:
    """Name each category by its number."""
    try:
        told = (
            dict(categories) if isinstance(categories, Mapping) else {c["id"]: c["name"] for c in categories}
        )
        return {int(number): str(name) for number, name in told.items()}
    except (KeyError, TypeError, ValueError) as error:
        raise InvalidInput("categories: expected {id: name}, or a list of {'id', 'name'}") from error


def _whole(values: Any, what: str) -> list[int]:
    try:
        return [int(value) for value in values]
    except (TypeError, ValueError, OverflowError) as error:
        raise InvalidInput(f"{what} holds what is no whole number ({error}): expected numbers") from error


def mask_of(segmentation: Any, shape: tuple[int, ...], what: str = "the mask") -> BoolArray:
    """Unpack a mask.

    Args:
        segmentation: A list of polygons [x1, y1, x2, y2, ...], or {"size": [H, W], "counts": lengths, or
            text or bytes of compressed ones}; or an array (H, W).
        shape: (H, W) of the image.
        what: What it is, for messages.

    Returns:
        (H, W) true where the object is.

    Raises:
        InvalidInput: It is none of these, or of another size.
    """
    height, width = shape
    if isinstance(segmentation, np.ndarray):
        if segmentation.shape != shape:
            raise InvalidInput(f"{what} is {segmentation.shape}: expected the image's size, {shape}")
        return segmentation.astype(np.bool_)
    if isinstance(segmentation, Mapping):
        size, counts = segmentation.get("size"), segmentation.get("counts")
        if size is None or counts is None or _whole(size, f"{what}: size") != [height, width]:
            raise InvalidInput(
                f"{what} is of the size {size}: expected counts and the image's, {[height, width]}"
            )
        lengths = _run_lengths(counts, what) if isinstance(counts, (str, bytes)) else _whole(counts, what)
        if min(lengths, default=0) < 0 or sum(lengths) != height * width:
            raise InvalidInput(
                f"{what} has runs of {sum(lengths)} pixels together: expected {height * width}, none below 0"
            )
        values = np.arange(len(lengths)) % 2 == 1
        return np.repeat(values, lengths).reshape(width, height).T
    if isinstance(segmentation, Sequence) and not isinstance(segmentation, (str, bytes)) and segmentation:
        return _fill_polygons(segmentation, height, width, what)
    raise InvalidInput(f"{what} has no segmentation: expected polygons, or {{'size', 'counts'}}")


def _fill_polygons(polygons: Sequence[Any], height: int, width: int, what: str) -> BoolArray:
    from PIL import Image, ImageDraw

    picture = Image.new("1", (width, height))
    draw = ImageDraw.Draw(picture)
    for polygon in polygons:
        corners = numeric(polygon, f"{what}: its polygon").ravel()
        if len(corners) < 6 or len(corners) % 2 or not np.isfinite(corners).all():
            raise InvalidInput(
                f"{what} has a polygon of {len(corners)} numbers: expected x, y of 3 corners or more"
            )
        draw.polygon([(float(x), float(y)) for x, y in corners.reshape(-1, 2)], fill=1)
    return np.asarray(picture, dtype=np.bool_)


def _run_lengths(counts: str | bytes, what: str) -> list[int]:
    """The lengths of compressed runs: five bits a character, each from the third on less that two before."""
    data = counts.encode("ascii", "replace") if isinstance(counts, str) else counts
    lengths: list[int] = []
    value = shift = 0
    for character in data:
        bits = character - _ZERO
        if not 0 <= bits < 64:
            raise InvalidInput(
                f"{what} has the character {chr(character)!r} in its counts: expected run lengths"
            )
        value |= (bits & _BITS) << shift
        shift += 5
        if bits & _MORE:
            continue
        if bits & _SIGN:
            value -= 1 << shift
        lengths.append(value + (lengths[-2] if len(lengths) > 2 else 0))
        value = shift = 0
    return lengths
