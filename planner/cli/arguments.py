"""The options of the sub-commands, each described once: a name means the same wherever it is taken."""

import argparse
import math
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from topple.robots.engines import DEFAULT_ENGINE, ENGINES


class ShowVersion(argparse.Action):
    """Looks the version up only when asked: the metadata takes longer than the rest of the start."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:  # type: ignore
        """Print the version and leave."""
        from importlib.metadata import version

        from topple.topology.base.errors import DISTRIBUTION
        from topple.topology.kernels.compiled import path_in_words

        sys.stdout.write(f"topple {version(DISTRIBUTION)}, {path_in_words()}\n")
        parser.exit()


def _above(least: float, number: Callable[[str], float], expected: str) -> Callable[[str], float]:
    """A type of numbers above a least one, and finite."""

    def read(text: str) -> float:
        try:
            value = number(text)
        except ValueError:
            value = least
        if not least < value < float("inf"):
            raise argparse.ArgumentTypeError(f"{text} is not {expected}")
        return value

    return read


positive = _above(0.0, float, "a finite number above 0")
from_zero = _above(math.nextafter(0.0, -1.0), float, "a finite number from 0 on")
count = _above(0, int, "a whole number from 1 on")
_seed = _above(-1, int, "a whole number from 0 on")


def value(metavar: str | None, purpose: str, kind: Callable[[str], Any] = str, **more: Any) -> dict[str, Any]:
    """An option with a value, as keywords of `add_argument`."""
    return {"metavar": metavar, "type": kind, "help": purpose, **more}


def switch(purpose: str) -> dict[str, Any]:
    """An option that is given or not, likewise."""
    return {"action": "store_true", "help": purpose}


def names(purpose: str, **more: Any) -> dict[str, Any]:
    """An option with several names, which may be given several times, likewise."""
    return {"nargs": "+", "action": "extend", "metavar": "NAME", "help": purpose, **more}


def numbers(metavars: str, purpose: str) -> dict[str, Any]:
    """An option with so many numbers, likewise."""
    return {"nargs": len(metavars.split()), "type": float, "metavar": (*metavars.split(),), "help": purpose}


# fmt: off
OPTIONS: dict[str, dict[str, Any]] = {
    "--max-mb": value(
        "MB", "what a file of a scene may unpack to (268): more is refused before it is read", positive),
    "--allow-outside": switch("let scene.json name files that are not below its folder"),
    "--fixed": names("objects that never move"),
    "--up": numbers("X Y Z", "direction against gravity"),
    "--seed": value("N", "seed of every random draw (0)", _seed, default=0),
    "--json": switch("JSON on stdout and nothing else"),
    "--version": {"action": ShowVersion, "nargs": 0, "help": "print the version and leave"},
    # what one format of scenes has and the others have not
    "--view": value("NAME", "of a recorded pile: full, view1 or view3 (full)"),
    "--image": value("N", "which image of a BOP scene or frame of a recording (its first)", int),
    "--keyframe": value("NAME", "name or number of a keyframe of an MJCF scene (initial)"),
    "--models": value(
        "DIR", "known models, NAME.obj or NAME/mesh.obj: each takes the place of what was seen of the object "
        "of its name where it fits; without DIR the models of a BOP scene, not its depth",
        nargs="?", const=True),
    "--depth": value("TOPIC", "topic of a recording's depth images, or clouds with labels (the only one)"),
    "--info": value("TOPIC", "topic of its camera's intrinsics (the only one)"),
    "--masks": value(
        "TOPIC|FILE", "topic of a recording's masks (the only one); or a file of masks for an RGB-D frame "
        "without any, as SAM gives them: .json of run lengths, .npy, .npz"),
    # answers
    "-o/--output": value("PATH", "where the answer is written"),
    "--report": value("FILE", "where the answer is drawn for people"),
    "--verify": switch("check the answer by other means"),
    # many scenes
    "--jobs": value("N", "several scenes: so many processes (one a core)", count),
    "--cluster": value("ADDRESS", "several scenes: the workers of a dask scheduler"),
    "--same-labels": switch("a label means the same object in the masks of all views"),
    # relations and orders
    "--rule": value("NAME", "what relates: robust, plain or a plugin's (robust)"),
    "--orderer": value("NAME", "what orders: fewest, cautious or a plugin's (fewest; run, demo: cautious)"),
    "--deviation": value("M", "distance in metres that still counts as touching (estimated)", float),
    "--plain": switch(
        "the paper's rule to the letter of its Table 1 with a deviation of 0.002 unless given"),
    "--all-pairs": switch("list pairs that are far apart as well"),
    "--hands": value(
        "N", "number of hands: where objects hold each other, 1 has no safe order, and 2 or more may", count),
    "--next-view": switch(
        "say from where a camera would see most of what is hidden and decides the order"),
    "--explain": switch("print every step, and everything that carries something"),
    "--build": switch(
        "say in which order to put the objects of this finished arrangement down, and what to hold"),
    "--no-margins": switch("verdicts alone, without forces and margins: sooner"),
    "--play": switch(
        "also let time start in simulation, and show where what moves is not what statics says"),
    "--mend": value(
        "FILE", "write the least shifts, under 5 mm, that make one scene stand there, as poses in JSON"),

    "--max-objects": value(
        "N", "how many objects a scene may have (500): the work grows with the square of it", count),
    "--masks-as-they-are": switch(
        "answer although the target hangs on a mask that is split, merged, level or twice"),
    # goals
    "--target": names("objects to free, with the fewest removals (all, where no goal is needed)"),
    "--goal": value("TEXT", 'the goal: "lemon within bowl", "red on green on blue", "empty bowl", "sort"'),
    "--to": value(
        "GOAL", "the goal arrangement: another scene of them, what `topple relate --json` wrote, or words "
        "such as cup left of plate"),
    "--match": value(
        None, "by what objects of --to are found: by name, or by shape, whatever they are called (name)",
        choices=("name", "shape"), default="name"),
    # arms
    "--robot": value("NAME", "arm: panda, panda-suction, iiwa, xarm6, FILE.urdf or one a package ships"),
    "--gripper": value(
        "FILE", "with FILE.urdf: its [jaw], [cup], [hand] or [arm], in TOML; the URDF of a hand to mount; or "
        "wsg50; a parallel jaw of the URDF is recognised"),
    "--srdf": value(
        "FILE",
        "with FILE.urdf: groups and links that do not collide (the SRDF of the same name beside it)"),
    "--group": value("NAME", "the SRDF's group that is the arm, where it has several"),
    "--base": numbers(
        "X Y Z YAW",
        "where the arm stands, in metres and radians about up (the scene's robot_base, or searched)"),
    "--joints": value(
        "Q", "joint values of the robot in its own picture [rad, m]: what is seen at it is nobody's", float,
        nargs="+"),
    "--second-base": numbers(
        "X Y Z YAW", "where a second such arm stands, which holds what would not stand meanwhile (one arm)"),
    "--away": {"nargs": "+", "metavar": ("WHERE", "NUMBER"), "help":
        "where taken objects go: table, lift (15 cm clear of everything, for a skill of your own), bin, "
        "zone X0 Y0 X1 Y1 (level and free), hand-over X Y Z; metres from the arm's base (table)"},
    "--bin": numbers(
        "X Y Z YAW SX SY SZ",
        "where the bin of --away bin stands, and its size (40 x 30 x 20 cm, where there is room)"),
    "--clamped": names(
        "what a fixture, such as a vice, keeps where it stands until the hand holds it", default=[]),
    "--budget": value(
        "S", "wall-clock seconds that the answer may take; what takes longer fails", positive),
    "--upright": names("what is kept upright while it is carried, with what is in it", default=[]),
    "--allow-drop": switch(
        "release an object even if no stable place is in reach; the step is marked `falls`"),
    "--no-grasp": switch("leave out the grasp in simulation"),
    # simulation
    "--cameras": value(None, "depth cameras that look on (3)", int, choices=(1, 2, 3), default=3),
    "--mask-noise": value(
        "PIXELS", "how far edges of masks are off, as a segmentation's; one in twenty is missing then (0)",
        float, default=0.0),
    "--wrist-camera": switch("the arm carries one more, for a second look before a doubtful step"),
    "--ahead": switch("choose the next step while the arm acts, on another core; it is done where the look "
        "shows what was foreseen"),
    "--engine": value(
        None, f"what plays the world: PyBullet, or MuJoCo (extra 'mujoco'; one arm) ({DEFAULT_ENGINE})",
        choices=ENGINES, default=DEFAULT_ENGINE),
    "--video": value("FILE", "write a film of it, out.mp4, with the extra 'video'"),
    "--shuffle-labels": switch("keep no names between looks: match what is seen with what is remembered"),
    "--lerobot": value("DIR", "add it to a dataset of LeRobot v3 there", Path),
    "--list": switch("say which scenes there are, and leave"),
    # servers
    "--plan": value("FILE", "a plan of the scene, whose steps are shown (its order)"),
    "--host": value("ADDRESS", "who may connect (127.0.0.1; any: 0.0.0.0)", default="127.0.0.1"),
    "--port": value("N", "where to listen, or next to it (8080)", int, default=8080),
    "--root": value("DIR", "the folder of all that is read and written (.)", default="."),
}
# fmt: on

FORMATS = ("--view", "--image", "--keyframe", "--models", "--depth", "--info", "--masks")
GRIPPER = ("--gripper", "--srdf", "--group")
SEEN_ROBOT = (*GRIPPER, "--base", "--joints")
SIMULATION = ("--cameras", "--mask-noise", "--wrist-camera", "--ahead", "--engine", "--video")
COMMON = ("--max-mb", "--allow-outside", "--fixed", "--up", "--seed", "--json", "--version")

GROUPS = {
    "scene": ("--fixed", "--up", *FORMATS, "--masks-as-they-are"),
    "question": ("--target", "--goal", "--to", "--match", "--away", "--bin", "--rule", "--orderer"),
    "robot": ("--robot", *SEEN_ROBOT, "--second-base", "--clamped"),
    "simulation": SIMULATION,
    "advanced": ("--max-mb", "--allow-outside", "--max-objects", "--budget", "--seed", "--jobs", "--cluster"),
}
"""Under which heading the help of a command has an option; others are the command's own."""


def add(parser: argparse.ArgumentParser, *names: str, more: str = "", **changed: Any) -> None:
    """Add some of `OPTIONS`; `more` is what a command has to say beside, `changed` its default."""
    for name in names:
        about = {**OPTIONS[name], **changed, "help": OPTIONS[name]["help"] + more}
        _group(parser, name).add_argument(*name.split("/"), **about)


def _group(parser: argparse.ArgumentParser, option: str) -> Any:
    """The part of the help that an option belongs to."""
    title = next((title for title, names in GROUPS.items() if option in names), None)
    if title is None:
        return parser
    known = {group.title: group for group in parser._action_groups}
    return known[title] if title in known else parser.add_argument_group(title)


def add_scenes(
    parser: argparse.ArgumentParser,
    metavar: str = "SCENE",
    purpose: str = ".npz of clouds, folder of cloud or mesh files, RGB-D .npz / .npy, BOP scene, or ROS bag",
) -> None:
    """Add the scenes, or what takes their place, with the options of their formats."""
    parser.add_argument("scenes", nargs="*", metavar=metavar, help=purpose)
    add(parser, *FORMATS)


def add_many(parser: argparse.ArgumentParser) -> None:
    """Add scenes, where they are worked on, one of the two, and where answers to them are kept."""
    add_jobs(parser)
    words = ": a line of JSON for each scene; the same command goes on where it was stopped"
    add(parser, "-o/--output", more=words)
    add_scenes(parser, "SCENE...")


def add_jobs(parser: argparse.ArgumentParser) -> None:
    """Add where many scenes are worked on: one of the two."""
    where = _group(parser, "--jobs").add_mutually_exclusive_group()
    for name in ("--jobs", "--cluster"):
        where.add_argument(name, **OPTIONS[name])


def add_robot(parser: argparse.ArgumentParser) -> None:
    """Add the arm and its place."""
    add(parser, "--robot", more=" (panda)", default="panda")
    add(parser, *SEEN_ROBOT)


def add_task(parser: argparse.ArgumentParser) -> None:
    """Add what shall be done, names to free, words, or how things shall lie, and the arm that does it."""
    add(parser, "--target", "--goal", "--to", "--match")
    add_robot(parser)
