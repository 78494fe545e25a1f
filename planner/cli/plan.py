"""`topple plan`: order, grasps, placements and motions of the whole sequence, before anything moves."""

import argparse
import json
from importlib import import_module
from typing import TYPE_CHECKING

from topple.planner.cli.arguments import COMMON, add, add_scenes, add_task
from topple.planner.cli.console import print_json, print_table, print_text
from topple.planner.cli.main import DONE, NO_SAFE_PLAN
from topple.planner.cli.options import goal_of, keywords, orderer_of, read_scene, rule_of, scene_paths
from topple.planner.cli.progress import Progress
from topple.planner.cli.robot_options import arm_of, away_of, base_of, output_of
from topple.planner.cli.tables import print_assumptions
from topple.topology.base.files import write_whole

if TYPE_CHECKING:
    from topple.planner.planning.plan_format import Plan
    from topple.planner.verify.verification import Verification


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options; see `topple.planner.cli.main`."""
    add_scenes(parser)
    add_task(parser)
    add(parser, "--rule", "--orderer", "--masks-as-they-are", *COMMON)
    add(parser, "--away", "--bin", "--clamped", "--budget", "--upright", "--allow-drop")
    add(parser, "--verify", more=": python-fcl at 0.002 rad, PyBullet, limits, physics, goal")
    add(parser, "-o/--output", more=", plan.json")
    add(parser, "--report", more=": the arm's motion on a time line, plan.html")


def execute(args: argparse.Namespace) -> int:
    """Plan, write the plan, and say what is in it; 1 where `--verify` finds something wrong."""
    if args.verify:
        import_module("topple.robots.engine")  # refused now, not after the work
    (path,) = scene_paths(args, many=False)
    goal = goal_of(args)
    place, report = output_of(args, "output"), output_of(args, "report")
    orderer, relating, away = orderer_of(args), rule_of(args), away_of(args)
    with Progress("plan") as progress:
        progress(f"reading {path}")
        scene = read_scene(args, path)
        from topple.planner.planning.order import ordered
        from topple.planner.planning.plan import plan
        from topple.planner.planning.plan_format import plan_to_json

        arm = arm_of(args)
        progress(f"{path}: planning")
        if (base := base_of(args, scene)) is not None:
            scene = scene.with_base(base)
        asked = keywords(
            plan, args, scene=scene, goal=goal, robot=arm, away=away, orderer=orderer or ordered,
            verify=False, relations=relating, progress=lambda text: progress(args.said(text)),
        )  # fmt: skip
        found = plan(**asked)
        checked = None
        if args.verify:
            progress(f"{path}: verifying {len(found.steps)} steps")
            checked = found.verify(scene, arm)
        if report is not None:
            from topple.planner.report.plan_page import plan_page

            progress(f"{path}: drawing")
            relations = None if relating is None else relating(scene)
            write_whole(report, plan_page(found, scene, relations, arm=arm, verification=checked))
    document = plan_to_json(found).decode("utf-8")
    holds = checked is None or checked.ok
    if place is not None and holds:
        write_whole(place, document + "\n")
    if args.json:
        verified = {} if checked is None else {"verification": checked.to_json()}
        print_json({**json.loads(document), **verified})
    else:
        found, checked = args.said((found, checked))
        _print_plan(path, found)
        if checked is not None:
            _print_verification(checked)
        unwritten = "give -o plan.json to keep it" if holds else "its own check refutes it"
        if report is not None:
            print_text(f"Written: {report}")
        print_text(f"Written: {place}" if place is not None and holds else f"Not written: {unwritten}.")
    return DONE if holds else NO_SAFE_PLAN


def _print_verification(checked: "Verification") -> None:
    count = len(checked.residuals)
    for words in checked.allowed:
        print_text(f"Allowed: {words}")
    if checked.ok:
        print_text(f"Verified: {count} checks at {checked.states} states, every residual at most 0.")
    else:
        print_text(f"Not verified: {len(checked.failed)} of {count} checks failed:")
        rows = [(bad.name, f"{bad.value:.2g} {bad.unit}", bad.witness) for bad in checked.failed]
        print_table(("check", "beyond by", "where"), rows, right=(1,))
    _print_proofs(checked)


def _print_proofs(checked: "Verification") -> None:
    """Print the proofs and their means, one row for all steps with the same proof."""
    from topple.planner.report.tables import proof_rows

    rows = proof_rows(checked)
    print_table(("what", "by", "steps"), rows)
    print_text(f"Asked of no plan: {', '.join(checked.unasked)}.")


def _print_plan(path: str, plan: "Plan") -> None:
    title, where = plan.heading()
    print_text(f"{path}: {title}", where)
    print_table(("", "action", "object", "because", "grasp", "after", "motion s"), plan.rows(), right=(0, 6))
    print_assumptions(plan.assumptions)
