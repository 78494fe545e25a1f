"""A recording of ROS 1 or 2: frames of a depth camera with labels, or clouds with a label per point.

Conventions: REP 103 (z of fixed frames is up), REP 118 (depth in metres, or in millimetres as 16UC1).
"""

import struct
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput
from topple.topology.geometry.rigid import move_points
from topple.topology.io.assemble import Parts
from topple.topology.io.labelled import parts_from_labelled
from topple.topology.io.limits import check_size, open_file
from topple.topology.io.pcd import LABELS
from topple.topology.io.picture import read_picture
from topple.topology.io.recording import open_recording
from topple.topology.io.rgbd import parts_from_rgbd
from topple.topology.io.tolerances import APART, SAME_PLACE
from topple.topology.io.transforms import intrinsics_of, labels_from, pose_in, to_root

_MAGIC = (b"\x89MCAP0\r\n", b"SQLite format 3\x00", b"#ROSBAG V2.0")
_IMAGES = ("sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage")
_CLOUD, _INFO, _TF = "sensor_msgs/msg/PointCloud2", "sensor_msgs/msg/CameraInfo", "tf2_msgs/msg/TFMessage"
_ENCODINGS = {
    "mono8": "u1", "8UC1": "u1", "mono16": "u2", "16UC1": "u2", "16SC1": "i2", "32SC1": "i4", "32FC1": "f4",
}  # fmt: skip
_FIELDS = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 8: "f8"}  # of PointField
_COMPRESSED_DEPTH = struct.Struct("<iff")  # format and the two parameters of the quantised 32FC1
_FIXED, _BASES = ("world", "map", "odom"), ("base_link", "base_footprint", "base")
_SECOND = 1_000_000_000  # [ns]


def reads(path: Path) -> bool:
    """Tell one by how it begins, or a folder of ROS 2 by its metadata."""
    if path.is_dir():
        return (path / "metadata.yaml").is_file()
    with open_file(path, "the recording") as file:
        return file.read(16).startswith(_MAGIC)


def read(
    path: Path,
    depth: str | None = None,
    info: str | None = None,
    masks: str | None = None,
    image: int | None = None,
) -> Parts:
    """Read one frame.

    Args:
        path: The recording: a file, or the folder of ROS 2.
        depth: Topic of the depth images, or of clouds with a field `label`; the only one where None.
        info: Topic of the camera's intrinsics; the only one, or the one beside `depth`, where None.
        masks: Topic of the masks: whole numbers, 0 = background; the only one where None.
        image: Number of the frame, from 0 on; the first where None.

    Returns:
        What the frame says. Where tf knows the camera's place, in the frame at the root of tf, whose z is up
        if it is a fixed or a robot's frame; `robot_base` where tf has the base.

    Raises:
        InvalidInput: A topic is not there or of another type, a message is broken, or nothing fits together.
        NotInstalled: The package rosbags is not there.
    """
    with open_recording(path) as reader:
        bag = _Bag(reader)
        stream = bag.stream(depth, info, masks)
        moments = bag.moments(stream.depth)
        number = 0 if image is None else image
        if not 0 <= number < len(moments):
            raise InvalidInput(
                f"{stream.depth.topic} has {len(moments)} messages: there is no frame {number}"
            )
        parts = bag.frame(stream, moments[number])
    if image is None and len(moments) > 1:
        parts.notes.append(f"frame 0 of {len(moments)} is taken, the first: image=N takes another")
    return parts


def frames(
    path: Path, depth: str | None = None, info: str | None = None, masks: str | None = None
) -> Iterator[Parts]:
    """Read all frames, one after the other.

    Args:
        path: The recording.
        depth: As for `read`.
        info: As for `read`.
        masks: As for `read`.

    Yields:
        What each frame says.

    Raises:
        InvalidInput: As for `read`.
        NotInstalled: As for `read`.
    """
    with open_recording(path) as reader:
        bag = _Bag(reader)
        stream = bag.stream(depth, info, masks)
        for moment in bag.moments(stream.depth):
            yield bag.frame(stream, moment)


@dataclass(frozen=True)
class _Topic:
    topic: str
    kind: str
    connections: tuple[Any, ...]


@dataclass(frozen=True)
class _Stream:
    """The topics of one camera; a labelled cloud needs no others."""

    depth: _Topic
    info: _Topic | None = None
    labels: _Topic | None = None


_Moment = tuple[int, int]
"""When a message was taken and when it was recorded [ns]."""


class _Bag:
    def __init__(self, reader: Any) -> None:
        self._reader = reader
        self._moments: dict[str, list[_Moment]] = {}
        self._tf: list[tuple[int, str, str, FloatArray]] | None = None
        self._left_out: list[str] = []
        by_topic: dict[str, list[Any]] = {}
        for connection in reader.connections:
            by_topic.setdefault(connection.topic, []).append(connection)
        self._topics = {name: _Topic(name, some[0].msgtype, tuple(some)) for name, some in by_topic.items()}

    def stream(self, depth: str | None, info: str | None, masks: str | None) -> _Stream:
        """The topics that were named, and those that there is only one of."""
        found = [name for name in self._of(_IMAGES) if any(word in name for word in ("label", "mask", "seg"))]
        depths = [name for name in self._of(_IMAGES) if "depth" in name and name not in found]
        depths = depths or self._of((_CLOUD,))
        seen = self._choose_topic("depth", depth, depths, (*_IMAGES, _CLOUD))
        if seen.kind == _CLOUD:
            return _Stream(seen)
        infos = self._of((_INFO,))
        beside = [name for name in infos if name.rsplit("/", 1)[0] == seen.topic.rsplit("/", 1)[0]]
        return _Stream(
            seen,
            self._choose_topic("info", info, beside if len(beside) == 1 else infos, (_INFO,)),
            self._choose_topic("masks", masks, found, _IMAGES),
        )

    def _of(self, kinds: Sequence[str]) -> list[str]:
        return [name for name, topic in self._topics.items() if topic.kind in kinds]

    def _choose_topic(self, role: str, given: str | None, found: list[str], kinds: Sequence[str]) -> _Topic:
        short = " or ".join(kind.rsplit("/", 1)[1] for kind in kinds)
        has = ", ".join(f"{name} ({each.kind.rsplit('/', 1)[1]})" for name, each in self._topics.items())
        if given is None and len(found) != 1:
            raise InvalidInput(f"say with {role}=TOPIC which {short} is meant: it has {has or 'no topics'}")
        name = found[0] if given is None else given
        if name not in self._topics or self._topics[name].kind not in kinds:
            raise InvalidInput(f"{role}={name} is no topic of {short}: it has {has or 'no topics'}")
        return self._topics[name]

    def moments(self, topic: _Topic) -> list[_Moment]:
        """When each message of a topic was taken and recorded, in the order of recording."""
        if topic.topic not in self._moments:
            self._moments[topic.topic] = [
                (_stamp(message) or recorded, recorded) for message, recorded in self._messages(topic)
            ]
        return self._moments[topic.topic]

    def _messages(self, topic: _Topic, moment: _Moment | None = None) -> Iterator[tuple[Any, int]]:
        span = {} if moment is None else {"start": moment[1], "stop": moment[1] + 1}
        for connection, recorded, raw in self._reader.messages(list(topic.connections), **span):
            yield self._reader.deserialize(raw, connection.msgtype), recorded

    def _nearest(self, topic: _Topic, stamp: int) -> tuple[Any, float]:
        """The message taken closest to a moment, and how many seconds lie between."""
        moments = self.moments(topic)
        if not moments:
            raise InvalidInput(f"{topic.topic} has no messages")
        moment = min(moments, key=lambda each: abs(each[0] - stamp))
        return next(self._messages(topic, moment))[0], abs(moment[0] - stamp) / _SECOND

    def frame(self, stream: _Stream, moment: _Moment) -> Parts:
        """Read one frame."""
        message = next(self._messages(stream.depth, moment))[0]
        arrays, notes = self._poses_of_camera(message.header.frame_id, moment[0])
        where = f"{stream.depth.topic} at {moment[0] / _SECOND:.3f} s"
        if stream.info is None or stream.labels is None:
            points, labels = labelled_points(message, where)
            pose = arrays.pop("pose_camera_to_world")
            arrays |= {"points": move_points(points, pose), "labels": labels, "viewpoints": pose[None, :3, 3]}
            parts = parts_from_labelled(arrays)
        else:
            masks, apart = self._nearest(stream.labels, moment[0])
            if apart > APART:
                raise InvalidInput(
                    f"{where}: the closest labels of {stream.labels.topic} are {apart:.2f} s away: expected "
                    f"at most {APART:g}; take a frame that has its own with image=N"
                )
            told = self._nearest(stream.info, moment[0])[0]
            depth = _depth(message, where)
            if (told.height, told.width) != depth.shape:
                raise InvalidInput(
                    f"{stream.info.topic} is of pictures {told.width} x {told.height}, the depth has "
                    f"{depth.shape[1]} x {depth.shape[0]}: expected the intrinsics of the depth camera"
                )
            K = intrinsics_of(told)
            distortion = np.asarray(told.d if hasattr(told, "d") else told.D)
            if distortion.any():
                notes.append(f"{stream.info.topic} tells of distortion: the depth is taken to be rectified")
            label = _pixels(masks, stream.labels.topic)
            about = {"depth": message, "camera_info": told, "labels": masks}
            frames = {what: each.header.frame_id.lstrip("/") for what, each in about.items()}
            if self._pose_between(frames, "depth", "camera_info", moment[0]) is not None:
                raise InvalidInput(
                    _apart(frames, "camera_info") + "name that of the depth camera with info=TOPIC"
                )
            if (pose := self._pose_between(frames, "depth", "labels", moment[0])) is not None:
                K_labels = self._intrinsics(frames["labels"], label.shape, moment[0])
                depth, label = labels_from(depth, K, label, K if K_labels is None else K_labels, pose)
                notes.append(
                    f"labels in the frame {frames['labels']!r} are laid by tf on depth in {frames['depth']!r}"
                    + (", with the same intrinsics, since no topic gives theirs" if K_labels is None else "")
                )
            parts = parts_from_rgbd({**arrays, "depth": depth, "K": K, "label": label})
        parts.notes += [*notes, *self._left_out]
        return parts

    def _pose_between(self, frames: Mapping[str, str], one: str, other: str, stamp: int) -> FloatArray | None:
        """(4, 4) pose of one message's frame in that of another; None where they are the same place.

        Raises:
            InvalidInput: They differ, and tf does not say by how much.
        """
        a, b = frames[one], frames[other]
        if a == b or not a or not b:
            return None
        parents = self._parents(stamp)
        (pose, root), (pose_other, root_other) = to_root(a, parents), to_root(b, parents)
        if root != root_other:
            raise InvalidInput(_apart(frames, other) + "expected one frame, or both in tf")
        between = np.linalg.inv(pose_other) @ pose
        return None if np.allclose(between, np.eye(4), atol=SAME_PLACE) else between

    def _intrinsics(self, frame: str, shape: tuple[int, ...], stamp: int) -> FloatArray | None:
        """(3, 3) of the camera whose pictures are in a frame and of a shape, where a topic tells them."""
        for topic in map(self._topics.__getitem__, self._of((_INFO,))):
            told = self._nearest(topic, stamp)[0]
            if told.header.frame_id.lstrip("/") == frame and (told.height, told.width) == shape:
                return intrinsics_of(told)
        return None

    def _poses_of_camera(self, frame: str, stamp: int) -> tuple[dict[str, NDArray[Any]], list[str]]:
        """Where tf says that the camera and the robot's base are, and which way is up."""
        parents = self._parents(stamp)
        pose, root = to_root(frame.lstrip("/"), parents)
        arrays: dict[str, NDArray[Any]] = {"pose_camera_to_world": pose}
        notes: list[str] = []
        robots = [name for name in (*parents, root) if name in _BASES or name.endswith("_link0")]
        bases = sorted(robots, key=lambda name: _BASES.index(name) if name in _BASES else len(_BASES))
        bases = [name for name in bases if to_root(name, parents)[1] == root]
        if root != frame.lstrip("/") and (root in _FIXED or root in bases):
            arrays["up"] = np.array([0.0, 0.0, 1.0])
            notes.append(f"up is z of the frame {root!r}, the root of tf")
        if bases:
            arrays["robot_base"] = to_root(bases[0], parents)[0]
            notes.append(f"the robot's base is the frame {bases[0]!r} of tf")
        return arrays, notes

    def _parents(self, stamp: int) -> dict[str, tuple[str, FloatArray]]:
        """Each frame's parent and (4, 4) pose in it, as last told by a moment, or told first after it."""
        if self._tf is None:
            self._tf = []
            topics = [topic for topic in self._topics.values() if topic.kind in (_TF, "tf/msg/tfMessage")]
            told = (message.transforms for topic in topics for message, _ in self._messages(topic))
            for each in chain.from_iterable(told):
                parent, child = each.header.frame_id.lstrip("/"), each.child_frame_id.lstrip("/")
                pose = pose_in(each.transform)
                if pose is None or parent == child:
                    self._left_out.append(
                        f"what tf says of {child!r} in {parent!r} is no pose: it is left out"
                    )
                else:
                    self._tf.append((_stamp(each), parent, child, pose))
            self._left_out = list(dict.fromkeys(self._left_out))
        known: dict[str, tuple[int, str, FloatArray]] = {}
        for told, parent, child, pose in sorted(self._tf, key=lambda each: each[0]):
            if child not in known or told <= stamp:
                known[child] = (told, parent, pose)
        return {child: (parent, pose) for child, (_, parent, pose) in known.items()}


def _stamp(message: Any) -> int:
    """When a message was taken [ns]; 0 where it does not say."""
    stamp = message.header.stamp if hasattr(message, "header") else None
    return 0 if stamp is None else int(stamp.sec) * _SECOND + int(stamp.nanosec)


def _apart(frames: Mapping[str, str], other: str) -> str:
    return f"the depth is in the frame {frames['depth']!r} and the {other} in {frames[other]!r}: "


def _depth(message: Any, where: str) -> FloatArray:
    """(H, W) in [m]."""
    if hasattr(message, "format") and "compressedDepth" in message.format:
        data = bytes(message.data)
        if len(data) < _COMPRESSED_DEPTH.size or "rvl" in message.format.lower():
            raise InvalidInput(f"{where} is {message.format!r}: expected compressedDepth of PNG")
        _, scale, offset = _COMPRESSED_DEPTH.unpack_from(data)
        stored = read_picture(data[_COMPRESSED_DEPTH.size :], where).astype(np.float64)
        if message.format.startswith("32FC1"):
            return np.where(stored > 0, scale / np.where(stored > 0, stored - offset, 1.0), 0.0)
        return stored * 1e-3
    pixels = _pixels(message, where)
    return pixels.astype(np.float64) * (1e-3 if pixels.dtype.kind in "iu" else 1.0)


def _pixels(message: Any, where: str) -> NDArray[Any]:
    """(H, W) of one channel, as stored."""
    if hasattr(message, "format"):
        picture = read_picture(bytes(message.data), where)
        if picture.ndim != 2:
            raise InvalidInput(f"{where} has {picture.shape[2]} channels: expected one")
        return picture
    if message.encoding not in _ENCODINGS:
        raise InvalidInput(f"{where} is {message.encoding!r}: expected {', '.join(_ENCODINGS)}")
    kind = np.dtype(_ENCODINGS[message.encoding]).newbyteorder(">" if message.is_bigendian else "<")
    height, width, step = int(message.height), int(message.width), int(message.step)
    if step < width * kind.itemsize or len(message.data) < height * step:
        raise InvalidInput(
            f"{where} has {len(message.data)} bytes: expected {height} rows of {width} {kind.name}"
        )
    rows = np.frombuffer(bytes(message.data), np.uint8)[: height * step].reshape(height, step)
    pixels = np.ascontiguousarray(rows[:, : width * kind.itemsize]).view(kind)
    return pixels.astype(kind.newbyteorder("="))


def labelled_points(message: Any, where: str) -> tuple[FloatArray, NDArray[Any]]:
    """Points (N, 3) [m] and labels (N,) of a PointCloud2."""
    fields = {field.name: (_FIELDS.get(field.datatype, ""), int(field.offset)) for field in message.fields}
    called = next((name for name in LABELS if name in fields), None)
    needed = ["x", "y", "z", called]
    if called is None or any(name not in fields or not fields[name][0] for name in needed):
        raise InvalidInput(
            f"{where} has the fields {', '.join(fields)}: expected x, y, z and {' or '.join(LABELS)}"
        )
    order, step = ">" if message.is_bigendian else "<", int(message.point_step)
    ends = [offset + np.dtype(kind).itemsize for kind, offset in fields.values() if kind]
    height, width, row = int(message.height), int(message.width), int(message.row_step)
    if max(ends) > step or row < width * step or len(message.data) < height * row:
        raise InvalidInput(f"{where} has {len(message.data)} bytes: expected {height} rows of {width} points")
    check_size(height * width * 32, where)
    record = np.dtype(
        {
            "names": ["x", "y", "z", "label"],
            "formats": [order + fields[str(name)][0] for name in needed],
            "offsets": [fields[str(name)][1] for name in needed],
            "itemsize": step,
        }
    )
    rows = np.frombuffer(bytes(message.data), np.uint8)[: height * row].reshape(height, row)
    points: NDArray[Any] = np.ascontiguousarray(rows[:, : width * step]).view(record).ravel()
    labels = points["label"]
    if labels.dtype.kind == "f" and np.isfinite(labels).all():
        labels = np.round(labels)
    return np.stack([points[axis] for axis in "xyz"], axis=1).astype(np.float64), labels.astype(np.int64)
