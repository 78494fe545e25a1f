"""`topple run`: a scene rebuilt in PyBullet, and an arm that does in it what the goal says."""

import argparse

from topple.planner.cli.console import complain, print_json, print_text
from topple.planner.cli.main import DONE, INTERRUPTED, NO_SAFE_PLAN
from topple.planner.cli.options import (
    add_common,
    add_orderer,
    add_rule,
    orderer_of,
    read_scene,
    rule_of,
    scene_paths,
)
from topple.planner.cli.progress import Progress
from topple.planner.cli.robot_options import (
    add_cameras,
    add_engine,
    add_goal,
    add_recordings,
    add_robot,
    arm_of,
    base_of,
    goal_of,
    rerun_of,
    video_of,
)
from topple.planner.cli.tables import print_run
from topple.planner.files import check_writable, write_whole


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of `topple run`.

    Args:
        parser: The sub-command's parser.
    """
    add_common(parser, scenes="one")
    add_goal(parser)
    add_robot(parser)
    add_rule(parser)
    add_orderer(parser, usual="cautious")
    add_cameras(parser)
    parser.add_argument(
        "--shuffle-labels",
        action="store_true",
        help="keep no names between looks: match what is seen with what is remembered",
    )
    add_engine(parser)
    add_recordings(parser)
    parser.add_argument("--report", metavar="FILE", help="where to write the report, e.g. out.html")


def execute(args: argparse.Namespace) -> int:
    """Rebuild the scene, act, and say what happened.

    Args:
        args: The parsed arguments.

    Returns:
        Exit code 0 where the goal was reached with nothing disturbed, 130 where it was interrupted, else 1.

    Raises:
        InvalidInput: If the scene cannot be read, the goal or the robot is none, or the report cannot be
            written.
    """
    (path,) = scene_paths(args, many=False)
    goal = goal_of(args)
    place = None if args.report is None else check_writable(args.report)
    video, rerun = video_of(args), rerun_of(args)
    orderer, relating = orderer_of(args), rule_of(args)
    with Progress("run") as progress:
        progress(f"reading {path}")
        scene = read_scene(args, path)
        from topple.planner.execution.run import run
        from topple.planner.planning.order import cautious

        progress(f"{path}: rebuilding the scene")
        record = run(
            scene, goal, arm_of(args), base=base_of(args, scene), cameras=args.cameras,
            mask_noise=args.mask_noise, shuffle_labels=args.shuffle_labels, wrist_camera=args.wrist_camera,
            engine=args.engine, video=video, rerun=rerun, photos=place is not None,
            orderer=orderer or cautious, relate=relating,
            seed=args.seed, progress=progress,
        )  # fmt: skip
        if place is not None:
            from topple.planner.report.run_page import run_page

            write_whole(place, run_page(record))
    document = record.to_json()
    if args.json:
        print_json(document)
    else:
        print_run(path, document)
        print_text(*(f"Note: {note.rstrip('.')}." for note in record.notes))
        for written in filter(None, (place, video, rerun)):
            print_text(f"Written: {written}")
    complain(*(f"{path}: {violation}" for violation in record.violations))
    return INTERRUPTED if record.interrupted else DONE if record.success else NO_SAFE_PLAN
