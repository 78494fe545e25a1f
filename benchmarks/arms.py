"""Arms of others, from the files that packages ship, tried end to end; writes the table of docs/robots.md.

Usage: python -m topple.benchmarks.arms [NAME...] [--write docs/robots.md]
       python -m topple.benchmarks.arms --no-grasp [NAME...] [--write docs/transcripts/arms.md]

It needs the extra `arms`, and for some arms packages whose files alone are read (`BARE`): what those depend
on, among it torch, is not needed. With names, the rows of those arms are written anew and the others stay.
With `--no-grasp` all of arms.toml are asked as by `topple robot --no-grasp`, a line each with the cause where
one is not accepted.
"""

import argparse
import re
import sys
import textwrap
from collections import Counter
from dataclasses import dataclass, replace
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

import msgspec
import numpy as np

from topple.benchmarks.markdown import markdown_table
from topple.planner.cli.console import in_options
from topple.planner.execution.examine import Examined, examine
from topple.planner.planning.plan import plan
from topple.robots.arm.arm import Arm
from topple.robots.arm.gripper_file import GripperFile
from topple.robots.catalog import robot
from topple.robots.catalog.described import DESCRIPTIONS
from topple.robots.catalog.own_arm import tool_advice
from topple.topology.base.errors import InvalidInput, NotInstalled, ToppleError

BARE = "pip install --no-deps franky-sim robosuite mani-skill"
"""Installs the packages whose files are read and whose code is not run."""
HEADINGS = (
    "arm", "package", "hand", "joints", "reach m", "free of self-collision %", "inverse kinematics %",
    "plan verified", "grasp in PyBullet",
)  # fmt: skip
BEGIN, END = "<!-- arms: begin -->", "<!-- arms: end -->"
VERDICTS = ("accepted", "below the bar", "no tool", "refused")


@dataclass(frozen=True)
class Shipped:
    """An arm that a package ships.

    Attributes:
        urdf: The file, from the package's folder.
        hand: What it holds with, in the table.
        gripper: What is said beside the URDF: the name of a hand, or what a gripper file holds.
        srdf: Its SRDF, likewise from the folder; found beside the URDF where left out.
        group: The SRDF's group that is the arm.
        tried: Whether it is planned for and run, too.
        name: Name in the table.
        package: The distribution.
    """

    urdf: str
    hand: str = "its own"
    gripper: str | GripperFile | None = None
    srdf: str | None = None
    group: str | None = None
    tried: bool = False
    name: str = ""
    package: str = ""

    @property
    def file(self) -> str:
        """The URDF, from where packages are installed."""
        return f"{DESCRIPTIONS.get(self.package, self.package.replace('-', '_'))}/{self.urdf}"

    def located(self) -> Path:
        """Where the URDF is.

        Raises:
            NotInstalled: The package is not installed.
            InvalidInput: One of `BARE` is not.
        """
        try:
            return Path(str(distribution(self.package).locate_file(self.file)))
        except PackageNotFoundError as error:
            missing = f"{self.package}, which ships the arm, is not installed"
            if self.package in BARE.split():
                raise InvalidInput(f"{missing}: {BARE}") from error
            raise NotInstalled(missing, "arms") from error

    def arm(self) -> Arm:
        """Read it.

        Raises:
            NotInstalled: A package is not installed.
            InvalidInput: It cannot be used, or a package of `BARE` is not installed.
        """
        place = self.located()
        srdf = None if self.srdf is None else str(place).removesuffix(self.urdf) + self.srdf
        return robot(place, self.gripper, srdf=srdf, group=self.group)


SHIPPED = [
    replace(arm, name=name, package=package)
    for package, arms in msgspec.toml.decode(
        Path(__file__).with_suffix(".toml").read_bytes(), type=dict[str, dict[str, Shipped]]
    ).items()
    for name, arm in arms.items()
]
TRIED = [shipped for shipped in SHIPPED if shipped.tried]
"""What is planned for and run; the tests hold every one but those that the table says fail to it."""


def asked(shipped: Shipped) -> tuple[str, str]:
    """Ask of an arm what `topple robot --no-grasp` says.

    Args:
        shipped: The arm.

    Returns:
        One of `VERDICTS`, and the arm's joints and poses solved, or the cause.

    Raises:
        NotInstalled: Its package is not installed.
    """
    shipped.located()
    try:
        found = examine(shipped.arm(), grasp=False)
    except InvalidInput as error:
        return "refused", _cause(str(error))
    if not found.arm.tools:
        return "no tool", _cause(tool_advice(found.arm))
    words = f"{len(found.arm.joints)} joints, {_solved(found)} % of {found.poses} poses"
    return ("accepted" if found.ok else "below the bar"), words


def _cause(refusal: str) -> str:
    """What is wrong with a file, without its name and what was expected."""
    cause = re.split(r": (?:expected|write|see) |, so |, driven by ", refusal.partition(": ")[2])[0]
    return textwrap.shorten(in_options(cause), 100, placeholder=" ...")


def _solved(found: Examined) -> str:
    return f"{100 * found.solved / max(found.poses, 1):.1f}"


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
        name = found.grasped.trial.name
        checked = plan(scene, [name], found.arm, pose_base_to_world=np.eye(4)).verify(scene)
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
    return [
        shipped.name, shipped.package, shipped.hand, f"{len(found.arm.joints)}", f"{found.reach:.2f}",
        f"{100 * found.free:.0f}", _solved(found), "**no**" if wrong else "yes", run,
    ]  # fmt: skip


def main(arguments: list[str] | None = None) -> int:
    """Try the arms named, or all, and print the table, or write it into a page."""
    parser = argparse.ArgumentParser(prog="python -m topple.benchmarks.arms", description=main.__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help="parts of names of arms (all)")
    parser.add_argument("--no-grasp", action="store_true", help="ask all of arms.toml, and plan for none")
    parser.add_argument("--write", type=Path, metavar="PAGE", help="write the table there, docs/robots.md")
    args = parser.parse_args(arguments)
    if args.no_grasp and args.names and args.write:
        parser.error("--no-grasp writes the answers of all arms: leave the names out")
    chosen = [
        shipped
        for shipped in (SHIPPED if args.no_grasp else TRIED)
        if not args.names or any(name.lower() in shipped.name.lower() for name in args.names)
    ]
    before = "" if args.write is None else args.write.read_text(encoding="utf-8")
    head, _, rest = before.partition(BEGIN)
    before, _, tail = rest.partition(END)
    if args.no_grasp:
        lines = _lines(chosen)
    else:
        lines = markdown_table(HEADINGS, _together(before, [_tried(each) for each in chosen]), range(3, 7))
    if args.write is None:
        sys.stdout.write("\n".join(lines) + "\n")
    else:
        text = "\n".join([head + BEGIN, *lines, END + tail])
        args.write.write_text(text, encoding="utf-8")
    return 0


def _lines(chosen: list[Shipped]) -> list[str]:
    """A block of what was said of each arm, those accepted first, with how many there are."""
    said = [(*asked(shipped), shipped) for shipped in chosen]
    said.sort(key=lambda each: VERDICTS.index(each[0]))
    count = Counter(verdict for verdict, _, _ in said)
    lines = [f"{verdict:14}{each.name}, {each.hand}: {words}" for verdict, words, each in said]
    return ["```text", *lines, "```", ", ".join(f"{count[verdict]} {verdict}" for verdict in VERDICTS) + "."]


def _tried(shipped: Shipped) -> list[str]:
    """The row of an arm, for which is planned and which takes the block."""
    found = examine(shipped.arm(), progress=lambda line: _say(f"{shipped.name}: {line}"))
    wrong = planned(found)
    failed = "" if found.grasped is None or found.grasped.success else "; ".join(found.grasped.why)
    _say(f"{shipped.name}: {wrong or 'plan verified'}; {failed or 'grasp held'}")
    return row(shipped, found, wrong)


def _together(table: str, rows: list[list[str]]) -> list[list[str]]:
    """The rows of a table and new ones, which replace those of the same arms, as `TRIED` has them."""
    lines = [line for line in table.splitlines() if line.startswith("|")][2:]
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    known = {row[0]: row for row in [*cells, *rows]}
    return [known[shipped.name] for shipped in TRIED if shipped.name in known]


def _say(line: str) -> None:
    sys.stderr.write(line + "\n")


if __name__ == "__main__":
    sys.exit(main())
