"""Other people's grasps, GraspNet, Contact-GraspNet, isaac_grasp and plain poses, in our tool frame."""

import io
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from topple.planner.grasp.stored import MOST_BYTES, Key, Stored, read_stored
from topple.planner.grasp.tolerances import HAND_TO_PADS, PAD_HALF
from topple.topology.arrays import FloatArray, frozen
from topple.topology.errors import InvalidInput
from topple.topology.values import ByValue

READ = {"pred_grasps_cam", "gripper_openings", "poses", "scores"}  # of an .npz
GRASPNET_COLUMNS = 17  # score, width, height, depth, rotation (9), translation (3), object


@dataclass(frozen=True, eq=False)
class ForeignGrasps(ByValue):
    """Grasps as another pipeline proposes them.

    Attributes:
        poses_tool_to_source: (N, 4, 4) poses of the tool frame (z approach, y closing, origin between the
            pads) in the frame the file is in: a camera, an object or the world.
        scores: (N,) as given; larger is better.
        widths: (N,) openings [m]; nan where the file has none.
        source: Name of the format.
        labels: (N,) what the file calls the things they hold, its number for them as text, "" where it names
            none; empty where the format names nothing.
    """

    poses_tool_to_source: FloatArray
    scores: FloatArray
    widths: FloatArray
    source: str
    labels: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for name in ("poses_tool_to_source", "scores", "widths"):
            object.__setattr__(self, name, frozen(getattr(self, name)))

    def __len__(self) -> int:
        """How many."""
        return len(self.scores)


def read_grasps(path: str | Path) -> ForeignGrasps:
    """Read a file of grasps, told by its content.

    Args:
        path: `.npy` with 17 columns (GraspNet) or 4x4 poses; `.npz` as Contact-GraspNet writes it
            (`pred_grasps_cam`, `scores`, `gripper_openings`: dicts by segment, or arrays) or with `poses` and
            `scores`; `.yaml` of isaac_grasp. Pickled dicts are read without running anything in them.

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
    with np.errstate(over="ignore", invalid="ignore"):  # of what is then refused as no rigid transform
        return _told_apart(data, path)


def _told_apart(data: bytes, path: Path) -> ForeignGrasps:
    if path.suffix in (".yaml", ".yml"):
        return _isaac(data, str(path))
    if data[:4] == b"PK\x03\x04":
        return _npz(data, str(path))
    if data[:6] == b"\x93NUMPY":
        stored = read_stored(data, str(path))
        if isinstance(stored, dict):
            raise InvalidInput(f"{path}: holds a dict, expected (N, 17) of GraspNet or (N, 4, 4) poses")
        return grasps_from_array(stored, str(path))
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
    array = _plain(array, name)
    if array.ndim == 2 and array.shape[1] == GRASPNET_COLUMNS:
        poses = _poses(array[:, 4:13].reshape(-1, 3, 3)[:, :, [2, 1, 0]], array[:, 13:16])
        # GraspNet: x approaches, y closes; a right-handed frame needs the third axis turned round
        poses[:, :3, 0] *= -1.0
        poses[:, :3, 3] += poses[:, :3, 2] * (array[:, 3:4] - PAD_HALF)
        labels = tuple(
            _label(number, f"{name}: object of grasp {row}")
            for row, number in enumerate(array[:, 16].tolist())
        )
        return _checked(ForeignGrasps(poses, array[:, 0], array[:, 1], "graspnet", labels), name)
    if array.ndim == 3 and array.shape[1:] == (4, 4):
        count = len(array)
        given = np.ones(count) if scores is None else _plain(scores, f"{name}: scores")
        return _checked(ForeignGrasps(array, given, np.full(count, np.nan), "poses"), name)
    raise InvalidInput(f"{name}: has shape {array.shape}: expected (N, 17) of GraspNet or (N, 4, 4) poses")


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
            _plain(one, f"{where}: pred_grasps_cam").reshape(-1, 4, 4)
            if one.size == 0
            else _plain(one, where)
        )
        if given.ndim != 3 or given.shape[1:] != (4, 4):
            raise InvalidInput(f"{where}: pred_grasps_cam has shape {given.shape}: expected (N, 4, 4)")
        poses.append(given)
        labels += [_label(segment, f"{name}: a segment")] * len(given)
        for key, by_segment in others.items():
            if segment not in by_segment:
                raise InvalidInput(f"{where}: has grasps but no {key}: expected ({len(given)},)")
            value = _plain(by_segment[segment], f"{where}: {key}")
            if value.shape not in ((len(given),), (len(given), 1)):
                raise InvalidInput(
                    f"{where}: {len(given)} grasps but {key} of shape {value.shape}: expected ({len(given)},)"
                )
            values[key].append(value.reshape(-1))
    hands = np.concatenate(poses)
    turned = _poses(hands[:, :3, [1, 0, 2]] * [-1.0, 1.0, 1.0], hands[:, :3, 3])
    turned[:, :3, 3] += turned[:, :3, 2] * HAND_TO_PADS  # x closes in the Panda's hand frame there
    turned[:, 3] = hands[:, 3]
    scores = np.concatenate(values["scores"]) if "scores" in values else np.ones(len(hands))
    widths = np.full(len(hands), np.nan)
    if "gripper_openings" in values:
        widths = np.concatenate(values["gripper_openings"])
    return _checked(ForeignGrasps(turned, scores, widths, "contact_graspnet", tuple(labels)), name)


def _by_segment(stored: Stored) -> dict[Key, Any]:
    """Arrays by segment; one array belongs to no segment, -1."""
    return dict(stored) if isinstance(stored, dict) else {-1: stored}


def _label(number: Key, where: str) -> str:
    """What a segment or object is called: its number as text, "" for a negative one: none."""
    if isinstance(number, str):
        return number
    if not float(number).is_integer():
        raise InvalidInput(f"{where} is {number}: expected a whole number, -1 for none")
    return str(int(number)) if number >= 0 else ""


def _isaac(data: bytes, name: str) -> ForeignGrasps:
    try:
        import yaml  # pyright: ignore[reportMissingModuleSource]
    except ImportError as error:
        raise InvalidInput(f"{name}: reading isaac_grasp files needs PyYAML: pip install pyyaml") from error
    try:
        content: Any = yaml.safe_load(data)
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
    return _checked(ForeignGrasps(poses, scores, np.full(len(entries), np.nan), "isaac_grasp"), name)


def _rotation(quaternion: FloatArray) -> FloatArray:
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_quat(quaternion).as_matrix(), dtype=np.float64)


def _plain(array: Any, name: str) -> FloatArray:
    try:
        return np.asarray(array, dtype=np.float64)
    except (ValueError, TypeError) as error:
        raise InvalidInput(f"{name}: expected numbers: {error}") from error


def _poses(rotations: FloatArray, places: FloatArray) -> FloatArray:
    poses = np.tile(np.eye(4), (len(places), 1, 1))
    poses[:, :3, :3], poses[:, :3, 3] = rotations, places
    return poses


def _checked(grasps: ForeignGrasps, name: str) -> ForeignGrasps:
    """Refuse what is no rigid transform in metres, or has no score, naming the first bad one."""
    count = len(grasps.poses_tool_to_source)
    for what, values in (("scores", grasps.scores), ("widths", grasps.widths)):
        if values.shape != (count,):
            raise InvalidInput(
                f"{name}: {count} grasps but {what} of shape {values.shape}: expected ({count},)"
            )
    poses = grasps.poses_tool_to_source
    rotations = poses[:, :3, :3]
    with np.errstate(all="ignore"):  # of what is no rotation
        square = rotations @ rotations.swapaxes(1, 2) - np.eye(3)
        holds = {
            "is not finite": np.isfinite(poses).all(axis=(1, 2)),
            "is no rigid transform: its last row is not 0 0 0 1": np.isclose(poses[:, 3], [0, 0, 0, 1]).all(
                axis=1
            ),
            "is no rotation": np.abs(square).max(axis=(1, 2), initial=0.0) < 1e-3,
            "mirrors: its frame is left-handed": np.linalg.det(rotations) > 0,
            "has no finite score": np.isfinite(grasps.scores),
            "has a negative or infinite width": np.isnan(grasps.widths)
            | ((grasps.widths >= 0) & np.isfinite(grasps.widths)),
            "is over 20 m away: expected metres, not millimetres": np.abs(poses[:, :3, 3]).max(
                axis=1, initial=0.0
            )
            < 20,
        }
    sound = np.all(list(holds.values()), axis=0)
    if not sound.all():
        index = int(np.argmin(sound))
        words = next(words for words, held in holds.items() if not np.asarray(held)[index])
        raise InvalidInput(f"{name}: grasp {index} {words}")
    return grasps
