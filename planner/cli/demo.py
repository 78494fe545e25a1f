"""`topple demo`: a built-in scene, looked at, ordered, planned and cleared by an arm in simulation."""

import argparse
import json
from pathlib import Path
from typing import Any

from topple.planner.cli.arguments import COMMON, SIMULATION, add
from topple.planner.cli.console import complain, print_json, print_table, print_text
from topple.planner.cli.main import DONE, INTERRUPTED, NO_SAFE_PLAN
from topple.planner.cli.options import keywords, orderer_of, rule_of
from topple.planner.cli.progress import Progress
from topple.planner.cli.robot_options import film_of
from topple.planner.cli.tables import print_order, print_relations, print_run
from topple.robots.engines import BULLET

_FOLDER = "topple-demo"
_FILES = ("relations.json", "order.json", "plan.json", "run.json", "report.html")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options; see `topple.planner.cli.main`."""
    parser.add_argument("name", nargs="?", default="dishes", metavar="NAME", help="the scene (dishes)")
    add(parser, "--list", "--rule", "--orderer", "--clamped", *COMMON, *SIMULATION)
    parser.set_defaults(seed=None)  # one of the scene's own that is known to succeed
    add(parser, "--robot", more=" (the one the scene is made for)")
    add(parser, "-o/--output", more=f": a folder of {', '.join(_FILES)} ({_FOLDER})", default=_FOLDER)


def execute(args: argparse.Namespace) -> int:
    """Play the scene and say what happened; 1 where the goal was not reached or a thing disturbed."""
    if args.list:
        return _list(args.json)
    if args.fixed or args.up:
        complain("--fixed and --up are ignored: a built-in scene knows its table and which way is up")
    folder, orderer, relating = Path(args.output), orderer_of(args), rule_of(args)
    with Progress("demo") as progress:
        progress(f"setting up {args.name}")
        from topple.planner.execution.demo import demo

        own = {"folder": folder, "video": film_of(args), "orderer": orderer, "relate": relating}
        record = demo(**keywords(demo, args, **own, progress=progress))
    run = record.to_json()
    if args.json:
        print_json(run)
    else:
        _print_demo(args.name, folder, run, as_counted=_as_counted(args))
    complain(*(f"{args.name}: {violation}" for violation in run["violations"]))
    return INTERRUPTED if record.interrupted else DONE if record.success else NO_SAFE_PLAN


def _list(as_json: bool) -> int:
    """Print every scene with the first line of what it is."""
    from topple.robots.scenarios import SCENARIOS, describe

    found = {name: describe(name) for name in SCENARIOS}
    if as_json:
        print_json({"format": "topple.scenes", "format_version": 1, "scenes": found})
    else:
        print_table(("scene", "task"), list(found.items()))
    return DONE


def _as_counted(args: argparse.Namespace) -> bool:
    """Whether the scene is played with what its seeds were counted with."""
    from topple.planner.execution.demo_seeds import CAMERAS

    other = ("mask_noise", "wrist_camera", "ahead", "rule", "orderer", "clamped", "robot")
    plain = not any(getattr(args, key) for key in other)
    return plain and args.engine == BULLET and args.cameras == CAMERAS


def _print_demo(name: str, folder: Path, run: dict[str, Any], *, as_counted: bool) -> None:
    from topple.planner.execution.demo_seeds import seed_count

    count = seed_count(name) if as_counted else None
    print_text(f"{name}, seed {run['seed']}" + ("" if count is None else f"; {count}"), "")
    relations = json.loads((folder / "relations.json").read_text(encoding="utf-8"))
    order = json.loads((folder / "order.json").read_text(encoding="utf-8"))
    print_relations(name, relations)
    print_text("")
    steps = run["steps"]
    decides = f"{steps[0]['action']} {steps[0]['object']}" if steps else "nothing that can be done"
    print_text(f"{name}: {run['goal']}; decided from the first look: {decides}")
    print_order(name, order)
    print_text("")
    print_run(name, run)
    written = [file for file in _FILES if (folder / file).exists()]
    print_text("", f"Written to {folder}: {', '.join(written)}")
