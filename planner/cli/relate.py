"""`topple relate`: the relation of every two objects of one or more scenes."""

import argparse
from functools import partial
from typing import Any

from topple.planner.cli.arguments import COMMON, SEEN_ROBOT, add, add_many
from topple.planner.cli.main import DONE
from topple.planner.cli.many import Kept, for_each_scene, store
from topple.planner.cli.options import Reading, rule_of, scene_paths
from topple.planner.cli.tables import models_in, print_assumptions, print_relations
from topple.planner.tolerances import ALL_PAIRS_UP_TO


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options; see `topple.planner.cli.main`."""
    add_many(parser)
    add(parser, "--max-objects", "--rule", "--robot", *SEEN_ROBOT, *COMMON)
    add(parser, "--deviation", "--plain")
    add(parser, "--all-pairs", more=f", of more than {ALL_PAIRS_UP_TO} objects too")


def execute(args: argparse.Namespace) -> int:
    """Relate the objects of every scene; 2 where one cannot be read, or not with that deviation."""
    scene_paths(args)  # which may be among the names of --fixed
    if args.plain and args.rule not in (None, "plain"):
        args.parser.error(f"--plain is a rule as {args.rule} is: give one of the two")
    rule_of(args)  # refused before anything is read
    options = {key: getattr(args, key) for key in ("deviation", "plain", "max_objects", "rule")}
    work = partial(_document, Reading.of(args), options, args.all_pairs)
    return for_each_scene(args, work, partial(_show, args.json))


def _document(reading: Reading, options: dict[str, Any], all_pairs: bool, path: str) -> dict[str, Any]:
    """The relations of a scene file, and what was assumed."""
    from topple.topology.relations.relate import relate

    scene = reading.scene(path)
    relations = relate(scene, **options)
    told = relations.to_json(far=all_pairs or len(scene.names) <= ALL_PAIRS_UP_TO)
    return reading.said(scene, {**told, "assumptions": list(scene.assumptions), **models_in(scene)})


def _show(as_json: bool, kept: Kept | None, path: str, document: dict[str, Any]) -> int:
    if not store(as_json, kept, path, document):
        print_relations(path, document)
        print_assumptions(document["assumptions"])
    return DONE
