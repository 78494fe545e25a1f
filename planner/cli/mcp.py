"""`topple mcp`: a server of the Model Context Protocol over stdin and stdout."""

import argparse

from topple.planner.cli.arguments import COMMON, add
from topple.planner.cli.main import DONE
from topple.planner.cli.options import Reading


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options; see `topple.planner.cli.main`."""
    add(parser, "--root", *COMMON)


def execute(args: argparse.Namespace) -> int:
    """Serve until stdin ends; messages are JSON with or without --json."""
    from topple.planner.mcp.root import Root
    from topple.planner.mcp.server import serve

    if args.allow_outside:
        args.parser.error("--allow-outside: a server reads nothing outside --root")
    read = Reading.of(args)
    serve(Root.at(args.root, fixed=read.fixed, up=read.up, seed=args.seed, max_bytes=read.max_bytes))
    return DONE
