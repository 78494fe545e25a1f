"""What the options of a sub-command say: the scenes, how they are read, what relates and orders them."""

import argparse
import os
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from inspect import signature
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from topple.planner.cli.robot_options import seen_robot

if TYPE_CHECKING:
    from topple.planner.planning.plan_format import Plan
    from topple.planner.planning.step import Orderer, Task
    from topple.topology.base.arrays import FloatArray
    from topple.topology.relations.relate import Relations
    from topple.topology.scene.scene import Scene

Answer = TypeVar("Answer")

_SCENE_SUFFIXES = (".npz", ".npy")
_OF_FORMATS = ("image", "keyframe", "models", "depth", "info", "view", "masks")  # of one each
_LISTS = ("fixed", "target", "clamped", "upright")  # options that take one name after the other


def keywords(function: Callable[..., object], args: argparse.Namespace, **own: Any) -> dict[str, Any]:
    """Collect a function's arguments from the options that are called as its parameters.

    Args:
        function: The function.
        args: The parsed arguments.
        **own: What it takes otherwise, in place of options of that name.
    """
    known = signature(function).parameters
    return {**{name: given for name, given in vars(args).items() if name in known}, **own}


def rule_of(args: argparse.Namespace) -> "Callable[[Scene], Relations] | None":
    """Make the function that relates a scene by the named rule; None where none was named.

    Raises:
        InvalidInput: There is no such rule, or it is broken.
    """
    if args.rule is None:
        return None
    from topple.topology.relations.relate import RULES, relate

    _ = RULES[args.rule]  # refused before anything is read
    return partial(relate, rule=args.rule)


def orderer_of(args: argparse.Namespace) -> "Orderer | None":
    """The orderer that was named; None where none was.

    Raises:
        InvalidInput: There is no such orderer, or it is broken.
    """
    if args.orderer is None:
        return None
    from topple.planner.planning.step import ORDERERS

    return ORDERERS[args.orderer]


def scene_paths(args: argparse.Namespace, *, many: bool = True) -> list[str]:
    """Say which scenes were meant.

    A list option before the scene swallows it, `--fixed 1 scene.npz`: from the first value on that is an
    existing scene file (or, with no scene given otherwise, that exists at all), its values are scenes. So is
    what `--models` swallows, which needs no folder. Bare names after a scene, `scene.npz plate`, are targets.

    Args:
        args: The parsed arguments; `scenes` and the list options are put right.
        many: Whether more than one scene is allowed.

    Returns:
        At least one path.
    """
    paths = list(args.scenes)
    for option in _LISTS:
        names: list[str] = getattr(args, option, None) or []
        start = next((i for i in range(1, len(names)) if _is_scene(names[i], anything=not paths)), len(names))
        paths += names[start:]
        del names[start:]
    models = getattr(args, "models", None)
    if isinstance(models, str) and (_is_scene(models, anything=not paths) or _is_bop(models)):
        paths, args.models = [*paths, models], True
    if "target" in args and not args.target:
        args.target = [path for path in paths[1:] if _is_name(path)] or None
        paths = [path for path in paths if path not in (args.target or ())]
    if not paths:
        args.parser.error("no scene given: expected an .npz, an .npy or a folder")
    if len(paths) > 1 and not many:
        args.parser.error(f"one scene expected, {len(paths)} given: {' '.join(paths)}")
    args.scenes = paths
    return paths


def _is_scene(value: str, *, anything: bool) -> bool:
    return os.path.exists(value) and (anything or value.lower().endswith(_SCENE_SUFFIXES))


def _is_name(value: str) -> bool:
    """Whether a value is no path: nothing of that name is there, and it looks like none."""
    return not os.path.exists(value) and os.sep not in value and "." not in value and value != "-"


def _is_bop(value: str) -> bool:
    return os.path.exists(os.path.join(value, "scene_gt.json"))


@dataclass(frozen=True)
class Reading:
    """How scenes are read, as the options say; it can go to another process.

    Attributes:
        fixed: Names that never move.
        up: Direction against gravity, or None.
        max_bytes: What a file may unpack to, or None for as much as is usual.
        allow_outside: Whether scene.json may name files that are not below its folder.
        options: What was given of the options that one format alone has, and the folder of known models.
        robot: What says where in a scene the bodies of a robot in its picture are; none without --joints.
        as_they_are: Whether masks are trusted that are wrong in kind.
        in_words: Whether people read the answer, who call an object by more than its label's number.
    """

    fixed: tuple[str, ...]
    up: tuple[float, ...] | None
    max_bytes: int | None
    allow_outside: bool
    options: Mapping[str, Any]
    robot: "Callable[[Scene], Sequence[FloatArray]] | tuple[()]" = ()
    as_they_are: bool = False
    in_words: bool = False

    @staticmethod
    def of(args: argparse.Namespace) -> "Reading":
        """Take over the parsed arguments."""
        up = None if args.up is None else tuple(args.up)
        most = None if args.max_mb is None else int(1e6 * args.max_mb)
        options = {key: value for key in _OF_FORMATS if (value := getattr(args, key, None)) is not None}
        trusted = getattr(args, "masks_as_they_are", False)
        in_words = not (args.json or ("cluster" in args and vars(args).get("output")))
        given = (tuple(args.fixed or ()), up, most, args.allow_outside, options)
        return Reading(*given, seen_robot(args), trusted, in_words)

    def scene(self, path: str) -> "Scene":
        """Read the scene at a path.

        Raises:
            InvalidInput: If the path holds no scene or a broken one.
        """
        from topple.topology.io import load_scene

        found = load_scene(
            path, fixed=self.fixed, up=self.up, max_bytes=self.max_bytes, robot_bodies=self.robot,
            allow_outside=self.allow_outside, **self.options,
        )  # fmt: skip
        return found.with_masks_as_they_are() if self.as_they_are else found

    def said(self, scene: "Scene", answer: Answer) -> Answer:
        """An answer to a scene, in words with names for its numbers."""
        from topple.planner.decide.names import spoken

        return spoken(scene, answer) if self.in_words else answer


def read_scene(args: argparse.Namespace, path: str) -> "Scene":
    """Read one of the scenes as the options say, for what is said of it too; see `Reading.scene`."""
    reading = Reading.of(args)
    scene = reading.scene(path)
    args.said = partial(reading.said, scene)
    return scene


def read_goal(reading: Reading, goal: str) -> "Scene | str | dict[str, Any]":
    """Read the goal of --to: words, a document of relations, or a scene.

    Args:
        reading: How scenes are read.
        goal: The words or the path.

    Raises:
        InvalidInput: It is empty, or cannot be read.
    """
    from topple.planner.rearranging.words import is_words
    from topple.topology.base.errors import InvalidInput
    from topple.topology.io.limits import read_bytes
    from topple.topology.io.strict_json import read_json

    if not goal.strip():
        raise InvalidInput('--to is empty: expected a scene, relations.json, or words as "cup left of plate"')
    if is_words(goal):
        return goal
    path = Path(goal)
    if path.suffix != ".json" or not path.is_file():
        return reading.scene(goal)
    document = read_json(read_bytes(path, goal), goal)
    if not isinstance(document, dict) or "relations" not in document:
        raise InvalidInput(f"{goal}: expected what `topple relate --json` prints, an object with 'relations'")
    return document


def goal_of(args: argparse.Namespace) -> "str | list[str] | Task":
    """Say what is wanted.

    Args:
        args: The parsed arguments, scenes told apart from targets already.

    Returns:
        The goal's words, the names to free, or the task to make things lie as --to says.

    Raises:
        InvalidInput: That scene cannot be read.
    """
    if sum((bool(args.target), args.goal is not None, args.to is not None)) != 1:
        args.parser.error("give one of --target NAME, --goal TEXT and --to GOAL")
    if args.to is not None:
        from topple.planner.rearranging.arrangement import Arrangement
        from topple.planner.rearranging.task import (
            ArrangementTask,
            DescribedTask,
            RelatedTask,
            SameShapesTask,
        )

        scene = read_goal(Reading.of(args), args.to)
        if isinstance(scene, str):
            return DescribedTask(scene)
        if isinstance(scene, dict):
            return RelatedTask(scene)
        return SameShapesTask(scene) if args.match == "shape" else ArrangementTask(Arrangement(scene))
    return args.goal if args.goal is not None else args.target


def read_plan(path: str) -> "Plan":
    """Read a plan from a file, or from stdin where the path is "-".

    Raises:
        InvalidInput: There is no plan, or it is larger than a file may be.
    """
    from topple.planner.planning.plan_format import plan_from_json

    return plan_from_json(*document_at(path))


def document_at(path: str) -> tuple[bytes, str]:
    """The bytes of a document and what it is called: a file, or stdin where the path is "-".

    Raises:
        InvalidInput: It cannot be read, or is larger than a file may be.
    """
    from topple.topology.io.limits import check_size, read_given
    from topple.topology.io.tolerances import MOST_BYTES

    if path == "-":
        data = sys.stdin.buffer.read(MOST_BYTES + 1)
        check_size(len(data), "stdin")
        return data, "stdin"
    return read_given(Path(path), path), path
