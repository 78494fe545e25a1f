"""`topple view`: a live page of one scene, served to a browser until it is interrupted."""

import argparse
import sys

from topple.planner.cli.arguments import COMMON, add, add_scenes
from topple.planner.cli.console import print_json, print_text
from topple.planner.cli.main import DONE
from topple.planner.cli.options import orderer_of, read_plan, read_scene, rule_of, scene_paths
from topple.planner.cli.progress import Progress
from topple.planner.cli.tables import print_assumptions


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options; see `topple.planner.cli.main`."""
    add_scenes(parser)
    add(parser, "--rule", "--orderer", "--plan", "--host", "--port", *COMMON)


def execute(args: argparse.Namespace) -> int:
    """Serve the scene until interrupted."""
    from topple.planner.planning.order import ordered
    from topple.planner.report.live import LivePage

    (path,) = scene_paths(args, many=False)
    if not 0 < args.port < 65536:
        args.parser.error(f"--port {args.port} is no port: expected 1 to 65535")
    orderer = orderer_of(args) or ordered
    rule_of(args)  # refused before anything is read
    with Progress("view") as progress:
        progress(f"reading {path}")
        scene = read_scene(args, path)
        plan = None if args.plan is None else read_plan(args.plan)
        progress(f"{path}: relating {len(scene.names)} objects")
        page = LivePage(
            scene, plan, rule=args.rule, orderer=orderer, seed=args.seed, host=args.host, port=args.port
        )
    try:
        if args.json:
            print_json({"format": "topple.view", "format_version": 1, "scene": path, "url": page.url})
        else:
            print_text(f"{path} at {page.url} (Ctrl-C ends it)")
            print_assumptions(list(scene.assumptions) if scene.models else [])
        sys.stdout.flush()
        page.wait()
    except KeyboardInterrupt:  # the way to end it
        pass
    finally:
        page.close()
    return DONE
