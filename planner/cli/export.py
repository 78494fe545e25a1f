"""`topple export`: a plan in the formats of task planners, behaviour trees, MoveIt and graph viewers."""

import argparse
from pathlib import Path

from topple.planner.cli.arguments import COMMON, add
from topple.planner.cli.console import print_json, print_text
from topple.planner.cli.main import DONE
from topple.planner.cli.options import read_plan
from topple.topology.base.errors import InvalidInput
from topple.topology.base.files import check_writable, write_whole

_PDDL_FILES = ("domain.pddl", "problem.pddl")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options; see `topple.planner.cli.main`."""
    parser.add_argument("plan", metavar="PLAN", help="plan.json of topple plan; - reads it from stdin")
    parser.add_argument(
        "--to",
        required=True,
        metavar="FORMAT",
        help="pddl, bt, dot, graphml, moveit, ros2, json, or a plugin's",
    )
    parser.add_argument(
        "-o",
        "--output",
        metavar="FILE",
        help="where to write it (stdout); for pddl a folder gets domain.pddl and problem.pddl",
    )
    add(parser, *COMMON)


def execute(args: argparse.Namespace) -> int:
    """Read a plan, and write it in the other format."""
    from topple.planner.export import export

    folder = Path(args.output) if args.to == "pddl" and args.output and Path(args.output).is_dir() else None
    if args.output is not None and folder is None:
        check_writable(args.output)
    plan = read_plan(args.plan)
    made = export(plan, args.to)
    if isinstance(made, bytes) and args.output is None:
        raise InvalidInput(f"{args.to} is no text: say with -o FILE where it is written")
    written: list[str] = []
    if folder is not None:
        from topple.planner.export.pddl import domain_and_problem

        for name, content in zip(_PDDL_FILES, domain_and_problem(plan), strict=True):
            written.append(str(write_whole(folder / name, content)))
    elif args.output is not None:
        written.append(str(write_whole(args.output, made)))
    if args.json:
        print_json(
            {
                "format": "topple.export",
                "format_version": 1,
                "plan": args.plan,
                "to": args.to,
                "written": written,
                "text": made if isinstance(made, str) else None,
            }
        )
    elif written:
        print_text(f"Written: {', '.join(written)}")
    elif isinstance(made, str):
        print_text(made.removesuffix("\n"))
    return DONE
