"""Arms of others, from the files that packages ship, tried end to end; writes the table of docs/robots.md.

Usage: python -m topple.benchmarks.arms [NAME...] [--write docs/robots.md]

It needs the extra `arms`, and for some arms packages whose files alone are read (`BARE`): what those depend
on, among it torch, is not needed. With names, the rows of those arms are written anew and the others stay.
"""

import argparse
import sys
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

import numpy as np

from topple.benchmarks.markdown import markdown_table
from topple.planner.execution.examine import Examined, examine
from topple.planner.planning.plan import plan
from topple.robots.arm.arm import Arm
from topple.robots.arm.gripper_file import ArmPart, Cup, GripperFile, Hand
from topple.robots.catalog import robot
from topple.topology.base.errors import InvalidInput, NotInstalled, ToppleError

BARE = "pip install --no-deps franky-sim robosuite mani-skill"
"""Installs the packages whose files are read and whose code is not run."""
ROBOTS = "cmeel.prefix/share/example-robot-data/robots"
HEADINGS = (
    "arm", "package", "hand", "joints", "reach m", "free of self-collision %", "inverse kinematics %",
    "plan verified", "grasp in PyBullet",
)  # fmt: skip
BEGIN, END = "<!-- arms: begin -->", "<!-- arms: end -->"


@dataclass(frozen=True)
class Shipped:
    """An arm that a package ships.

    Attributes:
        name: Name in the table.
        package: The distribution.
        urdf: The file, from where the distribution is installed.
        hand: What it holds with, in the table.
        gripper: What is said beside the URDF; a hand's file is in `hand_package`.
        srdf: Its SRDF, likewise.
        hand_package: The distribution of the hand.
    """

    name: str
    package: str
    urdf: str
    hand: str
    gripper: GripperFile | None = None
    srdf: str | None = None
    hand_package: str | None = None

    def arm(self) -> Arm:
        """Read it.

        Raises:
            NotInstalled: A package is not installed.
            InvalidInput: It cannot be used, or a package of `BARE` is not installed.
        """
        gripper = self.gripper
        if self.hand_package is not None and gripper is not None and gripper.hand is not None:
            path = str(_located(self.hand_package, gripper.hand.urdf))
            gripper = GripperFile(hand=Hand(urdf=path, link=gripper.hand.link, offset=gripper.hand.offset))
        srdf = None if self.srdf is None else _located(self.package, self.srdf)
        return robot(_located(self.package, self.urdf), gripper, srdf=srdf)


def _located(package: str, path: str) -> Path:
    try:
        return Path(str(distribution(package).locate_file(path)))
    except PackageNotFoundError as error:
        missing = f"{package}, which ships the arm, is not installed"
        if package in BARE.split():
            raise InvalidInput(f"{missing}: {BARE}") from error
        raise NotInstalled(missing, "arms") from error


ROBOTIQ = GripperFile(hand=Hand(urdf="airo_models/grippers/robotiq_2f_85/urdf/robotiq_2f_85.urdf"))
SCHUNK = GripperFile(hand=Hand(urdf="airo_models/grippers/schunk_egk40_magneto/schunk_egk40_magneto.urdf"))
WSG50 = GripperFile(hand=Hand(urdf="wsg50"))
OUT = [0.0, 0.0, 0.0, 0.0, np.pi / 2, 0.0]  # where x, not z, points out of the flange
FETCH = [
    "shoulder_pan_joint", "shoulder_lift_joint", "upperarm_roll_joint", "elbow_flex_joint",
    "forearm_roll_joint", "wrist_flex_joint", "wrist_roll_joint",
]  # fmt: skip
"""The arm's joints: that URDF has three more for its base, which would be the first of the chain."""

SHIPPED = (
    Shipped(
        "Universal Robots UR5", "example-robot-data", f"{ROBOTS}/ur_description/urdf/ur5_robot.urdf",
        "Robotiq 2F-85", ROBOTIQ, hand_package="airo-models",
    ),
    Shipped(
        "Universal Robots UR10", "example-robot-data", f"{ROBOTS}/ur_description/urdf/ur10_robot.urdf",
        "Schunk EGK 40", SCHUNK, hand_package="airo-models",
    ),
    Shipped(
        "Universal Robots UR5e", "airo-models", "airo_models/arms/ur5e/ur5e.urdf", "Schunk EGK 40", SCHUNK,
        hand_package="airo-models",
    ),
    Shipped(
        "UFACTORY xArm7", "example-robot-data", f"{ROBOTS}/xarm_description/urdf/xarm7.urdf", "Schunk WSG 50",
        WSG50,
    ),
    Shipped(
        "Franka Panda", "example-robot-data", f"{ROBOTS}/panda_description/urdf/panda.urdf", "its own",
        srdf=f"{ROBOTS}/panda_description/srdf/panda.srdf",
    ),
    Shipped("Franka FR3", "franky-sim", "franky_sim/assets/fr3.urdf", "its own"),
    Shipped(
        "Rethink Sawyer", "robosuite",
        "robosuite/models/assets/bullet_data/sawyer_description/urdf/sawyer_arm.urdf", "Schunk WSG 50", WSG50,
    ),
    Shipped(
        "Fetch", "mani-skill", "mani_skill/assets/robots/fetch/fetch.urdf", "its own",
        GripperFile(arm=ArmPart(joints=FETCH, rest={"torso_lift_joint": 0.2})),
    ),
    Shipped(
        "Kinova Jaco 2, 6 joints", "example-robot-data", f"{ROBOTS}/kinova_description/robots/kinova.urdf",
        "suction cup",
        GripperFile(cup=Cup(link="j2s6s200_end_effector", offset=[0.0, 0.0, 0.05], radius=0.015)),
        srdf=f"{ROBOTS}/kinova_description/srdf/kinova.srdf",
    ),
    Shipped(
        "Rethink Baxter, left arm", "example-robot-data", f"{ROBOTS}/baxter_description/urdf/baxter.urdf",
        "its own", GripperFile(arm=ArmPart(tip="left_gripper_base_link")),
        srdf=f"{ROBOTS}/baxter_description/srdf/baxter_manipulation.srdf",
    ),
    Shipped(
        "PAL TIAGo", "example-robot-data", f"{ROBOTS}/tiago_description/robots/tiago_no_hand.urdf",
        "Schunk WSG 50", GripperFile(hand=Hand(urdf="wsg50", offset=OUT)),
    ),
    Shipped(
        "PAL TIAGo Pro, left arm", "example-robot-data",
        f"{ROBOTS}/tiago_pro_description/robots/tiago_pro.urdf", "its own",
        GripperFile(arm=ArmPart(tip="gripper_left_base_link")),
    ),
    Shipped(
        "Willow Garage PR2, left arm", "example-robot-data", f"{ROBOTS}/pr2_description/urdf/pr2.urdf",
        "its own", GripperFile(arm=ArmPart(tip="l_gripper_palm_link")),
        srdf=f"{ROBOTS}/pr2_description/srdf/pr2.srdf",
    ),
)  # fmt: skip
"""What is tried; the tests hold every one but those that the table says fail to it."""


def planned(found: Examined) -> str:
    """Plan for the block of an arm's trial, and verify the plan by other means.

    Args:
        found: What was found of the arm.

    Returns:
        What is wrong with the plan; empty where every residual is at most zero.
    """
    if found.grasped is None or found.grasped.trial is None:
        return "nothing in reach"
    scene = found.grasped.trial.scene()
    try:
        checked = plan(scene, [found.grasped.trial.name], found.arm, base=np.eye(4)).verify(scene)
    except ToppleError as error:
        return str(error)
    return ", ".join(residual.name for residual in checked.residuals if not residual.ok)


def row(shipped: Shipped, found: Examined, wrong: str) -> list[str]:
    """The cells of a line of the table.

    Args:
        shipped: The arm.
        found: What was found of it.
        wrong: What is wrong with its plan; empty where nothing is.
    """
    run = "yes" if found.grasped is not None and found.grasped.success else "**no**"
    solved = f"{100 * found.solved / max(found.poses, 1):.1f}"
    return [
        shipped.name, shipped.package, shipped.hand, f"{len(found.arm.joints)}", f"{found.reach:.2f}",
        f"{100 * found.free:.0f}", solved, "**no**" if wrong else "yes", run,
    ]  # fmt: skip


def main(arguments: list[str] | None = None) -> int:
    """Try the arms named, or all, and print the table, or write it into a page."""
    parser = argparse.ArgumentParser(prog="python -m topple.benchmarks.arms", description=main.__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help="parts of names of arms (all)")
    parser.add_argument("--write", type=Path, metavar="PAGE", help="write the table there, docs/robots.md")
    args = parser.parse_args(arguments)
    rows: list[list[str]] = []
    for shipped in SHIPPED:
        if args.names and not any(name.lower() in shipped.name.lower() for name in args.names):
            continue
        found = examine(shipped.arm(), progress=lambda line, name=shipped.name: _say(f"{name}: {line}"))
        wrong = planned(found)
        failed = "" if found.grasped is None or found.grasped.success else "; ".join(found.grasped.why)
        _say(f"{shipped.name}: {wrong or 'plan verified'}; {failed or 'grasp held'}")
        rows.append(row(shipped, found, wrong))
    if args.write is None:
        sys.stdout.write("\n".join(markdown_table(HEADINGS, rows, range(3, 7))) + "\n")
        return 0
    text = args.write.read_text(encoding="utf-8")
    head, _, rest = text.partition(BEGIN)
    before, _, tail = rest.partition(END)
    table = "\n".join(markdown_table(HEADINGS, _together(before, rows), range(3, 7)))
    args.write.write_text(f"{head}{BEGIN}\n{table}\n{END}{tail}", encoding="utf-8")
    return 0


def _together(table: str, rows: list[list[str]]) -> list[list[str]]:
    """The rows of a table and new ones, which replace those of the same arms, as `SHIPPED` has them."""
    lines = [line for line in table.splitlines() if line.startswith("|")][2:]
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    known = {row[0]: row for row in [*cells, *rows]}
    return [known[shipped.name] for shipped in SHIPPED if shipped.name in known]


def _say(line: str) -> None:
    sys.stderr.write(line + "\n")


if __name__ == "__main__":
    sys.exit(main())
