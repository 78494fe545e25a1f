"""Files of isaac_grasp: YAML with a position and a quaternion for each grasp."""

from pathlib import Path
from typing import Any

import numpy as np

from topple.planner.grasp.foreign import ForeignGrasps, check_grasps
from topple.planner.grasp.tolerances import HAND_TO_PADS
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput, NotInstalled
from topple.topology.io.limits import read_bytes


def reads(path: Path) -> bool:
    """Tell one by its name."""
    return path.suffix in (".yaml", ".yml")


def read(path: Path) -> ForeignGrasps:
    """Read it: poses of the Panda's hand, in the frame of the object.

    Raises:
        InvalidInput: It is no YAML, or a grasp has no pose.
        NotInstalled: PyYAML is not there.
        OSError: It cannot be read.
    """
    name = str(path)
    try:
        import yaml
    except ImportError as error:
        raise NotInstalled(f"{name}: isaac_grasp files need PyYAML", "yaml") from error
    try:
        content: Any = yaml.safe_load(read_bytes(path, name))
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        raise InvalidInput(f"{name}: is no YAML: {error}") from error
    if not isinstance(content, dict) or content.get("format") != "isaac_grasp":
        raise InvalidInput(f"{name}: is no grasp file: expected `format: isaac_grasp`")
    entries: Any = content.get("grasps") or {}
    if not isinstance(entries, dict):
        raise InvalidInput(
            f"{name}: its grasps are no map: expected name: {{position, orientation, confidence}}"
        )
    poses, scores = np.tile(np.eye(4), (len(entries), 1, 1)), np.ones(len(entries))
    for index, (key, entry) in enumerate(entries.items()):
        try:
            w, (x, y, z) = float(entry["orientation"]["w"]), entry["orientation"]["xyz"]
            rotation = _rotation(np.array([float(x), float(y), float(z), w]))
            (x, y, z) = entry["position"]
            poses[index, :3, :3] = rotation
            poses[index, :3, 3] = np.array([float(x), float(y), float(z)]) + HAND_TO_PADS * rotation[:, 2]
            scores[index] = float(entry.get("confidence", 1.0))
        except (KeyError, TypeError, ValueError, AttributeError) as error:
            raise InvalidInput(
                f"{name}: grasp {key!r} needs position [x, y, z] and orientation {{w, xyz}}: {error}"
            ) from error
    return check_grasps(ForeignGrasps(poses, scores, np.full(len(entries), np.nan), "isaac_grasp"), name)


def _rotation(quaternion: FloatArray) -> FloatArray:
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_quat(quaternion).as_matrix(), dtype=np.float64)
