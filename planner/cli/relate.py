"""`topple relate`: the relation of every two objects of one or more scenes."""

import argparse
from typing import TYPE_CHECKING

from topple.planner.cli.console import print_json
from topple.planner.cli.main import DONE
from topple.planner.cli.options import add_common, for_each_scene
from topple.planner.cli.progress import Progress
from topple.planner.cli.tables import print_assumptions, print_relations

if TYPE_CHECKING:
    from topple.topology.scene import Scene


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
        "--plain", action="store_true", help="the paper's rule to the letter of its Table 1 (deviation 0.002)"
    )


def execute(args: argparse.Namespace) -> int:
    """Relate the objects of every scene.

    Args:
        args: The parsed arguments.

    Returns:
        Exit code 0, or 2 where a scene cannot be read or the deviation makes no sense for it.
    """
    from topple.topology.relate import relate

    with Progress("relate") as progress:

        def act(path: str, scene: "Scene") -> int:
            relations = relate(scene, deviation=args.deviation, plain=args.plain)
            progress.clear()
            document = relations.to_json()
            if args.json:
                print_json({"scene": path, **document, "assumptions": list(scene.assumptions)})
            else:
                print_relations(path, document)
                print_assumptions(list(scene.assumptions))
            return DONE

        return for_each_scene(args, act, progress)
