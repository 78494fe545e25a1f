"""`topple run`: a scene rebuilt in PyBullet, and an arm that does in it what the goal says."""

import argparse

from topple.planner.cli.arguments import COMMON, SIMULATION, add, add_scenes, add_task
from topple.planner.cli.console import complain, print_json, print_text
from topple.planner.cli.main import DONE, INTERRUPTED, NO_SAFE_PLAN
from topple.planner.cli.options import goal_of, keywords, orderer_of, read_scene, rule_of, scene_paths
from topple.planner.cli.progress import Progress
from topple.planner.cli.robot_options import arm_of, away_of, base_of, film_of, output_of
from topple.planner.cli.tables import print_run
from topple.topology.base.files import write_whole


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options; see `topple.planner.cli.main`."""
    add_scenes(parser)
    add_task(parser)
    add(parser, "--second-base", "--away", "--bin", "--clamped", "--rule", "--orderer", "--masks-as-they-are")
    add(parser, *SIMULATION, *COMMON, "--shuffle-labels", "--lerobot")
    add(parser, "--report", more=": before, after and every step, out.html")


def execute(args: argparse.Namespace) -> int:
    """Rebuild the scene, act, and say what happened; 1 where the goal was not reached or things moved."""
    (path,) = scene_paths(args, many=False)
    goal = goal_of(args)
    place, video = output_of(args, "report"), film_of(args)
    if (taught := args.lerobot) is not None:
        from topple.robots.world.lerobot import check_dataset

        check_dataset(taught)
    orderer, relating, away = orderer_of(args), rule_of(args), away_of(args)
    with Progress("run") as progress:
        progress(f"reading {path}")
        scene = read_scene(args, path)
        from topple.planner.execution.run import run
        from topple.planner.planning.order import cautious

        progress(f"{path}: rebuilding the scene")
        asked = keywords(
            run, args, scene=scene, goal=goal, robot=arm_of(args), away=away, video=video,
            pose_base_to_world=base_of(args, scene), relate=relating,
            pose_second_to_world=base_of(args, scene, "--second-base"),
            photos=place is not None, orderer=orderer or cautious,
            progress=lambda text: progress(args.said(text)),
        )  # fmt: skip
        record = run(**asked)
        from topple.planner.decide.names import spoken

        said = spoken(scene, record)
        if place is not None:
            from topple.planner.report.run_page import run_page

            write_whole(place, run_page(said))
    if args.json:
        print_json(record.to_json())
    else:
        print_run(path, said.to_json())
        print_text(*(f"Note: {note.rstrip('.')}." for note in said.notes))
        for written in filter(None, (place, video, taught)):
            print_text(f"Written: {written}")
    complain(*(f"{path}: {violation}" for violation in said.violations))
    return INTERRUPTED if record.interrupted else DONE if record.success else NO_SAFE_PLAN
