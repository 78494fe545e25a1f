"""Numbers and poses as the elements of a URDF state them, refused with a word on where they stand."""

import math
import xml.etree.ElementTree as ElementTree
from collections.abc import Sequence

import numpy as np

from topple.robots.arm.tolerances import MOST_NAMED
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput
from topple.topology.base.tolerances import FARTHEST


def number(text: str | None, default: float | None, where: str) -> float:
    """A finite number; the default where there is no text. Refused in the words of `where` otherwise."""
    if text is None and default is not None:
        return default
    try:
        value = float(str(text))
    except ValueError as error:
        raise InvalidInput(f"{where}: expected a number, found {text!r}") from error
    if not math.isfinite(value):
        raise InvalidInput(f"{where}: expected a finite number, found {text!r}")
    return value


def numbers(text: str | None, count: int, default: tuple[float, ...] | None, where: str) -> FloatArray:
    """(count,) finite numbers; the default where there is no text. Refused likewise otherwise."""
    if text is None and default is not None:
        return np.array(default)
    try:
        found = np.array([float(word) for word in str(text).split()])
    except ValueError:
        found = np.empty(0)
    if len(found) != count or not (np.abs(found) < FARTHEST).all():  # nan is not
        raise InvalidInput(f"{where}: expected {count} numbers below {FARTHEST:g}, found {text!r}")
    return found


def origin_of(element: ElementTree.Element, where: str) -> FloatArray:
    """The (4, 4) pose that an element's `<origin>` states, the identity without one."""
    origin = element.find("origin")
    if origin is None:
        return np.eye(4)
    return pose_from_xyz_rpy(
        numbers(origin.get("xyz"), 3, (0.0, 0.0, 0.0), f"{where} xyz"),
        numbers(origin.get("rpy"), 3, (0.0, 0.0, 0.0), f"{where} rpy"),
    )


def pose_from_xyz_rpy(xyz: FloatArray, rpy: FloatArray) -> FloatArray:
    """The (4, 4) pose of a URDF origin: roll, pitch, yaw in [rad] about fixed x, y, z axes; xyz in [m]."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy), np.sin(rpy)
    pose = np.eye(4)
    pose[:3, :3] = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    pose[:3, 3] = xyz
    return pose


def first_of(names: Sequence[str]) -> str:
    """Names in a message, and how many more there are."""
    more = f" and {len(names) - MOST_NAMED} more" if len(names) > MOST_NAMED else ""
    return f"{', '.join(names[:MOST_NAMED])}{more}"
