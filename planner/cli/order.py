"""`topple order`: which object to take next, and why."""

import argparse
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

from topple.planner.cli.console import complain, print_json
from topple.planner.cli.main import DONE, NO_SAFE_PLAN
from topple.planner.cli.options import (
    Reading,
    add_common,
    add_max_objects,
    add_orderer,
    add_rule,
    add_target,
    for_each_scene,
    order_by,
    orderer_of,
    positive,
    rule_of,
    scene_paths,
)
from topple.planner.cli.progress import Progress
from topple.planner.cli.robot_options import add_gripper, arm_of
from topple.planner.cli.tables import print_assumptions, print_order

if TYPE_CHECKING:
    from topple.planner.planning.step import Orderer
    from topple.topology.relations import Relations
    from topple.topology.scene import Scene


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of `topple order`.

    Args:
        parser: The sub-command's parser.
    """
    add_common(parser, scenes="many")
    add_target(parser)
    add_max_objects(parser)
    add_rule(parser)
    add_orderer(parser)
    parser.add_argument(
        "--verify", action="store_true", help="check the dependencies in simulation: take every object away"
    )
    parser.add_argument(
        "--budget",
        type=positive,
        metavar="S",
        help="seconds --verify may take; the best answer so far counts",
    )
    parser.add_argument(
        "--robot",
        metavar="NAME",
        help="say what bars the gripper's way: panda, panda-suction, iiwa, xarm6 or FILE.urdf",
    )
    add_gripper(parser)


def execute(args: argparse.Namespace) -> int:
    """Order the objects of every scene.

    Args:
        args: The parsed arguments.

    Returns:
        Exit code 0, 1 where a cycle allows no safe order, or 2 where a scene cannot be read.
    """
    if args.budget is not None and not args.verify:
        args.parser.error("--budget bounds --verify: give both or neither")
    if args.gripper is not None and not args.robot:
        args.parser.error("--gripper is what the robot holds with: give both or neither")
    if args.orderer is not None and (args.verify or args.robot):
        args.parser.error("--verify and --robot are about topple's own order: leave out --orderer")
    orderer, relating = orderer_of(args), rule_of(args)
    if args.max_objects is not None:
        from topple.topology.rule.relate import relate

        relating = partial(relating or relate, most_objects=args.max_objects)
    arm = arm_of(args) if args.robot else None
    options = {"seed": args.seed, "verify": args.verify, "budget": args.budget, "robot": arm}
    scene_paths(args)  # which may be among the names of --fixed and --target
    work = partial(_answer, Reading.of(args), args.target, relating, orderer, options)
    by_scenes = not (args.verify or args.robot)  # those take all cores, and import what prints when imported
    with Progress("order") as progress:
        return for_each_scene(args, work, partial(_show, args.json), progress, processes=by_scenes)


@dataclass(frozen=True)
class _Answer:
    """What is shown of an order."""

    document: dict[str, Any]
    movable: int
    unresolved: tuple[tuple[str, ...], ...]


def _answer(
    reading: Reading,
    target: list[str] | None,
    relating: "Callable[[Scene], Relations] | None",
    orderer: "Orderer | None",
    options: dict[str, Any],
    path: str,
) -> _Answer:
    """The order of a scene file."""
    from topple.planner.planning.order import order

    scene = reading.scene(path)
    relations = None if relating is None else relating(scene)
    if orderer is None:
        found = order(scene, target, relations=relations, **options)
    else:
        found = order_by(orderer, scene, target, relations, options["seed"])
    return _Answer(found.to_json(), len(scene.movable), tuple(found.unresolved))


def _show(as_json: bool, path: str, answer: _Answer) -> int:
    if as_json:
        print_json({"scene": path, **answer.document})
    else:
        print_order(path, answer.document, answer.movable)
        print_assumptions(answer.document["assumptions"])
    for cycle in answer.unresolved:
        complain(f"{path}: no safe order: {' -> '.join([*cycle, cycle[0]])} is a cycle, each has to go first")
    return NO_SAFE_PLAN if answer.unresolved else DONE
