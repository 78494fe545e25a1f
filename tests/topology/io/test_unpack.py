"""Recordings that unpack to more than is allowed, or than they state, are refused before they do."""

import sqlite3
import struct
from pathlib import Path

import numpy as np
import pytest

from topple.topology.base.errors import InvalidInput
from topple.topology.io import load_scene

made = pytest.importorskip("topple.benchmarks.fuzz.recordings", reason="a checkout has the benches")
counting = pytest.importorskip("topple.benchmarks.fuzz.counting")
ROWS, ALLOWED, HELD = 1 << 20, 1 << 20, 8.0
"""Points of a bomb (16 MB), bytes that are allowed, and MB that refusing it may take."""


def _written(parts: dict[str, bytes], folder: Path) -> Path:
    for name, data in parts.items():
        (folder / name).write_bytes(data)
    return folder / "run.bag" if "run.bag" in parts else folder


@pytest.mark.parametrize("kind", made.MADE)
def test_what_unpacks_to_a_lot_is_refused_before_memory_is_taken(kind, tmp_path):
    sound = next(reader for reader in made.RECORDINGS if reader.name == kind)
    scene = load_scene(sound.write(sound.parts(), tmp_path))  # what reading takes once is taken
    assert scene.names == ("1", "2")
    path = _written(dict(made.MADE[kind](np.zeros((ROWS, 4)))), tmp_path)
    assert sum(file.stat().st_size for file in tmp_path.iterdir()) < 16 * ROWS / 50
    before = counting._peak(anew=True)
    with pytest.raises(InvalidInput, match=r"unpack.* to .* max_bytes=N"):
        load_scene(path, max_bytes=ALLOWED)
    assert counting._peak() - before < HELD
    with pytest.raises(InvalidInput, match="labels is 0 everywhere"):  # where it is allowed, it is read
        load_scene(path)


@pytest.mark.parametrize("kind", ["bag, bz2", "bag, lz4", "mcap, zstd", "mcap, lz4"])
def test_a_chunk_that_unpacks_to_more_than_it_states_is_refused(kind, tmp_path):
    parts = dict(made.MADE[kind](np.zeros((ROWS, 4))))
    name = next(name for name in parts if name.startswith("run."))
    data, false = parts[name], struct.pack("<Q", 5000)
    if "bag" in kind:
        head, _, tail = data.partition(b"size=")
        parts[name] = head + b"size=" + false[:4] + tail[4:]
    else:  # in the chunk and in the index, not between: in the header of LZ4 a checksum tells
        sizes = [struct.pack("<Q", 16 * ROWS + more) for more in range(4000)]  # the cloud, and more
        stated = [size for size in sizes if size in data][-1]
        head, _, tail = data.replace(stated, false, 1).rpartition(stated)
        parts[name] = head + false + tail
    before = counting._peak(anew=True)
    with pytest.raises(InvalidInput, match="unpacks to more than 5000 bytes, which it states"):
        load_scene(_written(parts, tmp_path), max_bytes=ALLOWED)
    assert counting._peak() - before < HELD


@pytest.mark.parametrize(
    "script",
    [
        "ALTER TABLE messages RENAME TO old; CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id, "
        "timestamp, data BLOB AS (zeroblob(900000000))); "
        "INSERT INTO messages SELECT id, topic_id, timestamp FROM old; DROP TABLE old;",
        "DROP TABLE schema; CREATE VIEW schema AS WITH RECURSIVE n(x) AS "
        "(SELECT 0 UNION ALL SELECT x FROM n) SELECT x AS schema_version FROM n WHERE x;",
        "ALTER TABLE topics ADD COLUMN more DEFAULT 'much';",
    ],
)
def test_a_database_that_computes_what_it_holds_is_refused(script, tmp_path):
    _written(dict(made.folder_of_ros2("SQLITE3", "NONE", np.ones((8, 4)))), tmp_path)
    with sqlite3.connect(tmp_path / "run.db3") as database:
        database.executescript(script)
    database.close()
    for path in (tmp_path, tmp_path / "run.db3"):
        with pytest.raises(InvalidInput, match=r"table '.*' computes what it holds"):
            load_scene(path)


def test_what_others_read_with_rosbags_is_not_bounded(tmp_path):
    from rosbags.highlevel import AnyReader

    path = _written(dict(made.MADE["mcap, lz4"](np.zeros((ROWS, 4)))), tmp_path)
    with pytest.raises(InvalidInput, match="max_bytes=N"):
        load_scene(path, max_bytes=ALLOWED)
    with AnyReader([path]) as reader:
        assert [len(raw) > 16 * ROWS for _, _, raw in reader.messages()] == [True]
