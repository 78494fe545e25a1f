"""Grasps as numpy stores them: `.npy` of GraspNet, `.npz` of Contact-GraspNet, plain poses in either."""

import io
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from topple.planner.grasp.foreign import (
    ForeignGrasps,
    check_grasps,
    grasps_from_array,
    label_of,
    plain,
    poses_of,
)
from topple.planner.grasp.stored import MOST_BYTES, Key, Stored, read_stored
from topple.planner.grasp.tolerances import HAND_TO_PADS
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput
from topple.topology.io.limits import open_file, read_bytes

READ = {"pred_grasps_cam", "gripper_openings", "poses", "scores"}  # of an .npz
_NPZ, _NPY = b"PK\x03\x04", b"\x93NUMPY"


def reads(path: Path) -> bool:
    """Tell one by how it begins."""
    with open_file(path, str(path)) as file:
        return file.read(len(_NPY)).startswith((_NPZ, _NPY))


def read(path: Path) -> ForeignGrasps:
    """Read it.

    Raises:
        InvalidInput: It holds something else, or a broken array.
        OSError: It cannot be read.
    """
    data = read_bytes(path, str(path))
    if data.startswith(_NPZ):
        return _npz(data, str(path))
    stored = read_stored(data, str(path))
    if isinstance(stored, dict):
        raise InvalidInput(f"{path}: holds a dict, expected (N, 17) of GraspNet or (N, 4, 4) poses")
    return grasps_from_array(stored, str(path))


def _npz(data: bytes, name: str) -> ForeignGrasps:
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            sizes = {Path(one.filename).stem: one for one in archive.infolist()}
            found = {key: _member(archive, sizes[key], name) for key in READ & sizes.keys()}
    except InvalidInput:
        raise
    except Exception as error:  # zipfile and its codecs fail on altered bytes in many ways
        raise InvalidInput(f"{name}: is no file of grasps: {error}") from error
    if "pred_grasps_cam" in found:
        return _contact_graspnet(found, name)
    if "poses" in found:
        poses, scores = found["poses"], found.get("scores")
        if isinstance(poses, dict) or isinstance(scores, dict):
            raise InvalidInput(f"{name}: poses and scores are dicts: expected arrays (N, 4, 4) and (N,)")
        return grasps_from_array(poses, name, scores)
    raise InvalidInput(
        f"{name}: has {', '.join(sorted(sizes)) or 'nothing'}: expected pred_grasps_cam or poses, and scores"
    )


def _member(archive: zipfile.ZipFile, member: zipfile.ZipInfo, name: str) -> Stored:
    if member.file_size > MOST_BYTES:
        size = f"{member.file_size / 1e6:.0f} MB: expected at most {MOST_BYTES / 1e6:.0f} MB"
        raise InvalidInput(f"{name}: {member.filename} has {size}")
    return read_stored(archive.read(member), f"{name}: {member.filename}")


def _contact_graspnet(found: Mapping[str, Stored], name: str) -> ForeignGrasps:
    """Poses of the Panda's hand in the camera's frame, closing along their x, by segment or all in one."""
    segments = _by_segment(found["pred_grasps_cam"])
    others = {key: _by_segment(found[key]) for key in ("scores", "gripper_openings") if key in found}
    poses, labels = [np.empty((0, 4, 4))], list[str]()
    values: dict[str, list[FloatArray]] = {key: [np.empty(0)] for key in others}
    for segment, one in segments.items():
        where = name if segment == -1 else f"{name}: segment {segment}"
        given = (
            plain(one, f"{where}: pred_grasps_cam").reshape(-1, 4, 4) if one.size == 0 else plain(one, where)
        )
        if given.ndim != 3 or given.shape[1:] != (4, 4):
            raise InvalidInput(f"{where}: pred_grasps_cam has shape {given.shape}: expected (N, 4, 4)")
        poses.append(given)
        labels += [label_of(segment, f"{name}: a segment")] * len(given)
        for key, by_segment in others.items():
            if segment not in by_segment:
                raise InvalidInput(f"{where}: has grasps but no {key}: expected ({len(given)},)")
            value = plain(by_segment[segment], f"{where}: {key}")
            if value.shape not in ((len(given),), (len(given), 1)):
                raise InvalidInput(
                    f"{where}: {len(given)} grasps but {key} of shape {value.shape}: expected ({len(given)},)"
                )
            values[key].append(value.reshape(-1))
    hands = np.concatenate(poses)
    turned = poses_of(hands[:, :3, [1, 0, 2]] * [-1.0, 1.0, 1.0], hands[:, :3, 3])
    turned[:, :3, 3] += turned[:, :3, 2] * HAND_TO_PADS  # x closes in the Panda's hand frame there
    turned[:, 3] = hands[:, 3]
    scores = np.concatenate(values["scores"]) if "scores" in values else np.ones(len(hands))
    widths = np.full(len(hands), np.nan)
    if "gripper_openings" in values:
        widths = np.concatenate(values["gripper_openings"])
    return check_grasps(ForeignGrasps(turned, scores, widths, "contact_graspnet", tuple(labels)), name)


def _by_segment(stored: Stored) -> dict[Key, Any]:
    """Arrays by segment; one array belongs to no segment, -1."""
    return dict(stored) if isinstance(stored, dict) else {-1: stored}
