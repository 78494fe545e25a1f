"""What the options of the commands that move an arm say: which one, where it stands, what it shall do."""

import argparse
import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING

from topple.topology.base.errors import InvalidInput
from topple.topology.base.files import check_writable

if TYPE_CHECKING:
    from pathlib import Path

    from topple.planner.placement.away import Destination
    from topple.robots.arm.arm import Arm
    from topple.topology.base.arrays import FloatArray
    from topple.topology.scene.scene import Scene


def arm_of(args: argparse.Namespace) -> "Arm":
    """Find the arm, which has a tool.

    Raises:
        InvalidInput: The name is unknown, the URDF or the gripper file cannot be used, or there is no tool.
    """
    from topple.robots.catalog.own_arm import check_tool

    arm = robot_of(args)
    check_tool(arm)
    return arm


def robot_of(args: argparse.Namespace) -> "Arm":
    """Find the arm, with or without a tool.

    Raises:
        InvalidInput: The name is unknown, or a file cannot be used.
    """
    from topple.robots.catalog import robot

    return robot(args.robot, args.gripper, srdf=args.srdf, group=args.group)


def film_of(args: argparse.Namespace) -> "Path | None":
    """Where the film goes, None where not wanted; checked before anything is done.

    Raises:
        InvalidInput: Nothing can be written there, or what writes it is not installed.
    """
    if args.video is not None:
        from topple.robots.world.film import encoder

        encoder()
    return output_of(args, "video")


def output_of(args: argparse.Namespace, name: str) -> "Path | None":
    """Where something is written, None where it is not wanted.

    Raises:
        InvalidInput: Nothing can be written there.
    """
    given = getattr(args, name)
    return None if given is None else check_writable(given)


def seen_robot(args: argparse.Namespace) -> "Callable[[Scene], Sequence[FloatArray]] | tuple[()]":
    """Make the function that finds the bodies (V, 3) of --robot at --joints [m]; () without joints.

    Raises:
        InvalidInput: There is no such robot; asked, that the joints are not its, or its place is not known.
    """
    if getattr(args, "joints", None) is None:
        return ()
    if args.robot is None:
        args.parser.error("--joints are those of --robot: give both or neither")
    return partial(_bodies, robot_of(args), args.joints, argparse.Namespace(base=args.base))


def _bodies(
    arm: "Arm", joints: "Sequence[float]", place: argparse.Namespace, scene: "Scene"
) -> "Sequence[FloatArray]":
    given = base_of(place, scene)
    base = scene.robot_base if given is None else given
    if base is None:
        raise InvalidInput(
            "where the robot of --joints stands is not known: give --base X Y Z YAW, or a robot_base"
        )
    return arm.bodies(joints, base)


def away_of(args: argparse.Namespace) -> "Destination":
    """Where things go that are taken, by `--away` and `--bin`.

    Raises:
        InvalidInput: It is no such place.
    """
    from topple.planner.placement.away import Away, Destination

    words = args.away or ["table" if args.bin is None else Away.BIN]
    if args.bin is not None and words != [Away.BIN]:
        raise InvalidInput(f"--bin says where the bin of --away bin stands: found --away {' '.join(words)}")
    return Destination.of([*words, *(args.bin or [])])


def base_of(args: argparse.Namespace, scene: "Scene", option: str = "--base") -> "FloatArray | None":
    """Turn `--base`, or the like, into a pose.

    Args:
        args: The parsed arguments.
        scene: The scene, whose `up` is the axis of the yaw and z of the base.
        option: Which.

    Returns:
        Pose (4, 4) pose_base_to_world, or None where no base was given.

    Raises:
        InvalidInput: If a value is not finite.
    """
    given = getattr(args, option.removeprefix("--").replace("-", "_"))
    if given is None:
        return None
    import numpy as np
    from scipy.spatial.transform import Rotation

    if not all(math.isfinite(value) for value in given):
        raise InvalidInput(f"{option} is {given}: expected finite metres and radians X Y Z YAW")
    pose = np.eye(4)
    pose[:3, 3] = given[:3]
    upright = np.eye(3)
    if scene.up is not None and scene.up[2] < 1.0:
        # Yaw 0 is the least turn that brings z to up; upside down, it goes about x.
        axis = np.cross([0.0, 0.0, 1.0], scene.up)
        length = float(np.linalg.norm(axis))
        turn = np.array([np.pi, 0.0, 0.0]) if length < 1e-12 else axis / length * np.arccos(scene.up[2])
        upright = Rotation.from_rotvec(turn).as_matrix()
    pose[:3, :3] = upright @ Rotation.from_euler("z", given[3]).as_matrix()
    return pose
