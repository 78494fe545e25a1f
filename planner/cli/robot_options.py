"""Options of the commands that move an arm: which one, where it stands, what it shall do."""

import argparse
import math
from typing import TYPE_CHECKING

from topple.planner.cli.options import add_target, read_scene
from topple.planner.files import check_writable
from topple.topology.errors import InvalidInput

if TYPE_CHECKING:
    from pathlib import Path

    from topple.planner.planning.step import Task
    from topple.robots.arm.arm import Arm
    from topple.topology.arrays import FloatArray
    from topple.topology.scene import Scene


def add_goal(parser: argparse.ArgumentParser) -> None:
    """Add the goal: names to free, words, or how things shall lie, one of them.

    Args:
        parser: The sub-command's parser.
    """
    add_target(parser, purpose="what to free: lifted clear and put down elsewhere")
    parser.add_argument(
        "--goal",
        metavar="TEXT",
        help='what shall hold: "lemon within bowl", "red on green on blue", "empty bowl", "sort"',
    )
    parser.add_argument(
        "--to",
        metavar="GOAL",
        help="how things shall lie: another scene of them, or words (cup left of plate)",
    )
    add_match(parser)


def add_match(parser: argparse.ArgumentParser) -> None:
    """Add by what the things of `--to` are found at the start.

    Args:
        parser: The sub-command's parser.
    """
    parser.add_argument(
        "--match",
        choices=("name", "shape"),
        default="name",
        help="by what things of --to are found: by name, or by shape, whatever they are called (name)",
    )


def goal_of(args: argparse.Namespace) -> "str | list[str] | Task":
    """Say what is wanted.

    Args:
        args: The parsed arguments, scenes told apart from targets already.

    Returns:
        The goal's words, the names to free, or the task to make things lie as in another scene.

    Raises:
        InvalidInput: That scene cannot be read.
    """
    if sum((bool(args.target), args.goal is not None, args.to is not None)) != 1:
        args.parser.error("give one of --target NAME, --goal TEXT and --to GOAL")
    if args.to is not None:
        from topple.planner.rearranging.arrangement import Arrangement
        from topple.planner.rearranging.task import Alike, Described, Rearranging
        from topple.planner.rearranging.words import is_words

        if is_words(args.to):
            return Described(args.to)
        scene = read_scene(args, args.to)
        return Alike(scene) if args.match == "shape" else Rearranging(Arrangement(scene))
    return args.goal if args.goal is not None else args.target


def add_robot(parser: argparse.ArgumentParser) -> None:
    """Add the arm and its place.

    Args:
        parser: The sub-command's parser.
    """
    parser.add_argument(
        "--robot",
        default="panda",
        metavar="NAME",
        help="panda, panda-suction, iiwa, xarm6 or FILE.urdf (panda)",
    )
    add_gripper(parser)
    parser.add_argument(
        "--base",
        nargs=4,
        type=float,
        metavar=("X", "Y", "Z", "YAW"),
        help="where the arm stands, in metres and radians about up (the scene's robot_base, else searched)",
    )


def add_gripper(parser: argparse.ArgumentParser) -> None:
    """Add what an arm of one's own holds with.

    Args:
        parser: The sub-command's parser.
    """
    parser.add_argument(
        "--gripper",
        metavar="FILE",
        help="with FILE.urdf: its [jaw], [cup], [hand] or [arm], in TOML; the URDF of a hand to mount; or "
        "wsg50 (a parallel jaw of the URDF is recognised)",
    )
    parser.add_argument(
        "--srdf",
        metavar="FILE",
        help="with FILE.urdf: groups and links that do not collide (the SRDF of the same name beside it)",
    )
    parser.add_argument(
        "--group", metavar="NAME", help="the SRDF's group that is the arm, where it has several"
    )


def arm_of(args: argparse.Namespace) -> "Arm":
    """Find the arm.

    Args:
        args: The parsed arguments, with `robot` and `gripper`.

    Returns:
        The arm, which has a tool.

    Raises:
        InvalidInput: The name is unknown, the URDF or the gripper file cannot be used, or there is no tool.
    """
    from topple.robots.catalog.own_arm import check_tool

    arm = robot_of(args)
    check_tool(arm)
    return arm


def robot_of(args: argparse.Namespace) -> "Arm":
    """Find the arm, with or without a tool.

    Args:
        args: The parsed arguments, with `robot`, `gripper`, `srdf` and `group`.

    Returns:
        The arm.

    Raises:
        InvalidInput: The name is unknown, or a file cannot be used.
    """
    from topple.robots.catalog import robot

    return robot(args.robot, args.gripper, srdf=args.srdf, group=args.group)


def add_cameras(parser: argparse.ArgumentParser) -> None:
    """Add how much is seen, and how well.

    Args:
        parser: The sub-command's parser.
    """
    parser.add_argument(
        "--cameras", type=int, choices=(1, 2, 3), default=3, help="depth cameras that look on (3)"
    )
    parser.add_argument(
        "--mask-noise",
        type=float,
        default=0.0,
        metavar="PIXELS",
        help="how far edges of the masks are off, as those of a segmentation are (0)",
    )
    parser.add_argument(
        "--wrist-camera",
        action="store_true",
        help="the arm carries one more, for a second look before a doubtful step",
    )


def add_engine(parser: argparse.ArgumentParser) -> None:
    """Add what plays the world.

    Args:
        parser: The sub-command's parser.
    """
    parser.add_argument(
        "--engine",
        default="bullet",
        choices=("bullet", "mujoco"),
        help="what plays the world: PyBullet, or MuJoCo (extra 'mujoco'; arms with a jaw) (bullet)",
    )


def add_recordings(parser: argparse.ArgumentParser) -> None:
    """Add where a film and a recording go.

    Args:
        parser: The sub-command's parser.
    """
    parser.add_argument("--video", metavar="FILE", help="write a film of it, out.mp4 (extra 'video')")
    parser.add_argument(
        "--rerun", metavar="FILE", help="write a recording for the Rerun viewer, out.rrd (extra 'rerun')"
    )


def video_of(args: argparse.Namespace) -> "Path | None":
    """Where the film goes, checked before anything else is done.

    Args:
        args: The parsed arguments.

    Returns:
        The path, None where no film is wanted.

    Raises:
        InvalidInput: Nothing can be written there, or the encoder is not installed.
    """
    if args.video is None:
        return None
    from topple.robots.world.film import encoder

    encoder()
    return check_writable(args.video)


def rerun_of(args: argparse.Namespace) -> "Path | None":
    """Where the recording goes, checked before anything else is done.

    Args:
        args: The parsed arguments.

    Returns:
        The path, None where no recording is wanted.

    Raises:
        InvalidInput: Nothing can be written there, or the library is not installed.
    """
    if args.rerun is None:
        return None
    from topple.planner.report.rerun_file import library

    library()
    return check_writable(args.rerun)


def base_of(args: argparse.Namespace, scene: "Scene") -> "FloatArray | None":
    """Turn `--base` into a pose.

    Args:
        args: The parsed arguments.
        scene: The scene, whose `up` is the axis of the yaw and z of the base.

    Returns:
        Pose (4, 4) pose_base_to_world, or None where no base was given.

    Raises:
        InvalidInput: If a value is not finite.
    """
    if args.base is None:
        return None
    import numpy as np
    from scipy.spatial.transform import Rotation

    if not all(math.isfinite(value) for value in args.base):
        raise InvalidInput(f"--base is {args.base}: expected finite metres and radians X Y Z YAW")
    pose = np.eye(4)
    pose[:3, 3] = args.base[:3]
    upright = np.eye(3)
    if scene.up is not None and scene.up[2] < 1.0:
        # Yaw 0 is the least turn that brings z to up; upside down, it goes about x.
        axis = np.cross([0.0, 0.0, 1.0], scene.up)
        length = float(np.linalg.norm(axis))
        turn = np.array([np.pi, 0.0, 0.0]) if length < 1e-12 else axis / length * np.arccos(scene.up[2])
        upright = Rotation.from_rotvec(turn).as_matrix()
    pose[:3, :3] = upright @ Rotation.from_euler("z", args.base[3]).as_matrix()
    return pose
