"""Small sound recordings of ROS, in every way that their readers unpack, and such as unpack to a lot."""

import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from topple.benchmarks.fuzz.oracle import wrong_scene
from topple.benchmarks.fuzz.reader import Parts, Reader
from topple.topology.base.arrays import FloatArray
from topple.topology.io import load_scene

_TYPE, _TOPIC = "sensor_msgs/msg/PointCloud2", "/cloud"
_FIELDS = {"x": 7, "y": 7, "z": 7, "label": 6}  # float32 and uint32


def bag(packing: str, rows: FloatArray) -> Parts:
    """A recording of ROS 1 of one cloud.

    Args:
        packing: "BZ2" or "LZ4".
        rows: (N, 4) points [m] and labels.
    """
    from rosbags.rosbag1 import Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC)
    with tempfile.TemporaryDirectory() as folder:
        writer = Writer(Path(folder) / "run.bag")
        writer.set_compression(Writer.CompressionFormat[packing])
        with writer:
            connection = writer.add_connection(_TOPIC, _TYPE, typestore=store)
            writer.write(connection, 10**9, store.serialize_ros1(_cloud(store.types, (0,), rows), _TYPE))
        return _parts(Path(folder))


def folder_of_ros2(storage: str, packing: str, rows: FloatArray) -> Parts:
    """A recording of ROS 2 of one cloud.

    Args:
        storage: "MCAP" or "SQLITE3".
        packing: "FILE", "MESSAGE" or "STORAGE", by zstd; "LZ4" for chunks of MCAP; "NONE".
        rows: (N, 4) points [m] and labels.
    """
    import lz4.frame
    from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    with tempfile.TemporaryDirectory() as folder:
        writer: Any = Writer(Path(folder) / "run", version=9, storage_plugin=StoragePlugin[storage])
        mode = CompressionMode["STORAGE" if packing == "LZ4" else packing]
        writer.set_compression(mode, CompressionFormat.ZSTD)
        with writer:
            if packing == "LZ4":
                writer.storage.compression, writer.storage.compressor = "lz4", lz4.frame.compress
            connection = writer.add_connection(_TOPIC, _TYPE, typestore=store)
            writer.write(connection, 10**9, store.serialize_cdr(_cloud(store.types, (), rows), _TYPE))
        return _parts(Path(folder) / "run")


def _cloud(make: Any, first: tuple[int, ...], rows: FloatArray) -> Any:
    """A PointCloud2; the header of ROS 1 has a number first."""
    table = np.zeros(
        len(rows), dtype=[(name, "<u4" if kind == 6 else "<f4") for name, kind in _FIELDS.items()]
    )
    for k, name in enumerate(_FIELDS):
        table[name] = rows[:, k]
    field = make["sensor_msgs/msg/PointField"]
    fields = [field(name, 4 * k, kind, 1) for k, (name, kind) in enumerate(_FIELDS.items())]
    head = make["std_msgs/msg/Header"](*first, make["builtin_interfaces/msg/Time"](1, 0), "camera")
    data = table.view(np.uint8)
    return make[_TYPE](head, 1, len(rows), fields, False, 16, len(data), data, True)


def _parts(folder: Path) -> Parts:
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


def _sound(make: Callable[[FloatArray], Parts]) -> Parts:
    """Two boxes of points."""
    points = np.random.default_rng(0).uniform(0.0, 0.08, (48, 3))
    return make(np.column_stack([points + np.repeat([[0.0], [0.1]], 24, axis=0), np.repeat([1, 2], 24)]))


MADE: dict[str, Callable[[FloatArray], Parts]] = {
    "bag, bz2": partial(bag, "BZ2"),
    "bag, lz4": partial(bag, "LZ4"),
    "mcap, zstd": partial(folder_of_ros2, "MCAP", "STORAGE"),
    "mcap, lz4": partial(folder_of_ros2, "MCAP", "LZ4"),
    "db3, messages packed": partial(folder_of_ros2, "SQLITE3", "MESSAGE"),
    "db3, file packed": partial(folder_of_ros2, "SQLITE3", "FILE"),
}
"""What makes a recording of rows (N, 4), by how it is packed."""

RECORDINGS = tuple(
    Reader(name, partial(_sound, make), load_scene, wrong_scene, "run.bag" if "bag" in name else "")
    for name, make in MADE.items()
)
