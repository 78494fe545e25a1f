"""An arm's motion as a page plays it: link shapes once, and the poses of links and of what is carried."""

import base64
from collections.abc import Mapping, Sequence
from itertools import groupby
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from topple.planner.formats.arm_motion import ArmMotion
from topple.planner.report.limits import LIMITS
from topple.robots.collision.convex import hull_of, reduced
from topple.topology.arrays import FloatArray

Span = tuple[str, float, float]
"""A part of a time line: its name, from when and until when [s]."""

STEP = 1e-4
"""Lengths are whole multiples of this [m]: 16 bits reach 3.2 m either way."""
TURN = 32767
"""Parts of a quaternion are whole multiples of its inverse."""


def arm_shape(parts: Sequence[Sequence[FloatArray]]) -> list[dict[str, Any]]:
    """The shapes of an arm's links.

    Args:
        parts: Per link the (V, 3) vertices of its convex parts in the link frame [m].

    Returns:
        Per link that has a shape its number, vertices in steps, and triangles, ready for JSON.
    """
    links: list[dict[str, Any]] = []
    for number, link in enumerate(parts):
        hulls = [hull_of(reduced(hull_of(part)[0], LIMITS.arm)[0]) for part in link]
        if not hulls:
            continue
        before = np.cumsum([0, *(len(vertices) for vertices, _ in hulls)])
        vertices = np.concatenate([vertices for vertices, _ in hulls])
        faces = np.concatenate([faces + first for (_, faces), first in zip(hulls, before, strict=False)])
        links.append({"link": number, "vertices": _packed(vertices / STEP), "faces": faces.ravel().tolist()})
    return links


def motion_json(
    motion: ArmMotion,
    shape: Sequence[Mapping[str, Any]],
    index: Mapping[str, int],
    centre: FloatArray,
    bands: Sequence[Span] | None = None,
) -> dict[str, Any]:
    """A motion as the viewer reads it.

    Args:
        motion: The motion.
        shape: What `arm_shape` gave.
        index: Object -> its number in the view.
        centre: (3,) what positions are counted from [m].
        bands: What the time line is divided into; what the arm does one after the other where None.

    Returns:
        Times [s], what is done when, and poses as positions and quaternions of 16 bits.
    """
    chosen = [link["link"] for link in shape]
    carried = {index[name]: poses for name, poses in motion.carried.items() if name in index}
    return {
        "times": [round(float(time), 3) for time in motion.times],
        "spans": spans(motion),
        "bands": spans(motion) if bands is None else list(bands),
        "centre": [round(float(value), 5) for value in centre],
        "links": _poses(motion.links[:, chosen], centre),
        # moved about the centre, so that turns far from the origin stay small steps
        "carried": [
            {"object": number, "poses": _poses(_about(poses, centre), np.zeros(3))}
            for number, poses in carried.items()
        ],
    }


def spans(motion: ArmMotion) -> list[Span]:
    """What the arm does one after the other: the word for it, from when and until when [s]."""
    found: list[Span] = []
    for kind, run in groupby(range(len(motion.times)), key=lambda k: motion.kinds[k]):
        frames = list(run)
        ends = float(motion.times[frames[-1]])
        found.append((kind, found[-1][2] if found else 0.0, ends))
    return [(kind, round(first, 3), round(last, 3)) for kind, first, last in found]


def _about(poses: FloatArray, centre: FloatArray) -> FloatArray:
    """Transforms (k, 4, 4) of points that are counted from a centre."""
    moved = poses.copy()
    moved[:, :3, 3] += poses[:, :3, :3] @ centre - centre
    return moved


def _poses(poses: FloatArray, centre: FloatArray) -> str:
    """(..., 4, 4) as position and quaternion (x, y, z, w) of 16 bits each, in base64."""
    turns = Rotation.from_matrix(poses[..., :3, :3].reshape(-1, 3, 3)).as_quat()
    places = (poses[..., :3, 3].reshape(-1, 3) - centre) / STEP
    return _packed(np.concatenate([places, turns * TURN], axis=1))


def _packed(values: FloatArray) -> str:
    return base64.b64encode(np.round(values).clip(-TURN, TURN).astype("<i2").tobytes()).decode("ascii")
