"""The closed loop: look, relate, order, take the next object, look again, until the goal holds."""

import logging
import time
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from topple.planner.decide.goal import Goal
from topple.planner.errors import ArmFault, NoSafePlan
from topple.planner.execution.execute import Outcome, taken_over
from topple.planner.execution.judge import Judge
from topple.planner.execution.lift_monitor import CameraStream, LiftMonitor, neighbours_to_watch
from topple.planner.execution.look import Look, Observer, Perception, Relate, find_unexpected, without
from topple.planner.execution.monitor import Monitor, NoMonitor
from topple.planner.execution.prepare import Preparer
from topple.planner.execution.second_look import HandCamera, doubtful, second_look
from topple.planner.execution.selection import RunLimits, StepSelector
from topple.planner.execution.standing import misplacement
from topple.planner.execution.two_arms import TwoArms
from topple.planner.fallbacks import RELAXATIONS, select
from topple.planner.formats.run_record import INTERRUPTED, RunRecord, StepRecord
from topple.planner.grasp.given import GraspsByObject
from topple.planner.grasp.grasp import Grasp
from topple.planner.placement.away import IN_HAND, Away, Receiver
from topple.planner.planning.follow import follow
from topple.planner.planning.holding import check_second
from topple.planner.planning.next_step import GoalTask
from topple.planner.planning.order import cautious
from topple.planner.planning.step import Context, NextStep, Orderer, Task
from topple.planner.transfer.prediction import after
from topple.robots.driver import Driver, Fixture
from topple.robots.world.acting_arm import ActingArm
from topple.robots.world.bodies import Body
from topple.robots.world.camera import Camera
from topple.robots.world.photo import photograph
from topple.robots.world.physical_world import PhysicalWorld
from topple.robots.world.wrist_camera import WristCamera
from topple.topology.base.arguments import checked_arguments
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput, ToppleError
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation

log = logging.getLogger(__name__)

Progress = Callable[[str], None]


@checked_arguments
@dataclass
class ClosedLoop:
    """Reaches a goal with an arm, looking again after every action.

    The loop decides, acts and remembers, from what it perceives alone. It comes to an end: after so many
    attempts an object is given up until another one is out of its way, and after so many actions the run.

    Attributes:
        robot: The arm: simulated, or any other `topple.robots.driver.Driver`.
        perception: What looks at the scene.
        goal: What shall hold in the end, in words ("free plate"), names to free, or any other task.
        seed: Seed of every search.
        limits: When to give up.
        orderer: What decides the order.
        grasps: Grasps of the caller's own, in the world, for objects that the arm has not tried to take yet.
        progress: Called with a line before and after each action.
        judge: What watches from outside and says what was disturbed; by default nothing does.
        wrist: A camera that the arm carries, for a second look before a doubtful step.
        ahead: Whether another process chooses the next step while the arm acts, from the scene foreseen. If
            the look shows it and proves the step, it is done. With a second arm steps wait for the look.
        second: An arm beside it that holds what would not stand; the orderer is told of two hands then.
        fixture: What keeps things where they stand, and lets go of one once the hand holds it.
        away: Where things go that are taken; to free places on what is seen where None.
        relaxations: What may be tried where the plain way fails, as for `topple.planner.plan`.
        hand_on: Called with the name of what `away` leaves in the hand: your own skill then empties it.

    `task` is the goal as a task. After `run`, `followed` holds the steps done, with their transfers.

    Examples:
        >>> with scenario("tower") as stage:
        ...     arm = arm_in(stage.world, robot("panda"), stage.pose_base_to_world)
        ...     loop = ClosedLoop.simulated(stage.world, arm, stage.cameras, stage.goal)
        ...     loop.look().scene.movable
        ('yellow', 'green', 'blue', 'red')
    """

    robot: Driver
    perception: Perception
    goal: str | Collection[str] | Task
    seed: int = 0
    limits: RunLimits = field(default_factory=RunLimits)
    orderer: Orderer = cautious
    grasps: GraspsByObject = field(default_factory=dict[str, Sequence[Grasp]])
    progress: Progress | None = None
    judge: Monitor = field(default_factory=NoMonitor)
    wrist: HandCamera | None = None
    ahead: bool = False
    second: Driver | None = None
    fixture: Fixture | None = None
    away: Receiver | None = None
    relaxations: Collection[str] = RELAXATIONS
    hand_on: Callable[[str], None] | None = None

    def __post_init__(self) -> None:
        task, self._arms = GoalTask.of(self.goal), TwoArms(self.robot, self.second, self.seed, self.fixture)
        asked = Context(
            self._arms.stations[0], relaxations=select(self.relaxations), orderer=self.orderer,
            grasps=self.grasps, seed=self.seed, away=self.away,
        )  # fmt: skip
        self._selector = StepSelector(task, self._arms, asked, self.limits.attempts)
        self.followed: list[NextStep] = []
        self._started = 0.0
        self._gone: set[str] = set()
        self._stuck, self._said = "", tuple[str, ...]()

    @property
    def task(self) -> Task:
        """The goal as a task."""
        return self._selector.task

    @classmethod
    @checked_arguments
    def simulated(
        cls,
        world: PhysicalWorld,
        robot: ActingArm,
        cameras: Sequence[Camera],
        goal: str | Collection[str] | Task,
        *,
        fixed: tuple[str, ...] = ("table",),
        up: FloatArray | None = None,
        seed: int = 0,
        masses: Mapping[str, float] | None = None,
        friction: Mapping[str, float] | None = None,
        shuffle_labels: bool = False,
        wrist_camera: bool = False,
        relate: Relate | None = None,
        photos: bool = False,
        wanted: Mapping[str, FloatArray] | None = None,
        second: ActingArm | None = None,
        away: Receiver | None = None,
        **more: Any,
    ) -> "ClosedLoop":
        """Close the loop in a simulated world, judged by its true poses.

        Args:
            world: The world with the objects and the arm in it.
            robot: The arm.
            cameras: The depth cameras, at least one.
            goal: What shall hold in the end.
            fixed: Names that never move.
            up: (3,) up direction in the world; z where None.
            seed: Seed of sensor noise and of every search.
            masses: Masses [kg] by name of what was weighed; what is seen anew keeps them.
            friction: Coefficients of surfaces by name of what was tried, likewise.
            shuffle_labels: Whether names of objects are not kept between looks.
            wrist_camera: Whether the arm carries a camera like the first one for a second look.
            relate: What relates what is seen; topple's own rule where None.
            photos: Whether photos for people are taken at every look, for a report: a second each.
            wanted: Where things shall truly lie in the end, (4, 4) poses by name, for the judge; where None,
                by the goal.
            second: An arm beside it that holds what would not stand.
            away: Where things go that are taken: a bin is put into the world; what is lifted or held out is
                taken out of the hand, and stands far away from then on.
            **more: As the attributes of this class.

        Raises:
            InvalidInput: A second arm has no fingers, or the first one a camera besides.
        """
        if second is not None:
            check_second(second.arm)
            if wrist_camera:
                raise InvalidInput(
                    "a camera on the wrist looks around one arm alone: leave out the other arm"
                )
        up = np.array([0.0, 0.0, 1.0]) if up is None else up
        for name, parts in ({} if away is None else away.bodies).items():
            world.add(Body.of(name, parts), fixed=True)
            fixed = (*fixed, name)
        rng = np.random.default_rng(seed)
        perception = Observer(
            world, cameras, rng, fixed, up, masses or {}, friction or {}, shuffle_labels, relate,
            partial(photograph, world, cameras[0], whole=True) if photos else None,
            [robot] if second is None else [robot, second],
        )  # fmt: skip
        wrist = WristCamera(robot, cameras[0], rng) if wrist_camera else None
        judge = Judge(robot, fixed, up, wanted=wanted, second=second)
        return cls(
            robot, perception, goal, seed=seed, judge=judge, wrist=wrist, second=second, away=away,
            hand_on=partial(taken_over, world, robot), **more,
        )  # fmt: skip

    def look(self) -> Look:
        """Takes a picture with every camera and relates what is seen."""
        return self.perception.look()

    def run(self, look: Look | None = None) -> RunRecord:
        """Acts until the goal holds, nothing more can be done, the budget is spent, or someone interrupts.

        Args:
            look: What is seen at the start; a fresh look where None.

        Returns:
            Every step with what it disturbed, and whether the goal holds without a violation.

        Raises:
            InvalidInput: The goal is none, or names what no camera sees.
        """
        self._started = time.perf_counter()
        with Preparer(self.ahead and self.second is None) as self._selector.preparer:
            return self._run(look)

    def _run(self, look: Look | None) -> RunRecord:
        self._look = first = self.look() if look is None else look
        self._steps: list[StepRecord] = []
        goal = self.task.goal(first.scene)
        stopped, wrong = self._act_to_end(goal, self.limits.actions * max(1, len(first.scene.movable)))
        wrong = (*(f"{step.object}: {text}" for step in self._steps for text in step.violations), *wrong)
        missing = self._selector.unmet(self._look, goal)
        missing += tuple(text for text in self.judge.unmet(goal) if text not in missing)
        return RunRecord(
            goal=goal.text,
            robot=self.robot.arm.name,
            seed=self.seed,
            success=not missing and not wrong,
            violations=(*wrong, *missing),
            missing=missing,
            steps=tuple(self._steps),
            seconds=time.perf_counter() - self._started,
            scene=self._look.scene,
            relations=self._look.relations.to_json(),
            notes=(*goal.assumptions, *(f"at the first look, {text}" for text in first.faults)),
            stopped=stopped,
            arm=self.robot.arm,
        )

    def _act_to_end(self, goal: Goal, budget: int) -> tuple[str, tuple[str, ...]]:
        """Act to the end: the word for what stopped it, and a sentence; neither where nothing is left."""
        try:
            self._check_place()
            self._selector.check_start(self._look, goal)
            if follow(partial(self._choose, goal), partial(self._do, goal), budget):
                return "", ()
            return "budget", (f"the budget of {budget} actions is spent, and there is more to do",)
        except (NoSafePlan, ArmFault) as error:
            return "no plan" if isinstance(error, NoSafePlan) else "arm", (str(error),)
        except ToppleError as error:
            return "blind", (f"no more could be seen: {error}",)
        except KeyboardInterrupt:
            return INTERRUPTED, (f"interrupted after {len(self._steps)} actions",)

    def _choose(self, goal: Goal) -> NextStep | None:
        """The next step; after a second look where it is doubtful and there is a camera for that."""
        self._look, chosen = self._selector.next(self._look, goal)
        self._said, wrist, look = (), self.wrist, self._look
        if chosen is None or wrist is None or not doubtful(chosen.order, chosen.transfer.object):
            return chosen
        again = second_look(wrist, self.robot, look.situation, chosen.order, self.seed)
        if again is None:
            return chosen
        said = f"A second look before taking {chosen.transfer.object}: that nothing else moves is not sure."
        self._say(said)
        closer = self.perception.look(look.scene, (again[0],))
        chosen = self._selector.choose(closer, goal)
        self._look, self._said = closer, (said,)
        return chosen

    def _check_place(self) -> None:
        """See that the arm is where it should be.

        Raises:
            ArmFault: The cameras see it elsewhere.
        """
        if (words := misplacement(self.robot, self._look.images, self._look.scene)) is not None:
            raise ArmFault(words)

    def _do(self, goal: Goal, chosen: NextStep) -> None:
        """Does one step, looks again and judges it.

        Raises:
            ArmFault: The arm does not let go, or is not where it should be.
        """
        started, name, look = time.perf_counter(), chosen.transfer.object, self._look
        events = [*self._said, *self._announce(chosen)]
        grip = chosen.grip or self._arms.grip
        self.judge.begin(chosen.transfer, None if grip is None else grip.object, chosen.by_second)
        self._selector.prepare(look, chosen, goal)
        waited = time.perf_counter() - max(look.taken, self._started)
        outcome, expected = self._carried_out(look, chosen)
        verdict, attempts = self.judge.verdict(), self._selector.record_action(chosen, outcome)
        events += self._learn(chosen, outcome)
        seen = without(self.perception.look(expected), self._gone)
        if outcome.success and not (seen.surprises or seen.faults):
            self._selector.preparer.prove(seen.scene)
        here = name in expected.clouds
        predicted = look.relations.updated(name, expected.clouds[name]) if here else seen.relations
        different = find_unexpected(predicted, seen.relations)
        was, now = expected.clouds, seen.scene.clouds  # of what is hidden the cloud is kept
        changed = [n for n in seen.surprises if now.get(n) is not was.get(n)]
        self._selector.record_look(chosen, outcome, seen.surprises, changed, different)
        events += [*seen.faults, *seen.surprises.values(), *different]
        if different or seen.surprises:
            events.append("the next step is planned from what is seen")
        step = StepRecord(
            object=name,
            action=str(chosen.action),
            fallbacks=tuple(map(str, chosen.all_fallbacks)),
            waited=waited,
            prepared=chosen is self._selector.prepared,
            stopped_by=outcome.moved,
            success=outcome.success,
            attempts=attempts,
            relations_as_predicted=not different,
            seconds=time.perf_counter() - started,
            reason=f"{chosen.reason}; {outcome.text}",
            events=tuple(events),
            picture_before=look.picture,
            picture_after=seen.picture,
            photo=look.photo,
            scene=look.scene,
            relations=look.relations.to_json(),
            order=chosen.order.to_json(),
            predicted=predicted.to_json(),
            observed=seen.relations.to_json(),
            tool_path=outcome.tool_path,
            motion=outcome.motion,
            **vars(verdict),
        )
        self._steps.append(step)
        self._look = seen
        self._say(f"{name}: {outcome.text}")
        if self._stuck:  # whatever the arm did next, it would drag along what it holds
            raise ArmFault(self._stuck.rstrip("."))
        self._check_place()

    def _announce(self, chosen: NextStep) -> list[str]:
        """Says what a step changes, then which it is: on a terminal the line that counts stays."""
        done = len(self.followed)
        events = [] if self._arms.queued else self._selector.changes(chosen)  # of an order that was begun
        for event in events:
            self._say(event)
        count = f"{done + 1} of {done + len(chosen.order.order)}"
        self._say(f"{count}: {chosen.action} {chosen.transfer.object}: {chosen.reason}")
        return events

    def _carried_out(self, look: Look, chosen: NextStep) -> tuple[Outcome, Scene]:
        """Does a step and brings the arms out of the way; gives also the scene as it should be then."""
        name, grip = chosen.transfer.object, chosen.grip or self._arms.grip
        named = neighbours_to_watch(look.situation, chosen.order, name) - self._selector.moved_with(name)
        held = None if grip is None else grip.object
        named = set[str]() if held == name else named - {*chosen.transfer.riding, held}  # it would not stand
        stream, monitor = self.perception, None
        if named and isinstance(stream, CameraStream):
            monitor = LiftMonitor(stream, look.images, look.situation, named)
        outcome = self._arms.carry_out(chosen, self.judge.moment, monitor)
        foreseen = after(look.situation, chosen.transfer, True) if outcome.success else look.situation
        how = chosen.transfer.placement.how
        if outcome.success and how in (*IN_HAND, Away.BIN):
            self._gone.update((name, *chosen.transfer.riding))
            if how in IN_HAND and self.hand_on is not None:
                self.hand_on(name)
        # bodies that moved are known at once, those of clouds take the arm's time
        bodies = foreseen.solids if self._selector.preparer.on else Situation(foreseen.scene).solids
        outcome = self._arms.finish(chosen, outcome, bodies)
        if outcome.stuck:
            self._stuck = outcome.text
        self.robot.wait(self.limits.settle)
        return outcome, foreseen.scene

    def _learn(self, chosen: NextStep, outcome: Outcome) -> list[str]:
        """Takes down what was done; says what follows where it failed."""
        if outcome.success:
            self.followed.append(chosen)
            return []
        if outcome.stuck or outcome.moved:
            return [outcome.text]
        left = self._selector.tries_left(chosen.transfer.object)
        then = f"another grasp is tried, {left} attempts are left" if left > 0 else "it is given up"
        return [f"{outcome.text} {then[0].upper()}{then[1:]}."]

    def _say(self, line: str) -> None:
        log.info(line)
        if self.progress is not None:
            self.progress(line)
