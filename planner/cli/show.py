"""`topple show`: one scene as a page to turn and zoom, or as a picture."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from topple.planner.cli.arguments import COMMON, add, add_scenes
from topple.planner.cli.console import print_json, print_text
from topple.planner.cli.main import DONE
from topple.planner.cli.options import orderer_of, read_scene, rule_of, scene_paths
from topple.planner.cli.progress import Progress
from topple.planner.cli.tables import models_in, print_assumptions
from topple.topology.base.errors import InvalidInput
from topple.topology.base.files import check_writable, write_whole

if TYPE_CHECKING:
    from topple.topology.relations.relate import Relations
    from topple.topology.scene.scene import Scene

_KINDS = (".html", ".png", ".gif", ".svg")
_OF_ORDERS = (".gif", ".svg")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options; see `topple.planner.cli.main`."""
    add_scenes(parser)
    add(parser, "--target", "--rule", "--orderer", *COMMON)
    words = ": .html, .png, the order animated as .gif, the graph alone as .svg (the scene's name with .html)"
    add(parser, "-o/--output", more=words)


def execute(args: argparse.Namespace) -> int:
    """Draw the scene's clouds, hulls, relations and, where up is known, its order."""
    from topple.topology.relations.relate import relate

    (path,) = scene_paths(args, many=False)
    place = _output_path(args.output, path)
    relating = rule_of(args) or relate
    with Progress("show") as progress:
        progress(f"1 of 3: reading {path}")
        scene = read_scene(args, path)
        progress(f"2 of 3: {path}: relating {len(scene.names)} objects")
        relations = relating(scene)
        order = _order(args, scene, relations)
        progress(f"3 of 3: {path}: drawing")
        if order is None and place.suffix.lower() in _OF_ORDERS:
            raise InvalidInput(
                f"{path}: {place.suffix} shows an order, and which way is up is not known: --up 0 0 1"
            )
        write_whole(place, _draw(place, Path(path).name, scene, relations, order, progress))
    if args.json:
        document = {"format": "topple.show", "format_version": 1, "scene": path, "file": str(place)}
        print_json({**document, "ordered": order is not None, **models_in(scene)})
    else:
        print_text(f"{place}: {len(scene.names)} objects{'' if order else ', no order'}")
        hint = "The scene does not say where up is: give it with --up 0 0 1, and the order is drawn too."
        print_text(*[hint] * (order is None))
        print_assumptions(list(scene.assumptions) if scene.models else [])
    return DONE


def _output_path(given: str | None, scene: str) -> Path:
    place = Path(given or f"{Path(scene).resolve().stem}.html")
    if place.suffix.lower() not in _KINDS:
        raise InvalidInput(
            f"{place}: cannot tell what to write, expected a name ending in {', '.join(_KINDS)}"
        )
    return check_writable(place)


def _order(args: argparse.Namespace, scene: "Scene", relations: "Relations") -> dict[str, Any] | None:
    """The document of the order, or None where it was not asked for by name and gravity is unknown."""
    from topple.planner.planning.order import order

    if not args.target and (scene.up is None or not scene.movable):
        return None
    orderer = orderer_of(args)
    if orderer is not None:
        from topple.planner.planning.step import order_by

        return order_by(orderer, scene, args.target, relations, args.seed).to_json()
    return order(scene, args.target, seed=args.seed, relations=relations).to_json()


def _draw(
    place: Path,
    title: str,
    scene: "Scene",
    relations: "Relations",
    order: dict[str, Any] | None,
    progress: Progress,
) -> str | bytes:
    kind = place.suffix.lower()
    if kind == ".gif" and order is not None:
        from topple.planner.report.figure import order_gif

        return order_gif(scene, order, progress)
    if kind == ".svg" and order is not None:
        from topple.planner.report.graph import graph_file

        return graph_file(scene, order)
    if kind == ".png":
        from topple.planner.report.figure import show_picture

        return show_picture(scene, relations, order)
    from topple.planner.report.show import show_page

    return show_page(scene, relations, order, title=title)
