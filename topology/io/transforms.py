"""Where tf says that frames are, and labels of one camera laid onto the depth of another."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy import ndimage
from scipy.spatial.transform import Rotation

from topple.topology.base.arrays import FloatArray, IntArray
from topple.topology.base.errors import InvalidInput
from topple.topology.io.tolerances import SHORTEST
from topple.topology.views.image import DepthImage
from topple.topology.views.tolerances import STEP


def pose_in(transform: Any) -> FloatArray | None:
    """Read a transform of ROS.

    Returns:
        (4, 4), lengths in [m]; None where a number is not finite or the quaternion is zero, as tf2 has it.
    """
    turn, shift = transform.rotation, transform.translation
    quaternion, place = [turn.x, turn.y, turn.z, turn.w], [shift.x, shift.y, shift.z]
    if not np.isfinite([*quaternion, *place]).all() or np.linalg.norm(quaternion) < SHORTEST:
        return None
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_quat(quaternion).as_matrix()
    pose[:3, 3] = place
    return pose


def intrinsics_of(info: Any) -> FloatArray:
    """(3, 3) intrinsics of a CameraInfo of ROS 1 or 2."""
    return np.asarray(info.k if hasattr(info, "k") else info.K, dtype=np.float64).reshape(3, 3)


def to_root(frame: str, parents: Mapping[str, tuple[str, FloatArray]]) -> tuple[FloatArray, str]:
    """Follow a frame to the root that it hangs from.

    Args:
        frame: Its name.
        parents: Of each frame the parent, and its pose (4, 4) in that.

    Returns:
        The frame's pose (4, 4) in the root, and the root's name.

    Raises:
        InvalidInput: tf goes round in a circle.
    """
    pose, passed = np.eye(4), {frame}
    while frame in parents:
        frame, step = parents[frame]
        pose = step @ pose
        if frame in passed:
            raise InvalidInput(f"tf goes round in a circle through {frame!r}: expected a tree")
        passed.add(frame)
    return pose, frame


def labels_from(
    depth: FloatArray, K: FloatArray, label: IntArray, K_label: FloatArray, pose: FloatArray
) -> tuple[FloatArray, IntArray]:
    """Give the pixels of a depth camera the labels that another camera saw there.

    Args:
        depth: (H, W) in [m], 0 where there is none.
        K: (3, 3) of the depth camera.
        label: (h, w) of the other camera.
        K_label: (3, 3) of the other camera.
        pose: (4, 4) of the depth camera in the other one's frame.

    Returns:
        The depth without what the other camera could not see for what is in front, and its labels (H, W);
        0 beyond that one's picture.
    """
    image = DepthImage(depth, K, np.zeros(depth.shape, dtype=np.int64), pose)
    other = DepthImage(np.zeros(label.shape), K_label, label, np.eye(4))
    rows, columns = np.nonzero(image.depth)
    v, u, far, inside = other.pixels_of(image.lifted(rows, columns))
    pixels, there, far = (rows[inside], columns[inside]), (v[inside], u[inside]), far[inside]
    front = np.full(label.shape, np.inf)
    np.minimum.at(front, there, far)
    hidden = far > ndimage.minimum_filter(front, 3)[there] + STEP
    found, kept = np.zeros(depth.shape, dtype=np.int64), depth.copy()
    found[pixels] = np.where(hidden, 0, label[there])
    kept[pixels] = np.where(hidden, 0.0, depth[pixels])
    return kept, found
