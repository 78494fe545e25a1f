"""A scene rebuilt in simulation, and a goal reached in it by an arm in closed loop."""

from collections.abc import Collection, Sequence
from dataclasses import replace
from pathlib import Path

from topple.planner.decide.hold import fixture_assumptions
from topple.planner.execution.look import Relate
from topple.planner.execution.loop import ClosedLoop, Progress
from topple.planner.execution.rehearsal import Rehearsal, Z
from topple.planner.fallbacks import RELAXATIONS
from topple.planner.formats.run_record import RunRecord
from topple.planner.grasp.given import OwnGrasps, own_grasps
from topple.planner.placement.away import Away, Destination
from topple.planner.planning.next_step import GoalTask
from topple.planner.planning.order import cautious, check_clamped, check_masks
from topple.planner.planning.step import Orderer, Task
from topple.robots.arm.arm import Arm
from topple.robots.catalog import robot as robot_named
from topple.robots.catalog.own_arm import check_tool
from topple.robots.engines import DEFAULT_ENGINE, arm_in, playing_on
from topple.robots.poses import inverse
from topple.robots.world.film import film_of
from topple.robots.world.lerobot import demonstration_in
from topple.topology.base.arguments import checked_arguments
from topple.topology.base.arrays import FloatArray
from topple.topology.base.checks import as_pose
from topple.topology.io.load import AnyScene, as_scene
from topple.topology.situation.situation import Situation
from topple.topology.statics.gravity import check_up


@checked_arguments
def run(
    scene: AnyScene,
    goal: str | Collection[str] | Task,
    robot: Arm | str = "panda",
    *,
    pose_base_to_world: FloatArray | None = None,
    pose_second_to_world: FloatArray | None = None,
    clamped: Collection[str] | str = (),
    away: str | Sequence[str | float] | Destination = Away.TABLE,
    relaxations: Collection[str] = RELAXATIONS,
    cameras: int = 3,
    mask_noise: float = 0.0,
    shuffle_labels: bool = False,
    wrist_camera: bool = False,
    ahead: bool = False,
    engine: str = DEFAULT_ENGINE,
    video: Path | None = None,
    lerobot: Path | None = None,
    photos: bool = False,
    grasps: OwnGrasps | None = None,
    orderer: Orderer = cautious,
    relate: Relate | None = None,
    seed: int = 0,
    progress: Progress | None = None,
) -> RunRecord:
    """Rebuild a scene in simulation and act out a goal in it, looking again after every action.

    Args:
        scene: What was seen, with `up` and a flat fixed object to stand on, or the path of it.
        goal: In words, names of objects to free, or any other task, in the frame of the scene.
        robot: The arm, or its name.
        pose_base_to_world: (4, 4) where the arm stands; the scene's `robot_base`, or else searched for.
        pose_second_to_world: (4, 4) of a second such arm, which holds what would not stand; None for one.
        clamped: Objects that a fixture, such as a vice, keeps where they stand until the hand holds them.
        away: Where things go that are taken, as for `topple.planner.plan`.
        relaxations: What may be tried where the plain way fails, likewise.
        cameras: How many depth cameras look on, 1 to 3.
        mask_noise: Pixels by which edges of their masks are wrong (deviation); one in twenty is missing then.
        shuffle_labels: Whether names of objects are not kept between looks.
        wrist_camera: Whether the arm carries one more for a second look before a doubtful step.
        ahead: Whether a spawned process chooses the next step while the arm acts, as for `ClosedLoop`.
        engine: What plays it, one of `topple.robots.engines.ENGINES`.
        video: Where a film of it is written, an MP4 file.
        lerobot: A dataset of LeRobot v3 that the run is added to as an episode, or a folder for a new one.
        photos: Whether photos for people are taken at every look, for `run_page`: a second each.
        grasps: Grasps of your own, in the scene's frame, as for `topple.planner.plan`, for an object until
            the arm has tried to take it: from then on they are searched for.
        orderer: What says in which order to free targets: see `topple.planner.planning.step.Orderer`.
        relate: What relates what is seen, a function of the scene; topple's own rule where None.
        seed: Of sensor noise and every search.
        progress: Called with a line before and after each action.

    Returns:
        Every step with what it disturbed; `notes` say where the base stands and how far bodies sagged.

    Raises:
        InvalidInput: The goal is none, names what is not there, the scene has no table, no up or hangs in the
            air, or the arm has no tool; or two arms cannot hold, or have another engine or a wrist camera.
        NoBase: The arm reaches nothing from anywhere.

    Examples:
        >>> print(run(scene, "free cup").summary)
        Cup freed in 1 move. Nothing else moved.
    """
    scene, arm = as_scene(scene), robot_named(robot) if isinstance(robot, str) else robot
    check_tool(arm)
    task = GoalTask.of(goal)
    check_up(scene)
    scene = check_masks(scene, task.goal(scene).names)
    own = {} if grasps is None else own_grasps(grasps, scene, arm)
    fixture = check_clamped(scene, clamped)
    with playing_on(engine), Rehearsal.of(scene, arm, pose_base_to_world, fixture) as stage:
        acting = arm_in(stage.world, arm, stage.pose_base_to_world)
        to_world, second = stage.pose_scene_to_world, pose_second_to_world
        there = None if second is None else to_world @ as_pose(second, "pose_second_to_world")
        receiver = Destination.of(away).at(Situation(scene), inverse(to_world) @ stage.pose_base_to_world)
        eyes = [camera.with_mask_noise(mask_noise) for camera in stage.cameras[:cameras]]
        loop = ClosedLoop.simulated(
            stage.world, acting, eyes, task.in_frame(to_world, Z), fixed=tuple(sorted(stage.world.fixed)),
            grasps={n: [grasp.move(to_world) for grasp in some] for n, some in own.items()},
            masses=scene.masses, friction=scene.friction, fixture=stage.fixture,
            second=None if there is None else arm_in(stage.world, arm, there, acting),
            away=receiver and receiver.move(to_world), wrist_camera=wrist_camera, ahead=ahead, photos=photos,
            shuffle_labels=shuffle_labels, orderer=orderer, relate=relate, relaxations=relaxations, seed=seed,
            progress=progress,
        )  # fmt: skip
        eye = stage.cameras[0]
        with film_of(video, acting, eye), demonstration_in(lerobot, acting, eye) as demonstration:
            record = loop.run()
            if demonstration is not None:
                demonstration.end(record.goal, record.success)
        kept = (*fixture_assumptions(fixture), *([] if receiver is None else [receiver.assumption()]))
        said = (*scene.assumptions, *arm.assumptions, *stage.notes(), *kept, *record.notes)
        record = replace(record, notes=said)
    return record
