"""Writes a scene as an `.npz` of clouds, and says which keys of one are no objects."""

import io
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput
from topple.topology.base.files import write_whole

SPECIAL = ("up", "fixed", "viewpoints", "table_plane", "robot_base")
OWN = (*SPECIAL, "matter")
BY_NAME = {"masses": '{"mug": 0.35}', "friction": '{"mug": 0.6}', "centres": '{"mug": [0.1, 0.2, 0.3]}'}


def write_clouds(path: Path, clouds: Mapping[str, FloatArray], about: Mapping[str, Any]) -> None:
    """Write a scene's file as `topple.topology.io.clouds` reads it, whole or not at all.

    Args:
        path: The file.
        clouds: (N, 3) points in [m] by name.
        about: Its other keys; what is None or empty is left out.

    Raises:
        InvalidInput: The file cannot be written, or an object has the name of one of the other keys.
    """
    if odd := sorted(clouds.keys() & {*OWN, *BY_NAME, "file", "allow_pickle"}):
        raise InvalidInput(f"an object is called {odd[0]!r}, which a scene's file has for itself: rename it")
    given = {key: value for key, value in about.items() if value is not None and len(value)}
    texts = {
        key: json.dumps(dict(given[key]), default=np.ndarray.tolist) for key in given.keys() & BY_NAME.keys()
    }
    arrays: dict[str, Any] = {**clouds, **given, **texts}
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **arrays)
    write_whole(path, buffer.getvalue())
