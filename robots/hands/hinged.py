"""A jaw of a URDF whose one finger turns against a fixed one, measured on their collision geometry.

The fixed finger is part of the last link of the arm, so the hinge is the last joint of an unbranched chain.
Whether it is a jaw is seen in the plane across its axis: both links reach out from the hinge on the same
side, come together at one limit and are apart at the other.
"""

from collections.abc import Sequence

import numpy as np
from scipy.spatial import ConvexHull

from topple.robots.arm.gripper import Tool
from topple.robots.arm.gripper_file import Jaw
from topple.robots.arm.hinged import HingedJaw
from topple.robots.arm.kinematics import pose_of_joint
from topple.robots.arm.urdf import Joint, Model
from topple.robots.collision.convex import section
from topple.robots.hands.jaws import snap_to_axis
from topple.robots.hands.tolerances import (
    EDGE,
    FORCE,
    HINGE_STATES,
    HINGED_PAD,
    LEAN,
    LEAST_FINGER,
    LEAST_PAD,
    LEAST_STROKE,
    LEVELS,
    OVERLAP,
    SHORTER,
    STRONGEST,
    WIDEST_TURN,
)
from topple.topology.base.arrays import FloatArray
from topple.topology.geometry.rigid import move_points


def last_hinge(model: Model) -> Joint | None:
    """The joint at the end of a chain, if it turns as far as a finger does; None if not."""
    joints = [joint for joint in model.joints.values() if joint.kind != "fixed"]
    last = max(joints, key=lambda joint: len(model.path_to(joint.child)), default=None)
    turns = last is not None and last.kind == "revolute" and 0.0 < last.upper - last.lower <= WIDEST_TURN
    return last if turns and len(joints) > 1 else None


def hinged_jaw(model: Model, joint: Joint, given: Jaw | None = None) -> Tool | None:
    """Measure a jaw whose one finger turns.

    Args:
        model: The URDF, the links of the joint cut finely.
        joint: The finger's.
        given: What is known of it and need not be measured: force, friction.

    Returns:
        The tool "fingers"; None where the links of the joint do not close on each other.
    """
    given = given or Jaw(joints=[joint.name])
    links = (joint.child, joint.parent)
    moving, fixed = (model.links[link].parts for link in links)
    if not moving or not fixed:
        return None
    hinge, axis = joint.pose_child_to_parent[:3, 3], joint.pose_child_to_parent[:3, :3] @ joint.axis
    fixed = [part - hinge for part in fixed]

    def turn_to(value: float) -> list[FloatArray]:
        return [move_points(part, pose_of_joint(joint, value)) - hinge for part in moving]

    tips = [_farthest(turn_to(value), axis) for value in (joint.lower, joint.upper)]
    reach = [max(float((part @ tip).max()) for part in fixed) / float(tip @ tip) for tip in tips]
    (shut, tip), wide = (joint.lower, tips[0]), joint.upper
    if reach[1] > reach[0]:
        (shut, tip), wide = (joint.upper, tips[1]), joint.lower
    if np.linalg.norm(tip) < LEAST_FINGER or max(reach) < SHORTER:
        return None
    out = snap_to_axis(tip)
    out = out - axis * float(out @ axis)
    across = np.sign(wide - shut) * np.cross(axis, out / np.linalg.norm(out))
    turn = np.column_stack([np.cross(across, out), across, out])
    turn = turn / np.linalg.norm(turn, axis=0)
    own, lean = _in(turn, fixed), _lean(_in(turn, turn_to(shut)), float(np.linalg.norm(tip)))
    most = shut + np.sign(wide - shut) * min(abs(wide - shut), max(LEAN - lean, 0.0))
    end = max(float(part[:, 2].max()) for part in _in(turn, turn_to(most)))
    tip_of_both = max(float(part[:, 2].max()) for part in own) - EDGE
    levels = np.linspace(end - HINGED_PAD, tip_of_both, LEVELS)
    zone = levels[levels <= end]
    face = float(np.nanmax(_side(own, levels, 1.0), initial=-np.inf))
    values = np.linspace(shut, most, HINGE_STATES)
    states = [_in(turn, turn_to(float(value))) for value in values]
    gaps = np.array([np.nanmin(_side(state, levels, -1.0), initial=np.inf) for state in states]) - face
    keep = np.flatnonzero((gaps > -OVERLAP) & np.isfinite(gaps))
    keep = keep[max(np.count_nonzero(gaps[keep] <= 0.0) - 1, 0) :]  # closed in one state
    if len(keep) < 2 or not (np.diff(gaps[keep]) > 0.0).all() or np.ptp(gaps[keep]) < LEAST_STROKE:
        return None
    both = own, states[keep[0]]
    low = max(float(np.nanmin(_side(parts, zone, -1.0, axis=0))) for parts in both)
    high = min(float(np.nanmax(_side(parts, zone, 1.0, axis=0))) for parts in both)
    pose = np.eye(4)
    pose[:3, :3] = turn
    pose[:3, 3] = hinge + turn @ np.array([(low + high) / 2.0, face, end - HINGED_PAD / 2.0])
    torque = joint.effort / (end - HINGED_PAD / 2.0) if joint.effort > 0.0 else FORCE
    jaw = HingedJaw(
        joints=(joint.name,),
        links=links,
        openings=np.maximum(gaps[keep], 0.0),
        joint_values=values[keep][:, None],
        force=min(torque, STRONGEST) if given.force is None else given.force,
        pad_size=(max(high - low, LEAST_PAD), HINGED_PAD),
        friction=given.friction,
    )
    return Tool.of(jaw, joint.parent, pose)


def _in(turn: FloatArray, parts: Sequence[FloatArray]) -> list[FloatArray]:
    """Parts along the axes of a frame."""
    return [part @ turn for part in parts]


def _farthest(parts: Sequence[FloatArray], axis: FloatArray) -> FloatArray:
    """The vertex (3,) farthest from the hinge, across its axis."""
    points = np.concatenate([*parts])
    flat = points - np.outer(points @ axis, axis)
    return flat[int(np.argmax(np.linalg.norm(flat, axis=1)))]


def _side(parts: Sequence[FloatArray], levels: FloatArray, sign: float, axis: int = 1) -> FloatArray:
    """The largest y, or x, (sign 1) or smallest (-1) of parts at levels of z (k,) [m]; nan for nothing."""
    found = np.full(len(levels), np.nan)
    # vertices within the outline are outermost at no level, and scanned fingers have thousands of them
    outlines = [part[ConvexHull(part[:, [axis, 2]]).vertices] for part in parts]
    for k, level in enumerate(levels):
        points = np.concatenate([np.empty((0, 3)), *(section(part, float(level)) for part in outlines)])
        if len(points):
            found[k] = sign * (sign * points[:, axis]).max()
    return found


def _lean(parts: Sequence[FloatArray], length: float) -> float:
    """Angle of the moving finger's face to z [rad], over its outer half; below 0: its tip comes first."""
    levels = np.linspace(length / 2.0, length - EDGE, LEVELS)
    sides = _side(parts, levels, -1.0)
    there = np.isfinite(sides)
    return float(np.arctan(np.polyfit(levels[there], sides[there], 1)[0])) if there.sum() > 1 else 0.0
