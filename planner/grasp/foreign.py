"""Other people's grasps, GraspNet, Contact-GraspNet, isaac_grasp and plain poses, in our tool frame."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from topple.planner.grasp.stored import Key
from topple.planner.grasp.tolerances import PAD_HALF
from topple.topology.base.arguments import checked_arguments
from topple.topology.base.arrays import FloatArray, freeze
from topple.topology.base.errors import InvalidInput
from topple.topology.base.plugins import Table, check_kind
from topple.topology.base.values import ByValue
from topple.topology.io.limits import open_file

GRASPNET_COLUMNS = 17  # score, width, height, depth, rotation (9), translation (3), object


@checked_arguments
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

    Examples:
        >>> len(grasps_from_array(np.eye(4)[None]))
        1
    """

    poses_tool_to_source: FloatArray
    scores: FloatArray
    widths: FloatArray
    source: str
    labels: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for name in ("poses_tool_to_source", "scores", "widths"):
            object.__setattr__(self, name, freeze(getattr(self, name)))

    def __len__(self) -> int:
        """How many."""
        return len(self.scores)


class GraspReader(Protocol):
    """A format of grasps: a module or an object with two functions."""

    def reads(self, path: Path) -> bool:
        """Whether the file, which exists, is of this format, complete or not."""
        ...

    def read(self, path: Path) -> ForeignGrasps:
        """Its grasps.

        Raises:
            InvalidInput: If it is broken; one line with what was expected.
            OSError: If it cannot be read.
        """
        ...


GRASP_READERS: Table[GraspReader] = Table(
    "topple.grasps",
    "reader of grasps",
    {"isaac_grasp": "topple.planner.grasp.isaac", "arrays": "topple.planner.grasp.stored_grasps"},
)
"""Every format by its name, asked in this order after those of other packages."""


@checked_arguments
def read_grasps(path: str | Path) -> ForeignGrasps:
    """Read a file of grasps, told by its content.

    Args:
        path: `.npy` with 17 columns (GraspNet) or 4x4 poses; `.npz` as Contact-GraspNet writes it
            (`pred_grasps_cam`, `scores`, `gripper_openings`: dicts by segment, or arrays) or with `poses` and
            `scores`; `.yaml` of isaac_grasp. Pickled dicts are read without running anything in them. Other
            packages add more (`GRASP_READERS`).

    Returns:
        The grasps.

    Raises:
        InvalidInput: The file is none of these; the message says what was found and what was expected.

    Examples:
        >>> np.save("grasps.npy", np.eye(4)[None])
        >>> len(read_grasps("grasps.npy"))
        1
    """
    path = Path(path)
    try:
        with open_file(path, str(path)):  # a pipe would be waited for
            pass
        if (found := GRASP_READERS.first(lambda reader: reader.reads(path))) is not None:
            # overflow: of what is then refused as no rigid transform
            with GRASP_READERS.blame(found[0]), np.errstate(over="ignore", invalid="ignore"):
                return check_kind(found[1].read(path), ForeignGrasps)
    except OSError as error:
        raise InvalidInput(f"{path}: cannot be read: {error.strerror}") from error
    raise InvalidInput(f"{path}: is no file of grasps: expected .npy, .npz or an isaac_grasp .yaml")


@checked_arguments
def grasps_from_array(
    array: FloatArray,
    name: str = "grasps",
    scores: Sequence[float] | FloatArray | None = None,
    widths: Sequence[float] | FloatArray | None = None,
) -> ForeignGrasps:
    """Take grasps from an array.

    Args:
        array: (N, 17) rows of GraspNet, or (N, 4, 4) poses of the tool frame.
        name: For messages.
        scores: (N,), larger is better; where None those of GraspNet, 1 for poses.
        widths: (N,) openings of the hand [m]; where None those of GraspNet, unknown for poses.

    Returns:
        The grasps.

    Raises:
        InvalidInput: The shape is neither, or a pose is no rigid transform in metres.

    Examples:
        >>> grasps_from_array(np.eye(4)[None], scores=[0.7]).scores
        array([0.7])
    """

    def take(values: Any, default: FloatArray) -> FloatArray:
        return default if values is None else plain(values, name)

    array = plain(array, name)
    if array.ndim == 2 and array.shape[1] == GRASPNET_COLUMNS:
        poses = poses_of(array[:, 4:13].reshape(-1, 3, 3)[:, :, [2, 1, 0]], array[:, 13:16])
        # GraspNet: x approaches, y closes; a right-handed frame needs the third axis turned round
        poses[:, :3, 0] *= -1.0
        poses[:, :3, 3] += poses[:, :3, 2] * (array[:, 3:4] - PAD_HALF)
        labels = tuple(
            label_of(number, f"{name}: object of grasp {row}")
            for row, number in enumerate(array[:, 16].tolist())
        )
        found = ForeignGrasps(poses, take(scores, array[:, 0]), take(widths, array[:, 1]), "graspnet", labels)
        return check_grasps(found, name)
    if array.ndim == 3 and array.shape[1:] == (4, 4):
        found = ForeignGrasps(
            array, take(scores, np.ones(len(array))), take(widths, np.full(len(array), np.nan)), "poses"
        )
        return check_grasps(found, name)
    raise InvalidInput(f"{name}: has shape {array.shape}: expected (N, 17) of GraspNet or (N, 4, 4) poses")


def label_of(number: Key, where: str) -> str:
    """Name a segment or object: its number as text, "" for a negative one: none.

    Raises:
        InvalidInput: It is no whole number.
    """
    if isinstance(number, str):
        return number
    if not float(number).is_integer():
        raise InvalidInput(f"{where} is {number}: expected a whole number, -1 for none")
    return str(int(number)) if number >= 0 else ""


def plain(array: Any, name: str) -> FloatArray:
    """Any array as one of numbers.

    Raises:
        InvalidInput: It holds anything else.
    """
    try:
        return np.asarray(array, dtype=np.float64)
    except (ValueError, TypeError) as error:
        raise InvalidInput(f"{name}: expected numbers: {error}") from error


def poses_of(rotations: FloatArray, places: FloatArray) -> FloatArray:
    """(N, 4, 4) of rotations (N, 3, 3) and places (N, 3) [m]."""
    poses = np.tile(np.eye(4), (len(places), 1, 1))
    poses[:, :3, :3], poses[:, :3, 3] = rotations, places
    return poses


def check_grasps(grasps: ForeignGrasps, name: str) -> ForeignGrasps:
    """Refuse what is no rigid transform in metres, or has no score, naming the first bad one.

    Args:
        grasps: What was read.
        name: Of the file.

    Returns:
        The same grasps.

    Raises:
        InvalidInput: One of them is no grasp.
    """
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
