"""One view of a camera: an RGB-D frame, with or without a mask."""

import os
from pathlib import Path

import numpy as np

from topple.topology.base.errors import InvalidInput
from topple.topology.io.archive import MASK_KEYS, STACK_KEY, read_arrays
from topple.topology.io.limits import allow
from topple.topology.io.rgbd import image_from_rgbd
from topple.topology.views.image import DepthImage


def read_view(path: str | os.PathLike[str], max_bytes: int | None = None) -> DepthImage:
    """Read what one camera saw.

    Args:
        path: An `.npz` or `.npy` with `depth` (H, W) in [m], `K` (3, 3), `pose_camera_to_world` (4, 4) as far
            as it is known, and perhaps a mask as a scene has it.
        max_bytes: What the file may unpack to; half a gigabyte where None.

    Returns:
        The view; its labels are 0 everywhere where there is no mask.

    Raises:
        InvalidInput: If it is no view or a broken one; names the file.
    """
    place = Path(path)
    try:
        with allow(max_bytes, None):
            arrays = read_arrays(place)
            if not any(key in arrays for key in (*MASK_KEYS, STACK_KEY)) and "depth" in arrays:
                arrays["label"] = np.zeros(arrays["depth"].shape, dtype=np.uint8)
            return image_from_rgbd(arrays)[0]
    except InvalidInput as error:
        raise InvalidInput(f"{os.fspath(path)}: {error}") from error
    except OSError as error:
        raise InvalidInput(f"{os.fspath(path)}: cannot be read: {error.strerror or error}") from error
