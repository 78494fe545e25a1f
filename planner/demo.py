"""The built-in scenes, played by an arm in PyBullet, and everything written down."""

import json
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path

from topple.planner.errors import NoSafePlan
from topple.planner.files import make_folder, write_whole
from topple.planner.goal import parse_goal
from topple.planner.next_step import Station
from topple.planner.order import order
from topple.planner.plan import plan, plan_as_done
from topple.planner.plan_format import plan_to_json
from topple.planner.report.record import RunRecord
from topple.planner.report.run_page import run_page
from topple.planner.run import ClosedLoop
from topple.robots.catalog import robot as robot_named
from topple.robots.scenarios import scenario_called
from topple.robots.simulated_arm import SimulatedArm

Progress = Callable[[str], None]


def demo(
    name: str = "dishes",
    *,
    seed: int = 0,
    robot: str | None = None,
    folder: str | Path = "topple-demo",
    progress: Progress | None = None,
) -> RunRecord:
    """Plays a built-in scene.

    Args:
        name: One of `topple.robots.scenarios.SCENARIOS`.
        seed: Of the scene, the sensor noise and every search.
        robot: The arm; the one the scene is made for where None.
        folder: Where relations.json, order.json, plan.json, run.json and report.html are written.
        progress: Called with a line before and after each action.

    Returns:
        The run.

    Raises:
        InvalidInput: There is no such scene or robot, or the folder cannot be written.
    """
    with scenario_called(name, seed) as stage:
        place = make_folder(folder)
        robot = robot or stage.robot
        loop = ClosedLoop(
            stage.world,
            SimulatedArm(stage.world, robot_named(robot), stage.pose_base_to_world),
            stage.cameras,
            stage.goal,
            fixed=stage.fixed,
            up=stage.up,
            seed=seed,
            progress=progress,
        )
        first = loop.look()
        write_whole(place / "relations.json", _text(first.relations.to_json()))
        chosen = order(first.scene, stage.targets, relations=first.relations, seed=seed)
        write_whole(place / "order.json", _text(chosen.to_json()))
        # the plan of the whole sequence is made on the other core while the arm already works
        with ProcessPoolExecutor(1, get_context("spawn")) as other:
            base = stage.pose_base_to_world
            planned = other.submit(plan, first.scene, stage.goal, robot, base=base, seed=seed)
            record = loop.run(first)
            try:
                whole = planned.result()
            except NoSafePlan as error:  # what the first look hides, later ones may show
                note = f"the whole sequence could not be planned from the first look: {error}"
                record = replace(record, notes=(*record.notes, note))
                arm, goal = robot_named(robot), parse_goal(stage.goal, first.scene)
                station = Station(arm, base, arm.home)
                whole = plan_as_done(first.scene, goal, station, loop.followed, seed)
        write_whole(place / "plan.json", plan_to_json(whole))
    write_whole(place / "run.json", _text(record.to_json()))
    write_whole(place / "report.html", run_page(record))
    return record


def _text(document: object) -> str:
    return json.dumps(document, indent=1) + "\n"
