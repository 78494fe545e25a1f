"""`topple order`: which object to take next, and why."""

import argparse
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from topple.planner.cli.console import complain, print_json, print_table, print_text
from topple.planner.cli.main import DONE, NO_SAFE_PLAN
from topple.planner.cli.options import add_common, add_target, for_each_scene
from topple.planner.cli.progress import Progress

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


def execute(args: argparse.Namespace) -> int:
    """Order the objects of every scene.

    Args:
        args: The parsed arguments.

    Returns:
        Exit code 0, 1 where a cycle allows no safe order, or 2 where a scene cannot be read.
    """
    from topple.planner.order import order

    with Progress("order") as progress:

        def act(path: str, scene: "Scene") -> int:
            found = order(scene, args.target, seed=args.seed)
            progress.clear()
            document = found.to_json()
            if args.json:
                print_json({"scene": path, **document})
            else:
                _print_order(path, scene, document)
            return _judge(path, found)

        return for_each_scene(args, act, progress)


def _judge(path: str, found: "Order") -> int:
    for cycle in found.unresolved:
        complain(f"{path}: no safe order: {' -> '.join([*cycle, cycle[0]])} is a cycle, each has to go first")
    return NO_SAFE_PLAN if found.unresolved else DONE


def _print_order(path: str, scene: "Scene", order: Mapping[str, Any]) -> None:
    from topple.planner.report.words import listed, order_in_words

    steps = order_in_words(order)
    purpose = f"to free {listed(order['targets'])}" if order["targets"] else "to clear everything"
    taken = f"{len(steps)} of {len(scene.movable)} movable objects"
    print_text(f"{path}: {purpose}, take {taken} in this order")
    risk = order["risk"]
    rows = [(str(i), name, why, f"{risk.get(name, 0):.2f}") for i, (name, why) in enumerate(steps, start=1)]
    print_table(("", "take", "because", "risk"), rows, right=(0, 3))
    if order["supports"]:
        print_text("", "Who carries whom:")
        print_table(
            ("supporter", "supported", "confidence"), [_support(s) for s in order["supports"]], right=(2,)
        )
    for group in order["groups"]:
        print_text(f"{listed(group)} hold each other: take them together, or hold the others.")
    print_text(*(f"Assumed: {assumption.rstrip('.')}." for assumption in order["assumptions"]))


def _support(support: Mapping[str, Any]) -> tuple[str, str, str]:
    return (support["supporter"], support["supported"], f"{support['confidence']:.2f}")
