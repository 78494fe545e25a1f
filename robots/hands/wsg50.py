"""The WSG50 gripper on a flange: URDF links and joints with the meshes and frames of pybullet_data's SDF."""

import math
from pathlib import Path

import numpy as np

from topple.robots.arm.gripper import Tool
from topple.robots.arm.jaw import ParallelJaw
from topple.topology.base.arrays import FloatArray

PALM = "wsg50_palm"
FINGERS = ("wsg50_left_finger", "wsg50_right_finger")
JOINTS = ("wsg50_left_joint", "wsg50_right_joint")
PAD_AT_REST = 0.052  # [m] pad to the middle plane with the joint at zero: fully open
PAD_HEIGHT = 0.1335  # [m] middle of the pads above the mounting face
MASS, FINGER_MASS = 1.2, 0.2  # [kg] from the SDF


def wsg50_xml(data: Path, flange: str, height: float) -> str:
    """The gripper's links and joints.

    Args:
        data: The folder of pybullet_data.
        flange: Link it is mounted on; its fingers close along that link's y axis.
        height: Where the mounting face is on that link's z axis in [m].
    """
    meshes = data / "gripper" / "meshes"
    palm = _mesh(meshes / "WSG50_110.stl", 0.0, 1.0)
    finger = _mesh(meshes / "GUIDE_WSG50_110.stl", -0.06, 0.001) + _mesh(
        meshes / "WSG-FMF.stl", -0.037, 0.001
    )
    mount = (
        f"<joint name='wsg50_mount' type='fixed'><parent link='{flange}'/><child link='{PALM}'/>"
        f"<origin xyz='0 0 {height}' rpy='0 0 {math.pi / 2}'/></joint>"
    )
    text = _link(PALM, MASS, 0.036, 0.14, palm) + mount
    for link, joint, side, yaw in zip(FINGERS, JOINTS, (-0.055, 0.055), (0.0, math.pi), strict=True):
        text += _link(link, FINGER_MASS, 0.05, 0.08, finger)
        text += (
            f"<joint name='{joint}' type='prismatic'><parent link='{PALM}'/><child link='{link}'/>"
            f"<origin xyz='{side} 0 0.06' rpy='0 0 {yaw}'/><axis xyz='1 0 0'/>"
            f"<limit effort='80' lower='0' upper='{PAD_AT_REST}' velocity='0.42'/></joint>"
        )
    return text


def wsg50_fingers() -> Tool:
    """The gripper as a tool; its joints go from 0 (open) to `PAD_AT_REST` (shut)."""
    jaw = ParallelJaw(
        joints=JOINTS,
        links=FINGERS,
        openings=np.array([0.0, 2 * PAD_AT_REST]),
        joint_values=np.array([[PAD_AT_REST, PAD_AT_REST], [0.0, 0.0]]),
        force=80.0,  # [N] from the data sheet
        pad_size=(0.03, 0.04),
        friction=1.0,  # rubber pads
    )
    return Tool.of(jaw, PALM, _pads())


def _pads() -> FloatArray:
    pose = np.eye(4)
    pose[:3, :3] = [[0, 1, 0], [-1, 0, 0], [0, 0, 1]]  # the palm's x is the closing direction, the tool's y
    pose[2, 3] = PAD_HEIGHT
    return pose


def _mesh(path: Path, z: float, scale: float) -> str:
    mesh = f"<mesh filename='{path}' scale='{scale} {scale} {scale}'/>"
    shape = f"<origin xyz='0 0 {z}'/><geometry>{mesh}</geometry>"
    grey = "<material name='wsg50_grey'><color rgba='0.4 0.4 0.42 1'/></material>"
    return f"<visual>{shape}{grey}</visual><collision>{shape}</collision>"


def _link(name: str, mass: float, centre: float, size: float, shapes: str) -> str:
    inertia = mass * size**2 / 6
    return (
        f"<link name='{name}'><contact><lateral_friction value='1.0'/></contact>"
        f"<inertial><origin xyz='0 0 {centre}'/><mass value='{mass}'/>"
        f"<inertia ixx='{inertia}' ixy='0' ixz='0' iyy='{inertia}' iyz='0' izz='{inertia}'/></inertial>"
        f"{shapes}</link>"
    )
