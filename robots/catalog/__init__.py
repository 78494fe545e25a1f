"""The arms topple knows by name, and how to get one from a URDF file."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

from topple.robots.arm.arm import Arm
from topple.robots.arm.compose import compose_urdf
from topple.robots.arm.cup import SuctionCup
from topple.robots.arm.gripper import FINGERS, SUCTION, Tool, ToolState
from topple.robots.arm.gripper_file import Cup, GripperFile, Jaw
from topple.robots.arm.jaw import ParallelJaw
from topple.robots.catalog.data import data_path, panda_file
from topple.robots.catalog.described import DESCRIPTIONS, find_urdf
from topple.robots.catalog.own_arm import arm_from_file
from topple.robots.hands.suction_hand import CUP_JOINT, CUP_LINK, PANDA_CUP, panda_with_cup
from topple.robots.hands.wsg50 import wsg50_fingers, wsg50_xml
from topple.topology.base.arguments import checked_arguments
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput, suggestion
from topple.topology.base.plugins import Table

ROBOTS: Table[Callable[[], Arm]] = Table(
    "topple.robots",
    "robot",
    {
        "panda": "topple.robots.catalog:panda",
        "panda-suction": "topple.robots.catalog:panda_suction",
        "iiwa": "topple.robots.catalog:iiwa",
        "xarm6": "topple.robots.catalog:xarm6",
    },
    Arm,
)
"""What makes each arm, by the arm's name; other packages add theirs."""

XARM_JOINTS = (
    "drive_joint",
    "left_finger_joint",
    "left_inner_knuckle_joint",
    "right_outer_knuckle_joint",
    "right_finger_joint",
    "right_inner_knuckle_joint",
)


@checked_arguments
def robot(
    name: str | Path,
    gripper: str | Path | GripperFile | Jaw | Cup | None = None,
    *,
    srdf: str | Path | None = None,
    group: str | None = None,
) -> Arm:
    """An arm by name or from a URDF file.

    Args:
        name: One of `names()`, the path of a URDF, or the name of one that an installed package of
            descriptions ships, see `topple.robots.catalog.described`: `ur5e`.
        gripper: With a URDF: a gripper file (TOML), or what it would hold, see
            `topple.robots.arm.gripper_file`; or the URDF of a hand to mount, by its path or name, or
            `wsg50`. A parallel jaw of the URDF is recognised where it is not named here.
        srdf: With a URDF: the SRDF that says which joints are the arm; found beside it where not given.
        group: The SRDF's group that is the arm, where there are several.

    Returns:
        The arm; the same object for the same name.

    Raises:
        InvalidInput: If the name is unknown (the message lists the known ones), a file cannot be used, or a
            gripper is given with an arm that has its own.

    Examples:
        >>> arm = robot("panda")
        >>> arm.links[0], len(arm.home)
        ('panda_link0', 7)
    """
    if str(name) in ROBOTS:
        if gripper is not None:
            raise InvalidInput(f"{name} has a hand of its own: a gripper goes with the path of a .urdf file")
        if srdf is not None or group is not None:
            raise InvalidInput(f"{name} is known whole: an SRDF goes with the path of a .urdf file")
        return _by_name(str(name))
    path = name if str(name).endswith((".urdf", ".xml")) else find_urdf(str(name))
    if path is not None:
        return arm_from_file(path, gripper, srdf=srdf, group=group)
    raise InvalidInput(
        f"unknown robot {str(name)!r}: {suggestion(str(name), ROBOTS)}expected {', '.join(ROBOTS)}, the "
        f"path of a .urdf file, or the name of one that {' or '.join(DESCRIPTIONS)} ships (extra `arms`)"
    )


def names() -> tuple[str, ...]:
    """The names `robot` knows."""
    return tuple(ROBOTS)


@cache
def _by_name(name: str) -> Arm:
    return replace(ROBOTS[name](), name=name, catalog=True)


def _translation(z: float) -> FloatArray:
    pose = np.eye(4)
    pose[2, 3] = z
    return pose


def _panda_fingers() -> Tool:
    jaw = ParallelJaw(
        joints=("panda_finger_joint1", "panda_finger_joint2"),
        links=("panda_leftfinger", "panda_rightfinger"),
        openings=np.array([0.0, 0.08]),
        joint_values=np.array([[0.0, 0.0], [0.04, 0.04]]),
        force=70.0,  # [N] continuous, from the data sheet of the hand
        pad_size=(0.02, 0.018),
        friction=1.0,  # rubber pads
    )
    return Tool.of(jaw, "panda_hand", _translation(0.1034))  # the middle between the finger pads


def panda() -> Arm:
    """Franka's Panda with its hand."""
    return _panda_arm("panda", panda_file(), {FINGERS: _panda_fingers()})


def panda_suction() -> Arm:
    """A Panda with a suction cup between its fingers."""
    design = PANDA_CUP
    cup = SuctionCup(
        CUP_LINK, CUP_JOINT, stroke=design.stroke, radius=design.radius, max_force=design.holding_force
    )
    # the fingers stand open beside the extended cup, out of the way of what it takes
    ready = ToolState(0.08, design.stroke)
    lip = Tool(SUCTION, "panda_hand", _translation(design.extended_lip), cup, (CUP_LINK,), ready)
    tools: dict[str, Tool] = {FINGERS: _panda_fingers(), SUCTION: lip}
    return _panda_arm("panda-suction", panda_with_cup(panda_file(), design), tools)


def _panda_arm(name: str, urdf: Path, tools: dict[str, Tool]) -> Arm:
    lower = (-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973)
    upper = (2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973)
    arm = Arm.from_urdf(  # limits, velocities, accelerations and the ready pose of Franka's data sheet
        urdf,
        "panda_hand",
        tools,
        name=name,
        limits=(lower, upper),
        velocity=(2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61),
        acceleration=(15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0),
        home=(0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785),
        source=panda_file(),
    )
    return replace(arm, payload=2.27)  # 3 kg at the flange less 0.73 kg of hand, from the same


def iiwa() -> Arm:
    """KUKA's LBR iiwa 7 with a WSG50 hand."""
    source = data_path() / "kuka_iiwa" / "model.urdf"
    flange = 0.045  # [m] mounting face on the last link
    urdf = compose_urdf(source, "iiwa", wsg50_xml(data_path(), "lbr_iiwa_link_7", flange))
    fingers = wsg50_fingers()
    arm = Arm.from_urdf(
        urdf,
        fingers.link,
        {FINGERS: fingers},
        name="iiwa",
        velocity=(1.71, 1.71, 1.75, 2.27, 2.44, 3.14, 3.14),  # of the data sheet
        acceleration=10.0,  # not published: moderate for the class
        home=(0.0, 0.3, 0.0, -1.7, 0.0, 1.14, 0.0),  # hand down, in front
        source=source,
    )
    return replace(arm, payload=5.8)  # 7 kg at the flange less 1.2 kg of hand, from the data sheets


def xarm6() -> Arm:
    """UFACTORY's xArm6 with its gripper."""
    angle = np.linspace(0.85, 0.0, 18)  # of the drive joint: shut to open
    # the outer knuckle swings the finger on a circle, and the finger turns back: its pad stays upright
    swing = (0.035465 + 0.042039j) * np.exp(1j * angle)  # across + ahead j
    pad = 0.035 + swing.real - 0.026  # its joint to its inner face
    jaw = ParallelJaw(
        joints=XARM_JOINTS,
        links=("left_finger", "right_finger"),
        openings=2 * pad,
        joint_values=np.repeat(angle[:, None], len(XARM_JOINTS), axis=1),
        force=30.0,  # [N] from the data sheet
        pad_size=(0.0295, 0.0375),
        friction=1.0,  # rubber pads
        arc=swing.imag - np.interp(pad.max() / 2.0, pad, swing.imag),
    )
    hand = ("left_outer_knuckle", "right_outer_knuckle", "left_inner_knuckle", "right_inner_knuckle")
    pads = _translation(0.148)  # gripper base to the middle of the half open pads
    tool = Tool.of(jaw, "xarm_gripper_base_link", pads, *hand)
    arm = Arm.from_urdf(
        data_path() / "xarm" / "xarm6_with_gripper.urdf",
        "xarm_gripper_base_link",
        {FINGERS: tool},
        name="xarm6",
        acceleration=20.0,  # the largest of the manual
        home=(0.0, -0.5, -0.9, 0.0, 1.4, 0.0),  # hand down, in front
    )
    return replace(arm, payload=4.18)  # 5 kg at the flange less 0.82 kg of gripper, from the manual
