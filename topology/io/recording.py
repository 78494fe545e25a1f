"""A recording of ROS, opened only where its parts are files and its messages are defined as ROS does."""

import re
from collections.abc import Generator, Iterable
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from topple.topology.base.errors import InvalidInput, NotInstalled
from topple.topology.io.limits import open_file
from topple.topology.io.tolerances import LONGEST_DEFINITION
from topple.topology.io.unpack import check_chunks, limit_unpacking

_UNREAD = re.compile(r"//[^\n]*|/\*[\s\S]*?\*/|'[^'\n]*'" + r'|"(?:[^"\\]|\\.)*"')
"""Text and comments of a definition."""
_COMPUTED = re.compile(r"\([^()]*\(|=[^;@\n(]*\(")
"""Brackets in brackets, or in what a constant is."""


@contextmanager
def open_recording(path: Path) -> Generator[Any, None, None]:
    """Open a recording.

    Args:
        path: The file, or the folder of ROS 2.

    Yields:
        An open `rosbags.highlevel.AnyReader`.

    Raises:
        InvalidInput: It is broken, a part of it is no file below the folder, or a definition is none of ROS.
        NotInstalled: The package rosbags is not there.
    """
    try:
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    except ModuleNotFoundError as error:
        raise NotInstalled("recordings of ROS need rosbags", "ros") from error
    for place in path.iterdir() if path.is_dir() else ():  # what metadata.yaml names is beside it
        if not place.is_dir():
            with open_file(place, place.name):
                pass
    try:
        reader = AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE))
        for part in reader.readers:
            with limit_unpacking(reader.readers), part:
                _check_definitions(part.connections)
        with limit_unpacking(reader.readers), reader:
            check_chunks(reader.readers)
            yield reader
    except (InvalidInput, GeneratorExit):
        raise
    except Exception as error:  # its readers of three containers fail on altered bytes in many ways
        reason = " ".join(str(error).split())[:120] or type(error).__name__
        raise InvalidInput(
            f"is no readable recording of ROS ({reason}): expected .mcap, .db3 or .bag"
        ) from error


def _check_definitions(connections: Iterable[Any]) -> None:
    """Refuse definitions of messages that their parser would not be done with.

    Raises:
        InvalidInput: One is too long, or computes a constant, forty times as long for each pair of brackets.
    """
    for connection in connections:
        told = connection.msgdef
        computed = told.format.name == "IDL" and _COMPUTED.search(_UNREAD.sub("", told.data))
        if computed or len(told.data) > LONGEST_DEFINITION:
            raise InvalidInput(
                f"{connection.topic} defines {connection.msgtype} in more than {LONGEST_DEFINITION} "
                "characters, or with brackets in a constant: expected the definition of its package"
            )
