"""An RGB-D frame: depth, intrinsic matrix and a mask whose labels are the objects' names."""

from collections.abc import Mapping

import numpy as np

from topple.topology.errors import InvalidInput
from topple.topology.image import DepthImage
from topple.topology.io.archive import MASK_KEYS, STACK_KEY, Array
from topple.topology.io.assemble import Parts
from topple.topology.io.clouds import SPECIAL, amounts_in, ignored
from topple.topology.io.labels import NAMING, fixed_labels, label_names

_KEYS = ("depth", "K", "rgb", "pose_camera_to_world", "masses", "friction")


def parts_from_rgbd(arrays: Mapping[str, Array]) -> Parts:
    """Lift a frame's pixels into clouds.

    Args:
        arrays: `depth` (H, W) in [m], 0 or NaN where there is none; `K` (3, 3); a mask `label`,
            `segmap` or `seg` (H, W) with 0 = background, or a stack `masks` (N, H, W) of one mask per
            object, which `masks[i]` makes label i + 1; optional `rgb` (H, W, 3), `table_plane` (4,),
            `up` (3,), `fixed` (labels), `robot_base` and `pose_camera_to_world` (4, 4). `names` gives the
            labels names: text (M,), `names[i]` for label i from the background's 0 on; or, with
            whole numbers `ids` (M,) beside it, `names[k]` for label `ids[k]`. A label without a name, or
            with an empty one, is named by its number. `masses`
            {label: kg} and `friction` {label: coefficient} are JSON text.

    Returns:
        What the frame says, in the camera's frame unless it gives `pose_camera_to_world`.

    Raises:
        InvalidInput: If a part is missing, the parts do not fit together, or an object has no depth.
    """
    image, names, mask = image_from_rgbd(arrays)
    clouds = image.clouds()
    for name, pixels in image.pixels().items():
        if name not in clouds:
            raise InvalidInput(
                f"object {name!r} has {pixels} pixels in {mask} and no depth in any of them: "
                "its cloud is empty; set them to 0 (background) or give their depth"
            )
    if not clouds:
        raise InvalidInput(f"{mask} is 0 everywhere: expected labels from 1 on, one per object")
    return Parts(
        clouds=dict(clouds),
        fixed=fixed_labels(arrays, names),
        up=arrays.get("up"),
        viewpoints=image.viewpoint,
        table_plane=arrays.get("table_plane"),
        robot_base=arrays.get("robot_base"),
        images=(image,),
        masses=amounts_in(arrays, "masses"),
        friction=amounts_in(arrays, "friction"),
        background=image.background(),
        notes=ignored(arrays, (*_KEYS, *NAMING, *SPECIAL, mask)),
    )


def image_from_rgbd(arrays: Mapping[str, Array]) -> tuple[DepthImage, dict[int, str], str]:
    """Read the picture of a frame.

    Args:
        arrays: As for `parts_from_rgbd`.

    Returns:
        The picture, the names of its labels, and which array is the mask.

    Raises:
        InvalidInput: If a part is missing, or the parts do not fit together.
    """
    given = [key for key in (*MASK_KEYS, STACK_KEY) if key in arrays]
    if STACK_KEY in given and len(given) > 1:
        raise InvalidInput(f"the RGB-D frame has {' and '.join(given)}: expected one mask, so leave one out")
    mask = given[0] if given else None
    absent = [key for key in ("depth", "K") if key not in arrays] + (["label"] if mask is None else [])
    if mask is None or absent:
        raise InvalidInput(
            f"the RGB-D frame has no {' and no '.join(absent)}, only {sorted(arrays)}: "
            "expected depth (H, W) in metres, K (3, 3) and a mask label (or segmap or seg) (H, W)"
        )
    pose = arrays.get("pose_camera_to_world", np.eye(4))
    label = _labels_of(arrays[mask]) if mask == STACK_KEY else arrays[mask]
    names = label_names(arrays, label)
    image = DepthImage(arrays["depth"], arrays["K"], label, pose, names, arrays.get("rgb"))
    return image, names, mask


def _labels_of(masks: Array) -> Array:
    """One mask (H, W) of labels from 1 on of a stack (N, H, W) of true and false.

    Raises:
        InvalidInput: If it is no such stack, a mask is empty, or two of them share pixels.
    """
    if masks.ndim != 3 or not (masks.dtype.kind == "b" or np.isin(masks, (0, 1)).all()):
        raise InvalidInput(
            f"masks is {masks.shape} of {masks.dtype}: expected true or false per object and pixel, (N, H, W)"
        )
    stack = masks.astype(np.bool_)
    count = stack.sum(axis=0)
    if (count > 1).any():
        shared = [int(k) for k in np.flatnonzero(stack[:, count > 1].any(axis=1))]
        raise InvalidInput(
            f"masks {shared} share {int((count > 1).sum())} pixels: expected each pixel in one mask at most; "
            "leave it in the object that is in front"
        )
    empty = [int(k) for k in np.flatnonzero(~stack.any(axis=(1, 2)))]
    if empty:
        raise InvalidInput(f"masks {empty} are empty: expected pixels of an object in each; leave them out")
    return (stack * np.arange(1, len(stack) + 1)[:, None, None]).sum(axis=0)
