"""`topple order`: which object to take next, and why."""

import argparse
from typing import TYPE_CHECKING

from topple.planner.cli.console import complain, import_quietly, print_json
from topple.planner.cli.main import DONE, NO_SAFE_PLAN
from topple.planner.cli.options import add_common, add_target, for_each_scene, positive
from topple.planner.cli.progress import Progress
from topple.planner.cli.tables import print_assumptions, print_order

if TYPE_CHECKING:
    from topple.planner.order import Order
    from topple.topology.scene import Scene


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of `topple order`.

    Args:
        parser: The sub-command's parser.
    """
    add_common(parser, scenes="many")
    add_target(parser)
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


def execute(args: argparse.Namespace) -> int:
    """Order the objects of every scene.

    Args:
        args: The parsed arguments.

    Returns:
        Exit code 0, 1 where a cycle allows no safe order, or 2 where a scene cannot be read.
    """
    if args.budget is not None and not args.verify:
        args.parser.error("--budget bounds --verify: give both or neither")
    if args.verify or args.robot:
        import_quietly("pybullet")
    from topple.planner.order import order

    with Progress("order") as progress:

        def act(path: str, scene: "Scene") -> int:
            found = order(
                scene, args.target, seed=args.seed, verify=args.verify, budget=args.budget, robot=args.robot
            )
            progress.clear()
            document = found.to_json()
            if args.json:
                print_json({"scene": path, **document})
            else:
                print_order(path, document, len(scene.movable))
                print_assumptions(document["assumptions"])
            return _judge(path, found)

        return for_each_scene(args, act, progress)


def _judge(path: str, found: "Order") -> int:
    for cycle in found.unresolved:
        complain(f"{path}: no safe order: {' -> '.join([*cycle, cycle[0]])} is a cycle, each has to go first")
    return NO_SAFE_PLAN if found.unresolved else DONE
