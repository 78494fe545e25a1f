"""`topple export`: a plan in the formats of task planners, behaviour trees, MoveIt and graph viewers."""

import argparse
from pathlib import Path

from topple.planner.cli.arguments import COMMON, add, value
from topple.planner.cli.console import print_json, print_text
from topple.planner.cli.main import DONE
from topple.planner.cli.options import document_at
from topple.topology.base.errors import InvalidInput
from topple.topology.base.files import check_writable, write_whole

_PDDL_FILES = ("domain.pddl", "problem.pddl")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options; see `topple.planner.cli.main`."""
    parser.add_argument("plan", **value("PLAN", "plan.json, for pddl an order's JSON, too; - reads stdin"))
    formats = "pddl, bt, dot, graphml, moveit, ros2, json, or a plugin's"
    parser.add_argument("--to", **value("FORMAT", formats, required=True))
    add(parser, "-o/--output", more="; for pddl a folder gets domain.pddl and problem.pddl (stdout)")
    add(parser, *COMMON)


def execute(args: argparse.Namespace) -> int:
    """Read a plan, and write it in the other format."""
    from topple.planner.export import export
    from topple.planner.planning.plan_format import plan_from_json

    folder = Path(args.output) if args.to == "pddl" and args.output and Path(args.output).is_dir() else None
    if args.output is not None and folder is None:
        check_writable(args.output)
    data, name = document_at(args.plan)
    parts = _pddl(data, name) if args.to == "pddl" else None
    made = "\n;; problem\n".join(parts) if parts else export(plan_from_json(data, name), args.to)
    if isinstance(made, bytes) and args.output is None:
        raise InvalidInput(f"{args.to} is no text: say with -o FILE where it is written")
    places = [folder / file for file in _PDDL_FILES] if folder else [args.output] if args.output else []
    contents = parts if folder and parts else [made]
    written = [str(write_whole(*each)) for each in zip(places, contents, strict=False)]
    if args.json:
        head = {"format": "topple.export", "format_version": 1, "plan": args.plan, "to": args.to}
        print_json({**head, "written": written, "text": made if isinstance(made, str) else None})
    elif written:
        print_text(f"Written: {', '.join(written)}")
    elif isinstance(made, str):
        print_text(made.removesuffix("\n"))
    return DONE


def _pddl(data: bytes, name: str) -> tuple[str, str]:
    """Domain and problem of a plan, or of the order of a scene."""
    from topple.planner.export.pddl import domain_and_problem
    from topple.planner.export.scene_pddl import scene_pddl
    from topple.planner.planning.plan_format import plan_from_json
    from topple.topology.io.strict_json import read_json

    document = read_json(data, name)
    if isinstance(document, dict) and document.get("format") == "topple.order":
        return scene_pddl(document)
    return domain_and_problem(plan_from_json(data, name))
