"""A scene rebuilt in PyBullet, and a goal reached in it by an arm in closed loop."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from topple.planner.decide.goal import parse_goal
from topple.planner.execution.look import Relate
from topple.planner.execution.loop import ClosedLoop, Progress
from topple.planner.execution.rehearsal import Rehearsal
from topple.planner.files import write_whole
from topple.planner.formats.run_record import RunRecord
from topple.planner.grasp.given import OwnGrasps, own_grasps
from topple.planner.grasp.grasp import Grasp
from topple.planner.planning.order import cautious
from topple.planner.planning.step import Orderer
from topple.planner.report.rerun_file import RATE as RERUN_RATE
from topple.planner.report.rerun_file import rerun_file
from topple.robots.arm.arm import Arm
from topple.robots.catalog import robot as robot_named
from topple.robots.catalog.own_arm import check_tool
from topple.robots.world.film import filmed
from topple.robots.world.recording import Recording
from topple.robots.world.simulated_arm import SimulatedArm
from topple.topology.arrays import FloatArray
from topple.topology.scene import Scene
from topple.topology.statics.gravity import check_up


def run(
    scene: Scene,
    goal: str | Sequence[str],
    robot: Arm | str = "panda",
    *,
    base: FloatArray | None = None,
    cameras: int = 3,
    mask_noise: float = 0.0,
    shuffle_labels: bool = False,
    wrist_camera: bool = False,
    video: Path | None = None,
    rerun: Path | None = None,
    grasps: OwnGrasps | None = None,
    orderer: Orderer = cautious,
    relate: Relate | None = None,
    seed: int = 0,
    progress: Progress | None = None,
) -> RunRecord:
    """Rebuild a scene in PyBullet and act out a goal in it, looking again after every action.

    Args:
        scene: What was seen, with `up` and a flat fixed object to stand on.
        goal: In words, or names of objects to free.
        robot: The arm, or its name.
        base: (4, 4) pose_base_to_scene; the scene's `robot_base`, or else searched for.
        cameras: How many depth cameras look on, 1 to 3.
        mask_noise: By how many pixels the edges of their masks are wrong (standard deviation).
        shuffle_labels: Whether names of objects are not kept between looks.
        wrist_camera: Whether the arm carries one more for a second look before a doubtful step.
        video: Where a film of it is written, an MP4 file.
        rerun: Where a recording for the Rerun viewer is written, an .rrd file.
        grasps: Grasps of your own, in the scene's frame, as for `topple.planner.plan`. They count for an
            object until the arm has tried to take it: where it is then has to be seen, and grasps for it
            there are searched for.
        orderer: What says in which order to free targets: see `topple.planner.planning.step.Orderer`.
        relate: What relates what is seen, a function of the scene; topple's own rule where None.
        seed: Of sensor noise and every search.
        progress: Called with a line before and after each action.

    Returns:
        Every step with what it disturbed; `notes` say where the base stands and how far bodies sagged.

    Raises:
        InvalidInput: The goal is none, names what is not there, the scene has no table, no up or hangs in the
            air with it, or the arm has no tool.
        NoBase: The arm reaches nothing from anywhere.
    """
    arm = robot_named(robot) if isinstance(robot, str) else robot
    check_tool(arm)
    parse_goal(goal, scene)
    check_up(scene)
    own = {} if grasps is None else own_grasps(grasps, scene, arm)
    with Rehearsal.of(scene, arm, base) as stage:
        acting = SimulatedArm(stage.world, arm, stage.pose_base_to_world)
        loop = ClosedLoop.simulated(
            stage.world,
            acting,
            [camera.with_mask_noise(mask_noise) for camera in stage.cameras[:cameras]],
            goal,
            fixed=tuple(sorted(stage.world.fixed)),
            seed=seed,
            orderer=orderer,
            relate=relate,
            grasps={
                name: [_turned(grasp, stage.pose_scene_to_world) for grasp in some]
                for name, some in own.items()
            },
            progress=progress,
            masses=scene.masses,
            friction=scene.friction,
            shuffle_labels=shuffle_labels,
            wrist_camera=wrist_camera,
        )
        recording = Recording(acting, RERUN_RATE) if rerun is not None else None
        with filmed(video, acting, stage.cameras[0]):
            record = loop.run()
        record = replace(record, notes=(*scene.assumptions, *arm.assumptions, *stage.notes(), *record.notes))
        if rerun is not None and recording is not None:
            write_whole(rerun, rerun_file(record, recording))
    return record


def _turned(grasp: Grasp, pose: FloatArray) -> Grasp:
    """A grasp in another frame."""
    return replace(grasp, pose_tool_to_world=pose @ grasp.pose_tool_to_world)
