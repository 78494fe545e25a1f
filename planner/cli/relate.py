"""`topple relate`: the relation of every two objects of one or more scenes."""

import argparse
from functools import partial
from typing import Any

from topple.planner.cli.console import print_json
from topple.planner.cli.main import DONE
from topple.planner.cli.options import add_common, for_each_scene
from topple.planner.cli.progress import Progress
from topple.planner.cli.tables import print_assumptions, print_relations


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of `topple relate`.

    Args:
        parser: The sub-command's parser.
    """
    add_common(parser, scenes="many")
    parser.add_argument(
        "--deviation",
        type=float,
        metavar="M",
        help="distance in metres that still counts as touching (estimated)",
    )
    parser.add_argument(
        "--plain",
        action="store_true",
        help="the paper's rule to the letter of its Table 1 (deviation 0.002 unless given)",
    )


def execute(args: argparse.Namespace) -> int:
    """Relate the objects of every scene.

    Args:
        args: The parsed arguments.

    Returns:
        Exit code 0, or 2 where a scene cannot be read or the deviation makes no sense for it.
    """
    work = partial(_document, args.fixed, args.up, args.deviation, args.plain)
    with Progress("relate") as progress:
        return for_each_scene(args, work, partial(_show, args.json), progress)


def _document(
    fixed: list[str] | None, up: list[float] | None, deviation: float | None, plain: bool, path: str
) -> dict[str, Any]:
    """The relations of a scene file, and what was assumed."""
    from topple.topology.io import load_scene
    from topple.topology.rule.relate import relate

    scene = load_scene(path, fixed=fixed or (), up=up)
    relations = relate(scene, deviation=deviation, plain=plain)
    return {**relations.to_json(), "assumptions": list(scene.assumptions)}


def _show(as_json: bool, path: str, document: dict[str, Any]) -> int:
    if as_json:
        print_json({"scene": path, **document})
    else:
        print_relations(path, document)
        print_assumptions(document["assumptions"])
    return DONE
