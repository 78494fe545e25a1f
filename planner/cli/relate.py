"""`topple relate`: the relation of every two objects of one or more scenes."""

import argparse
from typing import TYPE_CHECKING

from topple.planner.cli.console import print_json, print_table, print_text
from topple.planner.cli.options import add_common, for_each_scene
from topple.planner.cli.progress import Progress

if TYPE_CHECKING:
    from topple.topology.pairs import PairRelation, Relations
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
            if args.json:
                print_json({"scene": path, **relations.to_json(), "assumptions": list(scene.assumptions)})
            else:
                _print_relations(path, scene, relations)
            return 0

        return for_each_scene(args, act, progress)


def _print_relations(path: str, scene: "Scene", relations: "Relations") -> None:
    pairs = relations.pairs
    near = [pair for pair in pairs if pair.relation != "disjoint" or pair.kind or not pair.observed]
    print_text(f"{path}: {len(scene.names)} objects, deviation {relations.deviation * 1000:.2f} mm")
    if near:
        headings = ("a", "relation", "b", "gap mm", "confidence", "matrix", "")
        print_table(headings, [_row(pair) for pair in near], right=(3, 4))
    apart = len(pairs) - len(near)
    if apart:
        which = f"The other {apart} of {len(pairs)} pairs" if near else f"All {apart} pairs"
        print_text(f"{which} are disjoint.")
    print_text(*(f"Assumed: {assumption}." for assumption in scene.assumptions))


def _row(pair: "PairRelation") -> tuple[str, ...]:
    notes = [pair.kind or "", "inferred" if pair.inferred else "", "" if pair.observed else "not observed"]
    gap = f"{pair.gap * 1000:.1f}" if pair.gap_exact else f"> {pair.gap * 1000:.1f}"
    matrix = "; ".join(" ".join(str(count) for count in row) for row in pair.matrix.tolist())
    note = ", ".join(note for note in notes if note)
    return (pair.a, str(pair.relation), pair.b, gap, f"{pair.confidence:.2f}", matrix, note)
