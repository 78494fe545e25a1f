"""An arm's motion as a page plays it: link shapes once, and the poses of links and of what is carried."""

import base64
from collections.abc import Mapping, Sequence
from itertools import groupby, pairwise
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from topple.planner.formats.arm_motion import ArmMotion
from topple.planner.report.drawing import Document
from topple.planner.report.html import Span
from topple.planner.report.limits import LIMITS
from topple.planner.report.palette import css
from topple.robots.arm.arm import Arm
from topple.robots.arm.visuals import visuals
from topple.topology.base.arrays import FloatArray, IntArray

STEP = 1e-4  # lengths are whole multiples of this [m]: 16 bits reach 3.2 m either way
TURN = 32767  # parts of a quaternion are whole multiples of its inverse


def arm_shape(arm: Arm | None) -> Document:
    """How an arm looks, ready for JSON.

    Returns:
        Numbers of the `links` that are drawn, and their `parts`: each with its link's place among those, its
        colour, vertices in steps in the link's frame, and triangles.
    """
    seen = [] if arm is None else visuals(arm, LIMITS.arm_triangles)
    drawn = [number for number, parts in enumerate(seen) if parts]
    parts = [
        {
            "at": at,
            "colour": css(visual.colour),
            "vertices": _pack(visual.vertices / STEP),
            "faces": _pack(visual.faces.ravel()),
        }
        for at, number in enumerate(drawn)
        for visual in seen[number]
    ]
    return {"links": drawn, "parts": parts}


def motion_json(
    motion: ArmMotion,
    shape: Document,
    index: Mapping[str, int],
    centre: FloatArray,
    bands: Sequence[Span] | None = None,
) -> dict[str, Any]:
    """Times [s] of a motion, what is done when, and poses as positions and quaternions of 16 bits.

    Args:
        motion: The motion.
        shape: What `arm_shape` gave.
        index: Object -> its number in the view.
        centre: (3,) what positions are counted from [m].
        bands: What the time line is divided into; what the arm does one after the other where None.
    """
    carried = {index[name]: poses for name, poses in motion.carried.items() if name in index}
    return {
        "times": [round(float(time), 3) for time in motion.times],
        "spans": spans(motion),
        "bands": spans(motion) if bands is None else list(bands),
        "centre": [round(float(value), 5) for value in centre],
        "links": _poses(motion.links[:, shape["links"]], centre),
        "beside": _poses(motion.beside[shape["links"]], centre) if len(motion.beside) else None,
        # moved about the centre, so that turns far from the origin stay small steps
        "carried": [
            {"object": number, "poses": _poses(poses, centre - poses[:, :3, :3] @ centre)}
            for number, poses in carried.items()
        ],
    }


def spans(motion: ArmMotion) -> list[Span]:
    """Split a motion into its successive activities: the word for each, from when and until when [s]."""
    runs = [list(run) for _, run in groupby(range(len(motion.times)), key=motion.kinds.__getitem__)]
    ends = [0.0, *(round(float(motion.times[run[-1]]), 3) for run in runs)]
    return [(motion.kinds[run[0]], *span) for run, span in zip(runs, pairwise(ends), strict=True)]


def _poses(poses: FloatArray, centre: FloatArray) -> str:
    """(..., 4, 4) as position and quaternion (x, y, z, w) of 16 bits each, in base64."""
    turns = Rotation.from_matrix(poses[..., :3, :3].reshape(-1, 3, 3)).as_quat()
    places = (poses[..., :3, 3].reshape(-1, 3) - centre) / STEP
    return _pack(np.concatenate([places, turns * TURN], axis=1))


def _pack(values: FloatArray | IntArray) -> str:
    return base64.b64encode(np.round(values).clip(-TURN, TURN).astype("<i2").tobytes()).decode("ascii")
