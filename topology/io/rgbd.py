"""An RGB-D frame: depth, intrinsic matrix and a mask whose labels are the objects' names."""

from collections.abc import Mapping

import numpy as np

from topple.topology.errors import InvalidInput
from topple.topology.image import DepthImage
from topple.topology.io.archive import MASK_KEYS, Array
from topple.topology.io.assemble import Parts
from topple.topology.io.clouds import names_in


def parts_from_rgbd(arrays: Mapping[str, Array]) -> Parts:
    """Lift a frame's pixels into clouds.

    Args:
        arrays: `depth` (H, W) in [m], 0 or NaN where there is none; `K` (3, 3); a mask `label`,
            `segmap` or `seg` (H, W) with 0 = background; optional `rgb` (H, W, 3), `table_plane` (4,),
            `up` (3,), `fixed` (labels), `robot_base` and `pose_camera_to_world` (4, 4).

    Returns:
        What the frame says, in the camera's frame unless it gives `pose_camera_to_world`.

    Raises:
        InvalidInput: If a part is missing, the parts do not fit together, or an object has no depth.
    """
    mask = next((key for key in MASK_KEYS if key in arrays), None)
    absent = [key for key in ("depth", "K") if key not in arrays] + (["label"] if mask is None else [])
    if mask is None or absent:
        raise InvalidInput(
            f"the RGB-D frame has no {' and no '.join(absent)}, only {sorted(arrays)}: "
            "expected depth (H, W) in metres, K (3, 3) and a mask label (or segmap or seg) (H, W)"
        )
    pose = arrays.get("pose_camera_to_world", np.eye(4))
    image = DepthImage(arrays["depth"], arrays["K"], arrays[mask], pose, rgb=arrays.get("rgb"))
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
        fixed=names_in(arrays["fixed"]) if "fixed" in arrays else [],
        up=arrays.get("up"),
        viewpoints=image.viewpoint,
        table_plane=arrays.get("table_plane"),
        robot_base=arrays.get("robot_base"),
        images=(image,),
    )
