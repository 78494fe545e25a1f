"""Other people's grasps, GraspNet, Contact-GraspNet, isaac_grasp and plain poses, in our tool frame."""

import io
import zipfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from topple.topology.arrays import FloatArray, frozen
from topple.topology.errors import InvalidInput

HAND_TO_PADS = (
    0.1034  # Panda hand's origin to the middle between its pads, the frame of two of the formats [m]
)
PAD_HALF = 0.01  # half a pad's length: GraspNet's depth reaches to the finger tips [m]
GRASPNET_COLUMNS = 17  # score, width, height, depth, rotation (9), translation (3), object


@dataclass(frozen=True, eq=False)
class ForeignGrasps:
    """Grasps as another pipeline proposes them.

    Attributes:
        poses_tool_to_source: (N, 4, 4) poses of the tool frame (z approach, y closing, origin between the
            pads) in the frame the file is in: a camera, an object or the world.
        scores: (N,) as given; larger is better.
        widths: (N,) openings [m]; nan where the file has none.
        source: Name of the format.
    """

    poses_tool_to_source: FloatArray
    scores: FloatArray
    widths: FloatArray
    source: str

    def __post_init__(self) -> None:
        for name in ("poses_tool_to_source", "scores", "widths"):
            object.__setattr__(self, name, frozen(getattr(self, name)))

    def __len__(self) -> int:
        """How many."""
        return len(self.scores)


def read_grasps(path: str | Path) -> ForeignGrasps:
    """Read a file of grasps, told by its content.

    Args:
        path: `.npy` with 17 columns (GraspNet) or 4x4 poses; `.npz` of Contact-GraspNet (`pred_grasps_cam`,
            `scores`) or with `poses` and `scores`; `.yaml` of isaac_grasp.

    Returns:
        The grasps.

    Raises:
        InvalidInput: The file is none of these; the message says what was found and what was expected.
    """
    path = Path(path)
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InvalidInput(f"{path}: cannot be read: {error.strerror}") from error
    if path.suffix in (".yaml", ".yml"):
        return _isaac(data, str(path))
    try:
        if data[:4] == b"PK\x03\x04":
            return _npz(data, str(path))
        if data[:6] == b"\x93NUMPY":
            return grasps_from_array(_plain(np.load(io.BytesIO(data), allow_pickle=False)), str(path))
    except (ValueError, OSError, zipfile.BadZipFile) as error:
        raise InvalidInput(f"{path}: is no file of grasps: {error}") from error
    raise InvalidInput(f"{path}: is no file of grasps: expected .npy, .npz or an isaac_grasp .yaml")


def grasps_from_array(
    array: FloatArray, name: str = "grasps", scores: Sequence[float] | FloatArray | None = None
) -> ForeignGrasps:
    """Take grasps from an array.

    Args:
        array: (N, 17) rows of GraspNet, or (N, 4, 4) poses of the tool frame.
        name: For messages.
        scores: (N,) for poses; 1 where not given.

    Returns:
        The grasps.

    Raises:
        InvalidInput: The shape is neither, or a pose is no rigid transform in metres.
    """
    array = np.asarray(array, dtype=np.float64)
    if array.ndim == 2 and array.shape[1] == GRASPNET_COLUMNS:
        poses = _poses(array[:, 4:13].reshape(-1, 3, 3)[:, :, [2, 1, 0]], array[:, 13:16])
        # GraspNet: x approaches, y closes; a right-handed frame needs the third axis turned round
        poses[:, :3, 0] *= -1.0
        poses[:, :3, 3] += poses[:, :3, 2] * (array[:, 3:4] - PAD_HALF)
        return _checked(ForeignGrasps(poses, array[:, 0], array[:, 1], "graspnet"), name)
    if array.ndim == 3 and array.shape[1:] == (4, 4):
        count = len(array)
        given = np.ones(count) if scores is None else np.asarray(scores, dtype=np.float64)
        if given.shape != (count,):
            raise InvalidInput(
                f"{name}: {count} grasps but scores of shape {given.shape}: expected ({count},)"
            )
        return _checked(ForeignGrasps(array, given, np.full(count, np.nan), "poses"), name)
    raise InvalidInput(f"{name}: has shape {array.shape}: expected (N, 17) of GraspNet or (N, 4, 4) poses")


def _npz(data: bytes, name: str) -> ForeignGrasps:
    with np.load(io.BytesIO(data), allow_pickle=False) as archive:
        keys = set(archive.files)
        try:
            if "pred_grasps_cam" in keys:
                poses = _plain(archive["pred_grasps_cam"]).reshape(-1, 4, 4)
                scores = _plain(archive["scores"]).reshape(-1) if "scores" in keys else np.ones(len(poses))
                turned = _poses(poses[:, :3, [1, 0, 2]] * [-1.0, 1.0, 1.0], poses[:, :3, 3])
                turned[:, :3, 3] += (
                    turned[:, :3, 2] * HAND_TO_PADS
                )  # x closes in the Panda's hand frame there
                widths = np.full(len(poses), np.nan)
                return _checked(ForeignGrasps(turned, scores, widths, "contact_graspnet"), name)
            if "poses" in keys:
                scores = _plain(archive["scores"]) if "scores" in keys else None
                return grasps_from_array(_plain(archive["poses"]), name, scores)
        except ValueError as error:
            if "pickle" in str(error).lower():
                raise InvalidInput(
                    f"{name}: holds pickled objects, which are never loaded: save plain arrays instead, "
                    "pred_grasps_cam=np.concatenate(list(pred_grasps_cam.values())) and scores likewise"
                ) from error
            raise
    raise InvalidInput(
        f"{name}: has {', '.join(sorted(keys))}: expected pred_grasps_cam or poses, and scores"
    )


def _isaac(data: bytes, name: str) -> ForeignGrasps:
    try:
        import yaml  # pyright: ignore[reportMissingModuleSource]
    except ImportError as error:
        raise InvalidInput(f"{name}: reading isaac_grasp files needs PyYAML: pip install pyyaml") from error
    try:
        content: Any = yaml.safe_load(data)
    except yaml.YAMLError as error:
        raise InvalidInput(f"{name}: is no YAML: {error}") from error
    if not isinstance(content, dict) or content.get("format") != "isaac_grasp":
        raise InvalidInput(f"{name}: is no grasp file: expected `format: isaac_grasp`")
    entries: Any = content.get("grasps") or {}
    poses, scores = np.tile(np.eye(4), (len(entries), 1, 1)), np.ones(len(entries))
    for index, (key, entry) in enumerate(entries.items()):
        try:
            w, (x, y, z) = float(entry["orientation"]["w"]), entry["orientation"]["xyz"]
            rotation = _rotation(np.array([float(x), float(y), float(z), w]))
            poses[index, :3, :3] = rotation
            poses[index, :3, 3] = (
                np.array(entry["position"], dtype=np.float64) + HAND_TO_PADS * rotation[:, 2]
            )
            scores[index] = float(entry.get("confidence", 1.0))
        except (KeyError, TypeError, ValueError) as error:
            raise InvalidInput(
                f"{name}: grasp {key!r} needs position [x, y, z] and orientation {{w, xyz}}: {error}"
            ) from error
    return _checked(ForeignGrasps(poses, scores, np.full(len(entries), np.nan), "isaac_grasp"), name)


def _rotation(quaternion: FloatArray) -> FloatArray:
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_quat(quaternion).as_matrix(), dtype=np.float64)


def _plain(array: Any) -> FloatArray:
    return np.asarray(array, dtype=np.float64)


def _poses(rotations: FloatArray, places: FloatArray) -> FloatArray:
    poses = np.tile(np.eye(4), (len(places), 1, 1))
    poses[:, :3, :3], poses[:, :3, 3] = rotations, places
    return poses


def _checked(grasps: ForeignGrasps, name: str) -> ForeignGrasps:
    """Refuse what is no rigid transform in metres, naming the first bad one."""
    checks: list[tuple[str, Callable[[FloatArray], bool]]] = [
        ("is not finite", lambda pose: bool(np.isfinite(pose).all())),
        (
            "is no rigid transform: its last row is not 0 0 0 1",
            lambda pose: bool(np.allclose(pose[3], [0, 0, 0, 1])),
        ),
        ("is no rotation", lambda pose: bool(np.abs(pose[:3, :3] @ pose[:3, :3].T - np.eye(3)).max() < 1e-2)),
        ("mirrors: its frame is left-handed", lambda pose: float(np.linalg.det(pose[:3, :3])) > 0),
        (
            "is over 20 m away: expected metres, not millimetres",
            lambda pose: bool(np.abs(pose[:3, 3]).max() < 20),
        ),
    ]
    for index, pose in enumerate(grasps.poses_tool_to_source):
        for words, holds in checks:
            if not holds(pose):
                raise InvalidInput(f"{name}: grasp {index} {words}")
    return grasps
