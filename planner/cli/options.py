"""Options every sub-command has, and the scenes it was given."""

import argparse
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, cast

from topple.planner.cli.main import ShowVersion

if TYPE_CHECKING:
    from topple.planner.decide.arrange import Order
    from topple.planner.planning.step import Orderer
    from topple.topology.relations import Relations
    from topple.topology.scene import Scene

_SCENE_SUFFIXES = (".npz", ".npy")
_OF_FORMATS = ("image", "models", "depth", "info", "labels", "view")  # options that one format of scenes has
_LISTS = ("fixed", "target")  # options that take one name after the other


def add_common(parser: argparse.ArgumentParser, *, scenes: str | None) -> None:
    """Add what all sub-commands take.

    Args:
        parser: The sub-command's parser.
        scenes: "many" or "one" scene as the positional argument, None for a command without.
    """
    if scenes is not None:
        parser.add_argument(
            "scenes",
            nargs="*",
            metavar="SCENE" if scenes == "one" else "SCENE...",
            help=".npz of clouds, folder of cloud or mesh files, RGB-D .npz / .npy, BOP scene, or ROS bag",
        )
        add_formats(parser)
    parser.add_argument(
        "--max-mb",
        type=_amount,
        metavar="MB",
        help="what a file of a scene may unpack to (268): more is refused before it is read",
    )
    parser.add_argument(
        "--allow-outside",
        action="store_true",
        help="let scene.json name files that are not below its folder",
    )
    parser.add_argument("--fixed", nargs="+", action="extend", metavar="NAME", help="objects that never move")
    parser.add_argument(
        "--up", nargs=3, type=float, metavar=("X", "Y", "Z"), help="direction against gravity"
    )
    parser.add_argument("--seed", type=_seed, default=0, metavar="N", help="seed of every random draw (0)")
    parser.add_argument("--json", action="store_true", help="JSON on stdout and nothing else")
    parser.add_argument("--version", action=ShowVersion, nargs=0, help="print the version and leave")


def add_formats(parser: argparse.ArgumentParser, *, topic_of_labels: bool = True) -> None:
    """Add what one format of scenes has and the others have not.

    Args:
        parser: The sub-command's parser.
        topic_of_labels: False where `--labels` means something else.
    """
    parser.add_argument("--view", metavar="NAME", help="of a recorded pile: full, view1 or view3 (full)")
    parser.add_argument(
        "--image",
        type=int,
        metavar="N",
        help="which image of a BOP scene or frame of a recording (its first)",
    )
    parser.add_argument(
        "--models", action="store_true", default=None, help="the models of a BOP scene, not its depth"
    )
    for name, purpose in (
        ("depth", "of a recording's depth images, or clouds with labels"),
        ("info", "of its camera's intrinsics"),
        ("labels", "of its masks"),
    )[: None if topic_of_labels else -1]:
        parser.add_argument(f"--{name}", metavar="TOPIC", help=f"topic {purpose} (the only one)")


def add_rule(parser: argparse.ArgumentParser) -> None:
    """Add what relates every two objects.

    Args:
        parser: The sub-command's parser.
    """
    parser.add_argument(
        "--rule", metavar="NAME", help="what relates: robust, plain, 9im, features or a plugin's (robust)"
    )


def add_orderer(parser: argparse.ArgumentParser, usual: str = "fewest") -> None:
    """Add what orders the objects.

    Args:
        parser: The sub-command's parser.
        usual: What does where it is not given.
    """
    parser.add_argument(
        "--orderer",
        metavar="NAME",
        help=f"what orders: fewest, cautious, support-tree or a plugin's ({usual})",
    )


def rule_of(args: argparse.Namespace) -> "Callable[[Scene], Relations] | None":
    """What relates a scene by the rule that was named; None where none was.

    Raises:
        InvalidInput: There is no such rule, or it is broken.
    """
    if args.rule is None:
        return None
    from topple.topology.rule.relate import RULES, relate

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


def order_by(
    orderer: "Orderer",
    scene: "Scene",
    targets: list[str] | None,
    relations: "Relations | None",
    seed: int,
) -> "Order":
    """The order that an orderer gives of a scene.

    Args:
        orderer: What orders.
        scene: The scene.
        targets: What is to be freed; everything where None.
        relations: The scene's relations where they are known.
        seed: Of every search.

    Raises:
        InvalidInput: A target is fixed, or the answer is no order.
        UnknownObject: A target, or what the answer takes, is not in the scene.
    """
    from topple.planner.planning.order import check_targets
    from topple.planner.planning.step import ask
    from topple.topology.situation import Situation

    wanted = check_targets(scene, targets) or scene.movable
    return ask(orderer, Situation(scene, relations), wanted, seed=seed)


def add_target(
    parser: argparse.ArgumentParser,
    purpose: str = "what to free, with the fewest removals (everything is cleared)",
) -> None:
    """Add the names to free.

    Args:
        parser: The sub-command's parser.
        purpose: What naming them does, for the help.
    """
    parser.add_argument(
        "--target",
        nargs="+",
        action="extend",
        metavar="NAME",
        help=purpose,
    )


def _seed(text: str) -> int:
    seed = int(text)
    if seed < 0:
        raise argparse.ArgumentTypeError(f"{seed} is negative, expected a whole number from 0 on")
    return seed


def _amount(text: str) -> float:
    amount = float(text)
    if not 0.0 < amount < 1e9:
        raise argparse.ArgumentTypeError(f"{text} is no amount, expected a number above 0")
    return amount


def _count(text: str) -> int:
    count = int(text)
    if count < 1:
        raise argparse.ArgumentTypeError(f"{count} is no count, expected a whole number from 1 on")
    return count


def scene_paths(args: argparse.Namespace, *, many: bool = True) -> list[str]:
    """Say which scenes were meant.

    A list option before the scene swallows it, `--fixed 1 scene.npz`: from the first value on that is an
    existing scene file (or, with no scene given otherwise, that exists at all), its values are scenes.

    Args:
        args: The parsed arguments; `scenes` and the list options are put right.
        many: Whether more than one scene is allowed.

    Returns:
        At least one path.
    """
    paths = list(args.scenes)
    for option in _LISTS:
        values = getattr(args, option, None)
        if not isinstance(values, list):
            continue
        names = cast(list[str], values)
        start = next((i for i in range(1, len(names)) if _is_scene(names[i], anything=not paths)), len(names))
        paths += names[start:]
        del names[start:]
    if not paths:
        args.parser.error("no scene given: expected an .npz, an .npy or a folder")
    if len(paths) > 1 and not many:
        args.parser.error(f"one scene expected, {len(paths)} given: {' '.join(paths)}")
    args.scenes = paths
    return paths


def _is_scene(value: str, *, anything: bool) -> bool:
    return os.path.exists(value) and (anything or value.lower().endswith(_SCENE_SUFFIXES))


def add_max_objects(parser: argparse.ArgumentParser) -> None:
    """Add how many objects a scene may have.

    Args:
        parser: The sub-command's parser.
    """
    parser.add_argument(
        "--max-objects",
        type=_count,
        metavar="N",
        help="how many objects a scene may have (500): the work grows with the square of it",
    )


@dataclass(frozen=True)
class Reading:
    """How scenes are read, as the options say; it can go to another process.

    Attributes:
        fixed: Names that never move.
        up: Direction against gravity, or None.
        most_bytes: What a file may unpack to, or None for as much as is usual.
        allow_outside: Whether scene.json may name files that are not below its folder.
        options: What was given of the options that one format alone has.
    """

    fixed: tuple[str, ...]
    up: tuple[float, ...] | None
    most_bytes: int | None
    allow_outside: bool
    options: Mapping[str, Any]

    @staticmethod
    def of(args: argparse.Namespace) -> "Reading":
        """What the parsed arguments say."""
        up = None if args.up is None else tuple(args.up)
        most = None if args.max_mb is None else int(1e6 * args.max_mb)
        options = {key: value for key in _OF_FORMATS if (value := getattr(args, key, None)) is not None}
        return Reading(tuple(args.fixed or ()), up, most, args.allow_outside, options)

    def scene(self, path: str) -> "Scene":
        """Read a scene.

        Args:
            path: The scene's path.

        Returns:
            The scene.

        Raises:
            InvalidInput: If the path holds no scene or a broken one.
        """
        from topple.topology.io import load_scene

        return load_scene(
            path,
            fixed=self.fixed,
            up=self.up,
            most_bytes=self.most_bytes,
            allow_outside=self.allow_outside,
            **self.options,
        )


def read_scene(args: argparse.Namespace, path: str) -> "Scene":
    """Read one of the scenes as the options say.

    Args:
        args: The parsed arguments.
        path: The scene's path.

    Returns:
        The scene.

    Raises:
        InvalidInput: If the path holds no scene or a broken one.
    """
    return Reading.of(args).scene(path)


def positive(text: str) -> float:
    """A time on the command line.

    Args:
        text: What was typed.

    Returns:
        The number.

    Raises:
        argparse.ArgumentTypeError: It is no finite number above 0.
    """
    number = float(text)
    if not 0.0 < number < float("inf"):
        raise argparse.ArgumentTypeError(f"{text} is no time, expected a number above 0")
    return number
