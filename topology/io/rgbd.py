"""An RGB-D frame: depth, intrinsic matrix and a mask whose labels are the objects' names."""

from collections.abc import Collection, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from topple.topology.base.arguments import checked_arguments
from topple.topology.base.checks import Names, as_names, numeric
from topple.topology.base.errors import InvalidInput
from topple.topology.io.archive import MASK_KEYS, STACK_KEY, Array
from topple.topology.io.assemble import Parts, assemble
from topple.topology.io.clouds import amounts_in, note_unused
from topple.topology.io.labels import NAMING, fixed_labels, label_names, label_of_stack
from topple.topology.scene.scene import Scene
from topple.topology.scene.write import SPECIAL
from topple.topology.views.image import DepthImage, check_depth

_KEYS = ("depth", "K", "rgb", "pose_camera_to_world", "masses", "friction")


def parts_from_rgbd(arrays: Mapping[str, Array]) -> Parts:
    """Lift a frame's pixels into clouds.

    Args:
        arrays: `depth` (H, W) in [m], 0 or NaN where there is none; `K` (3, 3); a mask `label`,
            `segmap` or `seg` (H, W) with 0 = background, or a stack `masks` (N, H, W) of one mask per
            object, which `masks[i]` makes label i + 1 (of two that overlap the smaller one has the pixels);
            optional `rgb` (H, W, 3), `table_plane` (4,),
            `up` (3,), `fixed` (labels), `robot_base` and `pose_camera_to_world` (4, 4). `names` gives the
            labels names: text (M,), `names[i]` for label i from the background's 0 on; or, with
            whole numbers `ids` (M,) beside it, `names[k]` for label `ids[k]`; of a stack one per
            mask. A label without a name, or with an empty one, is named by its number. `masses` {label: kg}
            and `friction` {label: coefficient} are JSON text.

    Returns:
        What the frame says, in the camera's frame unless it gives `pose_camera_to_world`.

    Raises:
        InvalidInput: If a part is missing, the parts do not fit together, or an object has no depth.
    """
    image, names, mask, notes = image_from_rgbd(arrays)
    clouds = image.clouds()
    check_depth([image], clouds, 1)
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
        notes=[*notes, *note_unused(arrays, (*_KEYS, *NAMING, *SPECIAL, mask))],
    )


def image_from_rgbd(arrays: Mapping[str, Array]) -> tuple[DepthImage, dict[int, str], str, list[str]]:
    """Read the picture of a frame.

    Args:
        arrays: As for `parts_from_rgbd`.

    Returns:
        The picture, the names of its labels, which array is the mask, and what is to be said of it.

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
    label, notes = arrays[mask], list[str]()
    if mask == STACK_KEY:
        stack = as_stack(label)
        if len(arrays.get("names", ())) == len(stack) and "ids" not in arrays:
            ids: Array = np.arange(1, len(stack) + 1)
            arrays = {**arrays, "ids": ids}
        known = label_names(arrays, np.arange(len(stack) + 1))
        label, notes = label_of_stack(stack, [known.get(k, str(k)) for k in range(1, len(stack) + 1)])
    names = label_names(arrays, label)
    image = DepthImage(arrays["depth"], arrays["K"], label, pose, names, arrays.get("rgb"))
    return image, names, mask, notes


def as_stack(masks: Array) -> Array:
    """A stack (N, H, W) of true and false in an array; (N, 1, H, W) and 0 and 255 are taken as well.

    Raises:
        InvalidInput: If it is no such stack.
    """
    stack = masks[:, 0] if masks.ndim == 4 and masks.shape[1] == 1 else masks
    if stack.ndim != 3 or not len(stack) or not np.isin(stack, (0, max(int(stack.max()), 1))).all():
        raise InvalidInput(
            f"masks is {masks.shape} of {masks.dtype}: expected true or false per object and pixel, (N, H, W)"
        )
    return stack.astype(np.bool_)


@checked_arguments
def scene_from_rgbd(
    depth: ArrayLike,
    K: ArrayLike,
    masks: ArrayLike | Mapping[str, ArrayLike],
    names: Collection[str] | Mapping[int, str] = (),
    pose_camera_to_world: ArrayLike | None = None,
    *,
    fixed: Names = (),
    **more: ArrayLike,
) -> Scene:
    """Make a scene of a depth image and masks, as one of a file is made.

    Args:
        depth: (H, W) in [m], 0 or NaN where there is none.
        K: (3, 3) intrinsic matrix in pixels.
        masks: Labels (H, W) with 0 = background; a stack (N, H, W) of a mask per object, of which the smaller
            one has shared pixels; or {name: mask (H, W)}.
        names: Of a stack, one per mask; of labels {label: name}, or names[i] of label i from 0 on.
        pose_camera_to_world: (4, 4); the camera's own frame where None.
        fixed: Names of what never moves; where there is none the table is looked for.
        **more: Other arrays of such a file, `up` and `table_plane` among them (`parts_from_rgbd`).

    Returns:
        The scene.

    Raises:
        InvalidInput: If the parts do not fit together, or an object has no depth.
        UnknownObject: If `fixed` names an object that no mask shows.

    Examples:
        >>> found = scene_from_rgbd(depth, K, mask)
        >>> found.names, len(found.clouds["1"])
        (('1', 'table'), 400)
    """
    if isinstance(masks, Mapping):
        names, masks = list(masks), [np.asarray(mask) for mask in masks.values()]
    stack = numeric(masks, "masks")
    arrays: dict[str, Any] = {
        "depth": numeric(depth, "depth"),
        "K": numeric(K, "K"),
        "label" if stack.ndim == 2 else STACK_KEY: stack,
    }
    if isinstance(names, Mapping):
        arrays["ids"], names = np.array(list(names), dtype=np.int64), list(names.values())
    if isinstance(names, (set, frozenset)):
        raise InvalidInput("names is a set, which has no order: expected a list, a name for each mask")
    if names := as_names(names):
        arrays["names"] = np.array(names, dtype=np.str_)
    if pose_camera_to_world is not None:
        arrays["pose_camera_to_world"] = numeric(pose_camera_to_world, "pose_camera_to_world")
    arrays |= {key: np.asarray(value) for key, value in more.items()}
    return assemble(parts_from_rgbd(arrays), as_names(fixed), None)
