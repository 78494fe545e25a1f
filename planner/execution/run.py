"""The closed loop: look, relate, order, take the next object, look again, until the goal holds."""

import logging
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from topple.planner.bodies.solids import solids_of
from topple.planner.decide.beliefs import Beliefs
from topple.planner.decide.goal import Goal, parse_goal
from topple.planner.decide.turn import Ahead
from topple.planner.errors import NoSafePlan
from topple.planner.execution.execute import Outcome, execute, withdraw
from topple.planner.execution.judge import LIMITS, HandWitness, displacements, tilts, truly_unmet, violations
from topple.planner.execution.look import Look, Observer, unexpected
from topple.planner.execution.rehearsal import Rehearsal
from topple.planner.files import write_whole
from topple.planner.formats.run_record import INTERRUPTED, RunRecord, StepRecord
from topple.planner.grasp.given import GraspsByObject, OwnGrasps, own_grasps
from topple.planner.grasp.grasp import Grasp
from topple.planner.motion.collision import Checker
from topple.planner.planning.next_step import StepChooser
from topple.planner.planning.order import cautious
from topple.planner.planning.step import PLACE, NextStep, Orderer, Station
from topple.planner.report.rerun_file import RATE as RERUN_RATE
from topple.planner.report.rerun_file import rerun_file
from topple.planner.transfer.transfer import scene_after
from topple.robots.arm.arm import Arm
from topple.robots.catalog import robot as robot_named
from topple.robots.catalog.own_arm import check_tool
from topple.robots.world.camera import Camera
from topple.robots.world.film import filmed
from topple.robots.world.recording import Recording
from topple.robots.world.simulated_arm import SimulatedArm
from topple.robots.world.world import World
from topple.topology.arrays import FloatArray
from topple.topology.errors import ToppleError
from topple.topology.scene import Scene
from topple.topology.statics.gravity import check_up

log = logging.getLogger(__name__)

STUCK = 0.005  # [m] an arm this deep in something when it starts stands in it: depth noise is a third of that

Progress = Callable[[str], None]


def run(
    scene: Scene,
    goal: str | Sequence[str],
    robot: Arm | str = "panda",
    *,
    base: FloatArray | None = None,
    cameras: int = 3,
    mask_noise: float = 0.0,
    shuffle_labels: bool = False,
    video: Path | None = None,
    rerun: Path | None = None,
    grasps: OwnGrasps | None = None,
    orderer: Orderer = cautious,
    seed: int = 0,
    progress: Progress | None = None,
) -> RunRecord:
    """Rebuilds a scene in PyBullet and acts out a goal in it, looking again after every action.

    Args:
        scene: What was seen, with `up` and a flat fixed object to stand on.
        goal: In words, or names of objects to free.
        robot: The arm, or its name.
        base: (4, 4) pose_base_to_scene; the scene's `robot_base`, or else searched for.
        cameras: How many depth cameras look on, 1 to 3.
        mask_noise: By how many pixels the edges of their masks are wrong (standard deviation).
        shuffle_labels: Whether names of objects are not kept between looks.
        video: Where a film of it is written, an MP4 file.
        rerun: Where a recording for the Rerun viewer is written, an .rrd file.
        grasps: Grasps of your own, in the scene's frame, as for `topple.planner.plan`. They count for an
            object until the arm has tried to take it: where it is then has to be seen, and grasps for it
            there are searched for.
        orderer: Who says in which order to free targets: see `topple.planner.planning.step.Orderer`.
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
        loop = ClosedLoop(
            stage.world,
            SimulatedArm(stage.world, arm, stage.pose_base_to_world),
            [camera.with_mask_noise(mask_noise) for camera in stage.cameras[:cameras]],
            goal,
            fixed=tuple(sorted(stage.world.fixed)),
            seed=seed,
            orderer=orderer,
            grasps={
                name: [_turned(grasp, stage.pose_scene_to_world) for grasp in some]
                for name, some in own.items()
            },
            progress=progress,
            masses=scene.masses,
            friction=scene.friction,
            shuffle_labels=shuffle_labels,
        )
        recording = Recording(loop.robot, RERUN_RATE) if rerun is not None else None
        with filmed(video, loop.robot, stage.cameras[0]):
            record = loop.run()
        record = replace(record, notes=(*scene.assumptions, *arm.assumptions, *stage.notes()))
        if rerun is not None and recording is not None:
            write_whole(rerun, rerun_file(record, recording))
    return record


def _turned(grasp: Grasp, pose: FloatArray) -> Grasp:
    """A grasp in another frame."""
    return replace(grasp, pose_tool_to_world=pose @ grasp.pose_tool_to_world)


@dataclass(frozen=True)
class RunLimits:
    """What ends a run that gets nowhere.

    Attributes:
        attempts: Tries at one object before the run gives up on it.
        actions: Actions in all for each object of the scene.
        settle: Seconds of simulated time to wait after an action before looking.
    """

    attempts: int = 3
    actions: int = 3
    settle: float = 1.0


@dataclass
class ClosedLoop:
    """Reaches a goal in a world with an arm, looking again after every action.

    The loop decides from depth images and masks alone; the true poses serve only to judge what it did. It
    comes to an end: after so many attempts at an object that is given up, and after so many actions the run.

    Attributes:
        world: The world with the objects and the arm in it.
        robot: The arm.
        cameras: The depth cameras, at least one.
        goal: What shall hold in the end, in words ("free plate"), or names to free.
        fixed: Names that never move.
        up: (3,) up direction in the world.
        seed: Seed of sensor noise and of every search.
        limits: When to give up.
        orderer: Who decides the order.
        grasps: Grasps of the caller's own, in the world, for objects that the arm has not tried to take yet.
        progress: Called with a line before and after each action.
        masses: Masses [kg] by name of what was weighed; what is seen anew keeps them.
        friction: Coefficients of surfaces by name of what was tried, likewise.
        shuffle_labels: Whether names of objects are not kept between looks.

    After `run`, `followed` holds the steps that were done, with their transfers.
    """

    world: World
    robot: SimulatedArm
    cameras: Sequence[Camera]
    goal: str | Sequence[str]
    fixed: tuple[str, ...] = ("table",)
    up: FloatArray = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    seed: int = 0
    limits: RunLimits = field(default_factory=RunLimits)
    orderer: Orderer = cautious
    grasps: GraspsByObject = field(default_factory=dict[str, Sequence[Grasp]])
    progress: Progress | None = None
    masses: Mapping[str, float] = field(default_factory=dict[str, float])
    friction: Mapping[str, float] = field(default_factory=dict[str, float])
    shuffle_labels: bool = False

    def __post_init__(self) -> None:
        rng, known = np.random.default_rng(self.seed), (self.masses, self.friction, self.shuffle_labels)
        self._observer = Observer(self.world, self.cameras, rng, self.fixed, self.up, *known)
        self._done: list[tuple[str, str]] = []
        self.followed: list[NextStep] = []
        self._attempts: Counter[str] = Counter()
        self._tried: set[str] = set()
        self._failed: dict[str, list[Grasp]] = {}
        self._beliefs = Beliefs()
        self._ahead: Ahead | None = None

    def look(self) -> Look:
        """Takes a picture with every camera and relates what is seen."""
        return self._observer.look()

    def run(self, look: Look | None = None) -> RunRecord:
        """Acts until the goal holds, nothing more can be done, the budget is spent, or someone interrupts.

        Args:
            look: What is seen at the start; a fresh look where None.

        Returns:
            Every step with what it disturbed, and whether the goal holds without a violation.

        Raises:
            InvalidInput: The goal is none, or names what no camera sees.
        """
        started = time.perf_counter()
        look = self.look() if look is None else look
        goal = parse_goal(self.goal, look.scene)
        budget = self.limits.actions * max(1, len(look.scene.movable))
        steps: list[StepRecord] = []
        wrong: list[str] = []
        stopped = ""
        try:
            chosen = self._first(look, goal)
            while chosen is not None and len(steps) < budget:
                step, look, found = self._act(look, chosen)
                steps.append(step)
                wrong += found
                chosen = self._chooser(look, goal).choose()
            if chosen is not None:
                stopped = "budget"
                wrong.append(f"the budget of {budget} actions is spent, and there is more to do")
        except NoSafePlan as error:
            stopped = "no plan"
            wrong.append(str(error))
        except ToppleError as error:
            stopped = "blind"
            wrong.append(f"no more could be seen: {error}")
        except KeyboardInterrupt:
            stopped = INTERRUPTED
            wrong.append(f"interrupted after {len(steps)} actions")
        missing = self._chooser(look, goal).unmet()
        missing += tuple(text for text in truly_unmet(goal, self.world, self.up) if text not in missing)
        return RunRecord(
            goal=goal.text,
            robot=self.robot.arm.name,
            seed=self.seed,
            success=not missing and not wrong,
            violations=(*wrong, *missing),
            steps=tuple(steps),
            seconds=time.perf_counter() - started,
            scene=look.scene,
            relations=look.relations.to_json(),
            stopped=stopped,
        )

    def _first(self, look: Look, goal: Goal) -> NextStep | None:
        """The first step, from an arm that stands clear.

        Raises:
            NoSafePlan: There is none, or the arm stands in something.
        """
        checker = Checker(
            self.robot.arm,
            self.robot.pose_base_to_world,
            solids_of(look.scene),
            tool_state=self.robot.tool_state,
        )
        deep = [contact for contact in checker.contacts(self.robot.q_target) if contact.distance < -STUCK]
        chooser = self._chooser(look, goal)
        if deep and chooser.unmet():
            where = f"{deep[0].a} is {-1e3 * deep[0].distance:.0f} mm inside {deep[0].b}"
            words = f"the arm starts in collision: {where}"
            raise NoSafePlan(words, (words,))
        return chooser.choose()

    def _chooser(self, look: Look, goal: Goal) -> StepChooser:
        station = Station(self.robot.arm, self.robot.pose_base_to_world, self.robot.q_target)
        most = self.limits.attempts
        given_up = {name: f"{n} attempts failed" for name, n in self._attempts.items() if n >= most}
        own = {name: some for name, some in self.grasps.items() if name not in self._tried}
        return StepChooser(
            look.scene, goal, station, done=self._done, relations=look.relations, observed=True,
            given_up=given_up, avoid=self._failed, beliefs=self._beliefs, orderer=self.orderer, grasps=own,
            seed=self.seed + self._attempts.total(),
        )  # fmt: skip

    def _act(self, look: Look, chosen: NextStep) -> tuple[StepRecord, Look, list[str]]:
        """Does one step, looks again and judges it."""
        started, robot_started = time.perf_counter(), self.world.time
        transfer, name = chosen.transfer, chosen.transfer.object
        self._say(f"{chosen.action} {name}: {chosen.reason}")
        events = self._decided(chosen)
        before = self.world.poses()
        self.robot.touched.clear()
        witness = HandWitness(self.robot, name)
        outcome = execute(transfer, self.robot, witness)
        expected = scene_after(look.scene, transfer) if outcome.success else look.scene
        withdraw(self.robot, solids_of(expected), self.seed)
        self.robot.wait(self.limits.settle)
        after = self.world.poses()
        self._tried.add(name)
        self._attempts[name] += 1
        attempts = self._attempts[name]
        events += self._learn(chosen, outcome)
        self._ahead = Ahead.of(chosen.order, name if outcome.success else None)
        seen = self._observer.look(expected)
        predicted = look.relations.updated(name, expected.clouds[name])
        different = unexpected(predicted, seen.relations)
        alone = {name, *transfer.riding} if outcome.success and chosen.action != PLACE else ()
        stirred = {name, *transfer.riding, *seen.surprises}
        self._beliefs = self._beliefs.after(chosen.order.chances, stirred, alone)
        events += [*seen.surprises.values(), *different]
        if different or seen.surprises:
            events.append("the next step is planned from what is seen")
        handled = (name, *self.fixed)
        wrong = violations(before, after, self.robot.touched, handled)
        if witness.lost_at is not None and witness.lost_at[2] - after[name][2, 3] > LIMITS.drop:
            wrong.append(f"it was dropped by {100 * (witness.lost_at[2] - after[name][2, 3]):.0f} cm")
        touched = {other: touch for other, touch in self.robot.touched.items() if other not in handled}
        step = StepRecord(
            object=name,
            action=chosen.action,
            success=outcome.success,
            attempts=attempts,
            disturbed=displacements(before, after, handled),
            relations_as_predicted=not different,
            seconds=time.perf_counter() - started,
            reason=f"{chosen.reason}; {outcome.text}",
            events=tuple(events),
            robot_seconds=self.world.time - robot_started,
            picture_before=look.picture,
            picture_after=seen.picture,
            scene=look.scene,
            relations=look.relations.to_json(),
            order=chosen.order.to_json(),
            predicted=predicted.to_json(),
            observed=seen.relations.to_json(),
            tool_path=outcome.tool_path,
            tilts=tilts(before, after, handled),
            slip=witness.slip,
            forces={other: touch.force for other, touch in touched.items()},
            impulses={other: touch.impulse for other, touch in touched.items()},
        )
        self._say(f"{name}: {outcome.text}")
        return step, seen, [f"{name}: {text}" for text in wrong]

    def _decided(self, chosen: NextStep) -> list[str]:
        """How a step differs from what was to come by the look before, and from the order it is of."""
        changed = None if self._ahead is None else self._ahead.changed(chosen.order)
        events = [] if changed is None else [f"The look before it changed the order: {changed}."]
        first = chosen.order.order[0]
        if chosen.transfer.object != first:
            events.append(f"It goes before {first}: {chosen.reason}.")
        for event in events:
            self._say(event)
        return events

    def _learn(self, chosen: NextStep, outcome: Outcome) -> list[str]:
        """Notes what was done, or which grasp is not to be tried again; says what follows from it."""
        name = chosen.transfer.object
        if outcome.success:
            self._done.append((name, chosen.action))
            self.followed.append(chosen)
            if chosen.action != PLACE:  # one that is put where it shall be and does not stay is tried again
                self._attempts[name] = 0
            return []
        self._failed.setdefault(name, []).append(chosen.transfer.grasp)
        left = self.limits.attempts - self._attempts[name]
        then = f"another grasp is tried, {left} attempts are left" if left > 0 else "it is given up"
        return [f"{outcome.text} {then[0].upper()}{then[1:]}."]

    def _say(self, line: str) -> None:
        log.info(line)
        if self.progress is not None:
            self.progress(line)
