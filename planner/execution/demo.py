"""The built-in scenes, played by an arm in simulation, and everything written down."""

import json
from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from topple.planner.errors import NoSafePlan
from topple.planner.execution.demo_seeds import CAMERAS, default_seed
from topple.planner.execution.look import Look, Observer, Relate
from topple.planner.execution.loop import ClosedLoop
from topple.planner.formats.pictures import picture
from topple.planner.formats.run_record import INTERRUPTED, Document, RunRecord
from topple.planner.planning.next_step import GoalTask
from topple.planner.planning.order import cautious
from topple.planner.planning.plan import plan, plan_as_done
from topple.planner.planning.plan_format import plan_to_json
from topple.planner.planning.step import Context, Orderer, Task, order_by
from topple.planner.rearranging.arrangement import Arrangement
from topple.planner.rearranging.task import ArrangementTask
from topple.planner.report.run_page import run_page
from topple.robots import scenario
from topple.robots.arm.arm import Station
from topple.robots.catalog import robot as robot_named
from topple.robots.engines import DEFAULT_ENGINE, arm_in, fixture_in
from topple.robots.scenarios import SCENARIOS, Scenario
from topple.robots.world.acting_arm import ActingArm
from topple.robots.world.camera import Camera
from topple.robots.world.film import film_of
from topple.robots.world.photo import photograph
from topple.topology.base.arguments import checked_arguments
from topple.topology.base.files import check_writable, make_folder, write_all
from topple.topology.base.workers import serve

Progress = Callable[[str], None]

FILES = ("relations.json", "order.json", "plan.json", "run.json", "report.html")
"""What a demo leaves: all of them, or none; of two arms no plan, whose format is of one."""


@checked_arguments
def demo(
    name: str = "dishes",
    *,
    seed: int | None = None,
    robot: str | None = None,
    cameras: int = CAMERAS,
    mask_noise: float = 0.0,
    wrist_camera: bool = False,
    ahead: bool = False,
    clamped: Collection[str] = (),
    engine: str = DEFAULT_ENGINE,
    folder: str | Path = "topple-demo",
    video: Path | None = None,
    orderer: Orderer | None = None,
    relate: Relate | None = None,
    progress: Progress | None = None,
) -> RunRecord:
    """Plays a built-in scene.

    Args:
        name: One of `topple.robots.scenarios.SCENARIOS`.
        seed: Of the scene, the sensor noise and every search; where None, one that is known to succeed, see
            `topple.planner.execution.demo_seeds`.
        robot: The arm; the one the scene is made for where None.
        cameras: How many depth cameras look on, 1 to 3.
        mask_noise: Pixels by which edges of their masks are wrong (deviation); one in twenty is missing then.
        wrist_camera: Whether the arm carries one more for a second look before a doubtful step.
        ahead: Whether the next step is chosen while the arm acts, as for `ClosedLoop`.
        clamped: What a fixture keeps where it stands until the hand has closed on it; there is one arm then.
        engine: What it is played on, one of `topple.robots.engines.ENGINES`.
        folder: Where relations.json, order.json, plan.json, run.json and report.html are written.
        video: Where a film of it is written, an MP4 file.
        orderer: What decides the order; the least risk where None.
        relate: What relates what is seen, a function of the scene; topple's own rule where None.
        progress: Called with a line before and after each action.

    Returns:
        The run.

    Raises:
        InvalidInput: There is no such scene or robot, or the folder cannot be written.

    Examples:
        >>> demo("tower").summary
        'red on green on blue: reached in 3 moves. Nothing else moved.'
    """
    seed, orderer = default_seed(name) if seed is None else seed, orderer or cautious
    _ = SCENARIOS[name]  # an unknown scene is refused before a folder is made
    place = make_folder(folder)
    for file in FILES:
        check_writable(place / file)
    with scenario(name, seed, engine) as stage:
        fixture = frozenset(clamped)
        two = stage.pose_second_to_world is not None and not fixture
        robot = robot or stage.robot
        loop = loop_in(
            stage, robot=robot, cameras=cameras, mask_noise=mask_noise, wrist_camera=wrist_camera,
            ahead=ahead, clamped=fixture, photos=True, orderer=orderer, relate=relate, seed=seed,
            progress=progress,
        )  # fmt: skip
        acting, first = loop.robot, loop.look()
        assert isinstance(acting, ActingArm)
        # the plan of the whole sequence is made on the other core while the arm already works
        with get_context("spawn").Pool(1, serve) as other:  # leaving it ends what still plans
            base = stage.pose_base_to_world
            task = (first.scene, loop.task, robot)
            asked = {"base": base, "orderer": orderer, "relations": relate, "clamped": fixture, "seed": seed}
            planned = None if two else other.apply_async(plan, task, asked)
            with film_of(video, acting, stage.cameras[0]):
                record = loop.run(first)
            if stage.finished is not None:
                wanted = photograph(stage.finished, stage.cameras[0], whole=True)
                record = replace(record, wanted=picture(wanted.rgb))
            try:
                whole = None if record.interrupted or planned is None else planned.get()
            except NoSafePlan as error:  # what the first look hides, later ones may show
                note = f"the whole sequence could not be planned from the first look: {error}"
                record, whole = replace(record, notes=(*record.notes, note)), None
            except KeyboardInterrupt:
                record, whole = replace(record, stopped=INTERRUPTED), None
        if whole is None and not two:
            arm, goal = robot_named(robot), loop.task.goal(first.scene)
            context = Context(Station(arm, base, arm.home), seed=seed, clamped=fixture)
            whole = plan_as_done(first.scene, goal, context, loop.followed)
        decided = _decided_by(record, first, stage, orderer, seed)
    texts = (
        _text(first.relations.to_json()),
        _text(decided),
        None if whole is None else plan_to_json(whole),
        _text(record.to_json()),
        run_page(record),
    )
    made = {place / file: text for file, text in zip(FILES, texts, strict=True)}
    write_all({path: text for path, text in made.items() if text is not None})
    for path in (path for path, text in made.items() if text is None):
        path.unlink(missing_ok=True)  # that of another demo
    return record


def _decided_by(record: RunRecord, first: Look, stage: Scenario, orderer: Orderer, seed: int) -> Document:
    """The order that the first action was chosen from; where there was none, that of the targets."""
    chosen = record.steps[0].order if record.steps else None
    if chosen is not None:
        return chosen
    return order_by(orderer, first.scene, stage.targets, first.relations, seed).to_json()


def loop_in(
    stage: Scenario,
    *,
    robot: str | None = None,
    cameras: int = 3,
    mask_noise: float = 0.0,
    clamped: Collection[str] = (),
    alone: bool = False,
    seed: int = 0,
    **more: Any,
) -> ClosedLoop:
    """Puts an arm into a built-in scene, with a loop that reaches the scene's goal.

    Args:
        stage: The scene.
        robot: The arm; the one the scene is made for where None.
        cameras: How many depth cameras look on.
        mask_noise: Pixels by which edges of their masks are wrong (deviation); one in twenty is missing then.
        clamped: What a fixture keeps where it stands; there is one arm then.
        alone: Whether there is one arm, also where the scene is made for two.
        seed: Of the sensor noise and every search.
        **more: As for `ClosedLoop.simulated`: orderer, relate, ahead, photos, progress and others.

    Returns:
        The loop, to be run.

    Raises:
        InvalidInput: The scene takes two arms, and such a one cannot hold, or has a camera at its wrist.
    """
    eyes = [camera.with_mask_noise(mask_noise) for camera in stage.cameras[:cameras]]
    arm, one = robot_named(robot or stage.robot), alone or bool(clamped)
    there = None if one else stage.pose_second_to_world
    first = arm_in(stage.world, arm, stage.pose_base_to_world)
    return ClosedLoop.simulated(
        stage.world,
        first,
        eyes,
        task_in(stage, eyes, seed),
        fixed=stage.fixed,
        up=stage.up,
        seed=seed,
        wanted=None if stage.finished is None else stage.finished.poses(),
        second=None if there is None else arm_in(stage.world, arm, there, first),
        fixture=fixture_in(stage.world, clamped),
        **more,
    )


def task_in(stage: Scenario, cameras: Sequence[Camera], seed: int = 0) -> Task:
    """The task of a built-in scene: its words, or the finished arrangement as the cameras see it.

    Args:
        stage: The scene.
        cameras: Those that look on.
        seed: Of their noise.
    """
    if stage.finished is None:
        return GoalTask(stage.goal)
    eyes = Observer(stage.finished, cameras, np.random.default_rng(seed), stage.fixed, stage.up)
    return ArrangementTask(Arrangement(eyes.look().scene))


def _text(document: object) -> str:
    return json.dumps(document, indent=1) + "\n"
