"""Bounds on what rosbags unpacks: what chunks state and what is allowed, before memory is taken.

Its decompressors take whatever comes out of a chunk, and databases may compute what they hold. Both are
bounded in every process that reads a recording, and only while topple reads one.
"""

from collections.abc import Callable, Generator, Iterable
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache, partial
from types import SimpleNamespace
from typing import Any

from topple.topology.base.errors import InvalidInput
from topple.topology.io.limits import check_size, size_limit

_CHUNK = "a packed part of it"
_unpacked: ContextVar[list[int] | None] = ContextVar("_unpacked", default=None)
"""Bytes unpacked to files so far; None where topple reads no recording."""


@contextmanager
def limit_unpacking(readers: Iterable[Any]) -> Generator[None, None, None]:
    """Bound in a block what readers of rosbags unpack.

    Args:
        readers: `AnyReader.readers`, not opened yet.

    Raises:
        InvalidInput: In the block: a part unpacks to more than it states or than is allowed, or a database
            computes what it holds.
    """
    _install()
    for reader in readers:
        if hasattr(reader, "read_chunk"):  # ROS 1
            reader.read_chunk = partial(_chunk_of_bag, reader)
    before = _unpacked.get()
    _unpacked.set([0])
    try:
        yield
    finally:
        _unpacked.set(before)


def check_chunks(readers: Iterable[Any]) -> None:
    """Refuse chunks that would be held at once and are too much: those of the same time.

    Args:
        readers: `AnyReader.readers`, open.

    Raises:
        InvalidInput: They are.
    """
    for reader in readers:
        storage = getattr(reader, "storage", None)
        for one in getattr(storage, "storages", (storage,)):
            chunks = getattr(one, "chunks", ())
            begun = [(chunk.message_start_time, chunk.uncompressed_size) for chunk in chunks]
            ended = [(chunk.message_end_time + 1, -chunk.uncompressed_size) for chunk in chunks]
            held = 0
            for _, size in sorted(begun + ended):
                held += size
                check_size(max(held, 0), "what it holds of one moment")


@cache
def _install() -> None:
    """Put bounds around what rosbags unpacks with; they are those of rosbags where topple reads nothing."""
    import apsw
    from lz4.frame import LZ4FrameDecompressor
    from rosbags.rosbag2 import reader, storage_mcap

    folders: Any = reader
    zstd = folders.zstd
    mcap: dict[str, Callable[[bytes, int], bytes]] = storage_mcap.DECOMPRESSORS
    mcap["lz4"] = partial(_chunk, LZ4FrameDecompressor, mcap["lz4"])
    mcap["zstd"] = partial(_chunk, zstd.ZstdDecompressor, mcap["zstd"])
    folders.zstd = SimpleNamespace(decompress=partial(_message, zstd), open=partial(_open_packed, zstd))
    apsw.connection_hooks.append(_check_database)


def _chunk_of_bag(reader: Any) -> Any:
    """Read the header of a chunk of ROS 1, and have it unpacked to no more than it states."""
    from bz2 import BZ2Decompressor

    from lz4.frame import LZ4FrameDecompressor
    from rosbags.rosbag1.reader import Header

    start = reader.bio.tell()
    chunk = type(reader).read_chunk(reader)
    end = reader.bio.tell()
    reader.bio.seek(start)
    header = Header.read(reader.bio)
    reader.bio.seek(end)
    kinds: dict[str, Callable[[], Any]] = {"bz2": BZ2Decompressor, "lz4": LZ4FrameDecompressor}
    kind = header.get_string("compression")
    if kind not in kinds:
        return chunk
    stated = header.get_uint32("size")
    check_size(stated, _CHUNK)
    return chunk._replace(decompressor=partial(_up_to, kinds[kind], stated))


def _chunk(kind: Callable[[], Any], before: Callable[[bytes, int], bytes], data: bytes, stated: int) -> bytes:
    """Unpack a chunk of MCAP."""
    if _unpacked.get() is None:
        return before(data, stated)
    check_size(stated, _CHUNK)
    return _up_to(kind, stated, data)


def _message(zstd: Any, data: bytes) -> bytes:
    """Unpack a message that was packed alone; how much comes out it need not state."""
    if _unpacked.get() is None:
        return zstd.decompress(data)
    stated = zstd.get_frame_info(data).decompressed_size
    if stated is not None:
        check_size(stated, _CHUNK)
    return _up_to(zstd.ZstdDecompressor, size_limit() if stated is None else stated, data)


def _up_to(kind: Callable[[], Any], size: int, data: bytes) -> bytes:
    """Unpack what is packed, one stream after the other, where it is no more than some bytes.

    Raises:
        InvalidInput: It is more.
    """
    found, left = list[bytes](), size
    while data:
        stream = kind()
        piece: bytes = stream.decompress(data, left + 1)
        if len(piece) > left:
            raise InvalidInput(
                f"{_CHUNK} unpacks to more than {size} bytes, which it states or may: record it "
                "anew, or allow more with max_bytes=N"
            )
        if not stream.eof:
            raise InvalidInput(f"{_CHUNK} ends before it is unpacked: record it anew")
        found.append(piece)
        left, data = left - len(piece), stream.unused_data or b""
    return b"".join(found)


@contextmanager
def _open_packed(zstd: Any, *args: Any) -> Generator[Any, None, None]:
    """Open a packed file, all of which is unpacked to a temporary one."""
    with zstd.open(*args) as file:
        yield SimpleNamespace(read=partial(_read, file))


def _read(file: Any, size: int) -> bytes:
    data: bytes = file.read(size)
    count = _unpacked.get()
    if count is not None:
        count[0] += len(data)
        check_size(count[0], "it")
    return data


_ODD = """
SELECT name FROM sqlite_master WHERE type IN ('view', 'trigger') OR sql LIKE 'CREATE VIRTUAL%'
UNION ALL SELECT tables.name FROM sqlite_master tables, pragma_table_xinfo(tables.name) columns
WHERE columns.hidden OR columns.dflt_value NOT NULL LIMIT 1
"""


def _check_database(connection: Any) -> None:
    """Refuse a database that computes what it holds: its file says nothing about how much that is."""
    if _unpacked.get() is None:
        return
    for (name,) in connection.execute(_ODD):
        raise InvalidInput(
            f"its table {name!r} computes what it holds: expected tables as rosbag2 makes them"
        )
