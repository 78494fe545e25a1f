"""The closed loop: look, relate, order, take the next object, look again, until the goal holds."""

import logging
import time
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from topple.planner.errors import NoSafePlan
from topple.planner.execute import execute, withdraw
from topple.planner.goal import Goal, parse_goal
from topple.planner.judge import displacements, violations
from topple.planner.next_step import NextStep, Station, StepChooser
from topple.planner.rehearsal import Rehearsal
from topple.planner.report.raster import picture
from topple.planner.report.record import RunRecord, StepRecord
from topple.planner.solids import solids_of, table_top, up_of
from topple.planner.transfer import scene_after
from topple.robots.arm import Arm
from topple.robots.camera import Camera
from topple.robots.catalog import robot as robot_named
from topple.robots.simulated_arm import SimulatedArm
from topple.robots.world import World
from topple.topology.arrays import FloatArray
from topple.topology.cloud import clean, thinned
from topple.topology.image import DepthImage
from topple.topology.relate import Relations, relate
from topple.topology.relation import Relation
from topple.topology.scene import Scene

log = logging.getLogger(__name__)

FINE = 0.002  # [m] between the points kept of an object: what three cameras at a metre see apart
COARSE = 0.008  # [m] between those of a table: finer than the foot of what stands on it

Progress = Callable[[str], None]


def run(
    scene: Scene,
    goal: str | Sequence[str],
    robot: Arm | str = "panda",
    *,
    base: FloatArray | None = None,
    seed: int = 0,
    progress: Progress | None = None,
) -> RunRecord:
    """Rebuilds a scene in PyBullet and acts out a goal in it, looking again after every action.

    Args:
        scene: What was seen, with `up` and a flat fixed object to stand on.
        goal: In words, or names of objects to free.
        robot: The arm, or its name.
        base: (4, 4) pose_base_to_scene; the scene's `robot_base`, or else searched for.
        seed: Of sensor noise and every search.
        progress: Called with a line before and after each action.

    Returns:
        Every step with what it disturbed; `notes` say where the base stands and how far bodies sagged.

    Raises:
        InvalidInput: The goal is none, names what is not there, or the scene has no up or no table.
        NoBase: The arm reaches nothing from anywhere.
    """
    arm = robot_named(robot) if isinstance(robot, str) else robot
    parse_goal(goal, scene)
    with Rehearsal.of(scene, arm, base) as stage:
        loop = ClosedLoop(
            stage.world,
            SimulatedArm(stage.world, arm, stage.pose_base_to_world),
            stage.cameras,
            goal,
            fixed=tuple(sorted(stage.world.fixed)),
            seed=seed,
            progress=progress,
        )
        record = loop.run()
    return replace(record, notes=(*scene.assumptions, *stage.notes()))


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


@dataclass(frozen=True, eq=False)
class Look:
    """One look at the world and what follows from it."""

    images: tuple[DepthImage, ...]
    scene: Scene
    relations: Relations
    picture: bytes | None


@dataclass
class ClosedLoop:
    """Reaches a goal in a world with an arm, looking again after every action.

    The loop decides from depth images and masks alone; the true poses serve only to judge what it did.

    Attributes:
        world: The world with the objects and the arm in it.
        robot: The arm.
        cameras: The depth cameras, at least one.
        goal: What shall hold in the end, in words ("free plate"), or names to free.
        fixed: Names that never move.
        up: (3,) up direction in the world.
        seed: Seed of sensor noise and of every search.
        limits: When to give up.
        progress: Called with a line before and after each action.

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
    progress: Progress | None = None

    def __post_init__(self) -> None:
        self._rng = np.random.default_rng(self.seed)
        self._done: list[tuple[str, str]] = []
        self.followed: list[NextStep] = []
        self._attempts: Counter[str] = Counter()

    def run(self, look: Look | None = None) -> RunRecord:
        """Acts until the goal holds, nothing more can be done, or the budget is spent.

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
        try:
            while len(steps) < budget and (chosen := self._chooser(look, goal).choose()) is not None:
                step, look, found = self._act(look, chosen)
                steps.append(step)
                wrong += found
        except NoSafePlan as error:
            wrong.append(str(error))
        chooser = self._chooser(look, goal)
        missing = chooser.unmet()
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
        )

    def look(self) -> Look:
        """Takes a picture with every camera and relates what is seen."""
        images = tuple(camera.look(self.world, self._rng) for camera in self.cameras)
        scene = _thinned(Scene.from_images(images, fixed=self.fixed, up=self.up))
        return Look(images, scene, relate(scene), _seen(images[0]))

    def _chooser(self, look: Look, goal: Goal) -> StepChooser:
        station = Station(self.robot.arm, self.robot.pose_base_to_world, self.robot.q_target)
        most = self.limits.attempts
        given_up = {name: f"{n} attempts failed" for name, n in self._attempts.items() if n >= most}
        return StepChooser(
            look.scene, goal, station, done=self._done, relations=look.relations, given_up=given_up,
            seed=self.seed + self._attempts.total(),
        )  # fmt: skip

    def _act(self, look: Look, chosen: NextStep) -> tuple[StepRecord, Look, list[str]]:
        """Does one step, looks again and judges it."""
        started, robot_started = time.perf_counter(), self.world.time
        transfer, name = chosen.transfer, chosen.transfer.object
        self._say(f"{chosen.action} {name}: {chosen.reason}")
        before = self.world.poses()
        self.robot.touched.clear()
        outcome = execute(transfer, self.robot)
        predicted_scene = scene_after(look.scene, transfer)
        withdraw(self.robot, solids_of(predicted_scene), self.seed)
        self.robot.wait(self.limits.settle)
        after = self.world.poses()
        self._attempts[name] += 1
        attempts = self._attempts[name]
        if outcome.success:
            self._done.append((name, chosen.action))
            self.followed.append(chosen)
            self._attempts[name] = 0
        seen = self.look()
        predicted = look.relations.updated(name, predicted_scene.clouds[name])
        handled = (name, *self.fixed)
        wrong = [f"{name}: {text}" for text in violations(before, after, self.robot.touched, handled)]
        step = StepRecord(
            object=name,
            action=chosen.action,
            success=outcome.success,
            attempts=attempts,
            disturbed=displacements(before, after, handled),
            relations_as_predicted=not unexpected(predicted, seen.relations),
            seconds=time.perf_counter() - started,
            reason=f"{chosen.reason}; {outcome.text}",
            robot_seconds=self.world.time - robot_started,
            picture_before=look.picture,
            picture_after=seen.picture,
            scene=look.scene,
            relations=look.relations.to_json(),
            order=chosen.order.to_json(),
            predicted=predicted.to_json(),
            observed=seen.relations.to_json(),
            tool_path=outcome.tool_path,
            forces={
                other: touch.force for other, touch in self.robot.touched.items() if other not in handled
            },
        )
        self._say(f"{name}: {outcome.text}")
        return step, seen, wrong

    def _say(self, line: str) -> None:
        log.info(line)
        if self.progress is not None:
            self.progress(line)


def unexpected(predicted: Relations, observed: Relations) -> list[str]:
    """Pairs that were predicted apart and are seen in contact, or the other way round.

    Pairs that either side has not seen well enough to tell are left out.

    Args:
        predicted: Relations of the scene as it should be.
        observed: Relations of the scene as it is seen.

    Returns:
        One line a pair.
    """
    found: list[str] = []
    for pair in predicted.pairs:
        if pair.a not in observed.objects or pair.b not in observed.objects:
            found.append(f"{pair.a} and {pair.b}: one of them is not seen any more")
            continue
        now = observed.between(pair.a, pair.b)
        apart = pair.relation is Relation.DISJOINT
        if apart != (now.relation is Relation.DISJOINT) and pair.observed and now.observed:
            found.append(f"{pair.a} and {pair.b}: {pair.relation} expected, {now.relation} seen")
    return found


def _seen(image: DepthImage) -> bytes | None:
    return None if image.rgb is None else picture(image.rgb)


def _thinned(scene: Scene) -> Scene:
    """The scene without strays, and with as many points as decisions need: a table comes with 300 000."""
    for name, cloud in scene.clouds.items():
        flat = name in scene.fixed and table_top(cloud, up_of(scene)) is not None
        scene = scene.with_cloud(name, clean(thinned(cloud, COARSE if flat else FINE)))
    return scene
