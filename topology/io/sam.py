"""Masks as a segmentation of everything gives them, such as SAM: some cover others, fragments, or the table.

Format: https://github.com/facebookresearch/segment-anything, `SamAutomaticMaskGenerator.generate`.
"""

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike

from topple.topology.base.arguments import checked_arguments
from topple.topology.base.arrays import BoolArray, FloatArray, IntArray
from topple.topology.base.checks import Names, as_names, numeric
from topple.topology.base.errors import InvalidInput
from topple.topology.base.tolerances import DUPLICATE_SHARE
from topple.topology.io.archive import MASK_KEYS, STACK_KEY, Array, read_arrays
from topple.topology.io.assemble import Parts, assemble
from topple.topology.io.coco import mask_of
from topple.topology.io.labels import label_of_stack
from topple.topology.io.limits import allow, read_text
from topple.topology.io.rgbd import as_stack, parts_from_rgbd
from topple.topology.io.strict_json import read_json
from topple.topology.scene.scene import Scene
from topple.topology.views.tolerances import FEWEST


@checked_arguments
def scene_from_sam(
    depth: ArrayLike,
    K: ArrayLike,
    masks: Any,
    pose_camera_to_world: ArrayLike | None = None,
    *,
    fixed: Names = (),
    **more: ArrayLike,
) -> Scene:
    """Make a scene of a depth image and the masks of SAM, or of another segmentation of everything.

    Objects are called by the places of their masks, from 1 on. `Scene.wrong_masks` says which masks depth
    contradicts, and `Scene.assumptions` which were left out: fragments, second ones of a region, and those
    that reach from one edge of the picture to the other, which are searched for the table.

    Args:
        depth: (H, W) in [m], 0 or NaN where there is none.
        K: (3, 3) intrinsic matrix in pixels.
        masks: What SAM returns: a list of mappings whose `segmentation` is an array (H, W), run lengths or
            compressed run lengths, perhaps with `predicted_iou`; or a stack (N, H, W) or (N, 1, H, W).
        pose_camera_to_world: (4, 4); the camera's own frame where None.
        fixed: Names of what never moves.
        **more: Other arrays of such a file, `up` and `table_plane` among them (`parts_from_rgbd`).

    Returns:
        The scene.

    Raises:
        InvalidInput: A mask is none or does not fit the image, or none is left.
        UnknownObject: `fixed` names an object that no mask shows.

    Examples:
        >>> scene_from_sam(depth, K, [mask == 1]).names
        ('1', 'table')
    """
    posed = {} if pose_camera_to_world is None else {"pose_camera_to_world": pose_camera_to_world}
    given = {"depth": depth, "K": K, **posed}
    arrays = {key: numeric(value, key) for key, value in given.items()}
    arrays |= {key: np.asarray(value) for key, value in more.items()}
    return assemble(parts_from_sam(arrays, masks, as_names(fixed)), as_names(fixed), None)


def parts_from_sam(arrays: Mapping[str, Array], masks: Any, kept: Sequence[str] = ()) -> Parts:
    """Lift the pixels of masks into clouds.

    Args:
        arrays: As for `parts_from_rgbd`, without a mask.
        masks: As for `scene_from_sam`.
        kept: Names that are not taken for the table.

    Returns:
        What they say, with what was left out.

    Raises:
        InvalidInput: There is a mask besides, or no depth; a mask does not fit the image, or none is left.
    """
    given = [key for key in (*MASK_KEYS, STACK_KEY) if key in arrays]
    if given or "depth" not in arrays:
        raise InvalidInput(f"has {given or sorted(arrays)}: expected depth and K, and the masks apart")
    label, notes = label_of_masks(masks, arrays["depth"], kept)
    parts = parts_from_rgbd({**arrays, "label": label})
    parts.notes += notes
    return parts


def read_masks(path: str | os.PathLike[str]) -> Any:
    """Read masks from a file.

    Args:
        path: A `.json` of a list of mappings with run lengths, alone or as `annotations`; an `.npy` of a
            stack; or an `.npz` with `masks`, or with one array alone.

    Raises:
        InvalidInput: It is none of these, or a pickle, which is never loaded.
    """
    place = Path(path)
    try:
        with allow(None, place):
            if place.suffix.lower() == ".json":
                found = read_json(read_text(place, place.name), place.name)
                found = cast(dict[str, Any], found).get("annotations") if isinstance(found, dict) else found
            else:
                arrays = read_arrays(place, STACK_KEY)
                found = arrays.get(STACK_KEY, next(iter(arrays.values())) if len(arrays) == 1 else None)
    except OSError as error:
        raise InvalidInput(f"{place}: cannot be read: {error.strerror or error}") from error
    if not isinstance(found, list | np.ndarray):
        raise InvalidInput(
            f"{place.name}: expected a list of {{'segmentation'}}, or it as 'annotations'; or an array masks"
        )
    return cast(Any, found)


def label_of_masks(masks: Any, depth: FloatArray, kept: Sequence[str] = ()) -> tuple[IntArray, list[str]]:
    """Make one mask of many.

    Args:
        masks: As for `scene_from_sam`.
        depth: (H, W) in [m].
        kept: Names that are not taken for the table.

    Returns:
        (H, W) labels, the masks' places from 1 on; and sentences on what was left out or overlaps.

    Raises:
        InvalidInput: A mask is none or does not fit the image, or none is left.
    """
    if depth.ndim != 2:
        raise InvalidInput(f"depth has shape {depth.shape}: expected an image (H, W) in metres")
    stack, scores = _stack_of(masks, depth.shape)
    left: dict[str, list[int]] = {}
    places = list[int]()
    for k in np.argsort(-scores, kind="stable").tolist():
        if str(k + 1) not in kept and _crosses(stack[k]):
            left.setdefault("reach across the picture: searched for the table", []).append(k + 1)
        elif any(_overlap(stack[k], stack[other]) > DUPLICATE_SHARE for other in places):
            left.setdefault("show a region again", []).append(k + 1)
        else:
            places.append(k)
    places.sort(key=lambda k: (-int(stack[k].sum()), k))  # of two the smaller one is in front
    while True:
        top = np.zeros(depth.shape, dtype=np.int64)
        for k in places:
            top[stack[k]] = k + 1
        counts = np.bincount(top[np.isfinite(depth) & (depth > 0)], minlength=len(stack) + 1)
        if not (few := [k for k in places if counts[k + 1] < FEWEST]):
            break
        places.remove(few[-1])  # the smallest: what it covered is seen again
        left.setdefault(f"have fewer than {FEWEST} pixels of depth of their own", []).append(few[-1] + 1)
    said = [f"masks {', '.join(map(str, sorted(ks)))} {why}; left out" for why, ks in left.items()]
    if not places:
        raise InvalidInput(f"none of {len(stack)} masks is of an object: {said or ['there is none']}")
    places.sort()
    return top, [*label_of_stack(stack[places], [k + 1 for k in places])[1], *said]


def _stack_of(masks: Any, shape: tuple[int, ...]) -> tuple[BoolArray, FloatArray]:
    """The masks (N, H, W), and how good each is said to be (N,)."""
    if isinstance(masks, Sequence) and masks and isinstance(masks[0], Mapping):
        given = cast(Sequence[Mapping[str, Any]], masks)
        stack = np.array([mask_of(m.get("segmentation"), shape, f"mask {k}") for k, m in enumerate(given, 1)])
        return stack, numeric([m.get("predicted_iou", 0.0) for m in given], "predicted_iou")
    stack = as_stack(numeric(masks, "masks"))
    if stack.shape[1:] != shape:
        raise InvalidInput(f"masks are {stack.shape[1:]} and depth is {shape}: expected one size")
    return stack, np.zeros(len(stack))


def _crosses(mask: BoolArray) -> bool:
    """Whether a mask reaches from one edge of the picture to the opposite one."""
    return any(bool(side[0].any() and side[-1].any()) for side in (mask, mask.T))


def _overlap(one: BoolArray, other: BoolArray) -> float:
    """Intersection over union."""
    return float((one & other).sum() / max(int((one | other).sum()), 1))
