"""The closed loop: look, relate, order, take the next object, look again, until the goal holds."""

import logging
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from topple.planner.decide.beliefs import Beliefs
from topple.planner.decide.goal import Goal
from topple.planner.decide.turn import Ahead
from topple.planner.errors import ArmFault, NoSafePlan
from topple.planner.execution.execute import Outcome
from topple.planner.execution.judge import Judge
from topple.planner.execution.look import Look, Observer, Perception, Relate, unexpected
from topple.planner.execution.monitor import Monitor, NoMonitor
from topple.planner.execution.second_look import HandCamera, doubtful, second_look
from topple.planner.execution.standing import misplaced
from topple.planner.execution.tolerances import STUCK
from topple.planner.execution.two_arms import TwoArms
from topple.planner.formats.run_record import INTERRUPTED, RunRecord, StepRecord
from topple.planner.grasp.given import GraspsByObject
from topple.planner.grasp.grasp import Grasp
from topple.planner.motion.collision import Checker
from topple.planner.planning.holding import check_second
from topple.planner.planning.next_step import GoalTask
from topple.planner.planning.order import cautious
from topple.planner.planning.step import Action, Chooser, Context, NextStep, Orderer, Task
from topple.planner.transfer.transfer import after
from topple.robots.driver import Driver
from topple.robots.world.acting_arm import ActingArm
from topple.robots.world.camera import Camera
from topple.robots.world.photo import photograph
from topple.robots.world.physical_world import PhysicalWorld
from topple.robots.world.wrist_camera import WristCamera
from topple.topology.arrays import FloatArray
from topple.topology.errors import InvalidInput, ToppleError
from topple.topology.situation import Situation

log = logging.getLogger(__name__)


Progress = Callable[[str], None]


@dataclass(frozen=True)
class RunLimits:
    """What ends a run that gets nowhere.

    Attributes:
        attempts: Tries at one object before the run gives up on it, until another one was taken away.
        actions: Actions in all for each object of the scene.
        settle: Seconds of simulated time to wait after an action before looking.
    """

    attempts: int = 3
    actions: int = 3
    settle: float = 1.0


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
        second: An arm beside it that holds what would not stand; the orderer is told of two hands then.

    `task` is the goal as a task. After `run`, `followed` holds the steps done, with their transfers.
    """

    robot: Driver
    perception: Perception
    goal: str | Sequence[str] | Task
    seed: int = 0
    limits: RunLimits = field(default_factory=RunLimits)
    orderer: Orderer = cautious
    grasps: GraspsByObject = field(default_factory=dict[str, Sequence[Grasp]])
    progress: Progress | None = None
    judge: Monitor = field(default_factory=NoMonitor)
    wrist: HandCamera | None = None
    second: Driver | None = None

    def __post_init__(self) -> None:
        self.task = GoalTask.of(self.goal)
        self._done: list[tuple[str, str]] = []
        self.followed: list[NextStep] = []
        self._attempts: Counter[str] = Counter()
        self._tried: set[str] = set()
        self._failed: dict[str, list[Grasp]] = {}
        self._beliefs = Beliefs()
        self._ahead: Ahead | None = None
        self._stuck = ""
        self._arms = TwoArms(self.robot, self.second, self.seed)

    @classmethod
    def simulated(
        cls,
        world: PhysicalWorld,
        robot: ActingArm,
        cameras: Sequence[Camera],
        goal: str | Sequence[str] | Task,
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
        rng = np.random.default_rng(seed)
        perception = Observer(
            world, cameras, rng, fixed, up, masses or {}, friction or {}, shuffle_labels, relate,
            partial(photograph, world, cameras[0], robot) if photos else None,
        )  # fmt: skip
        wrist = WristCamera(robot, cameras[0], rng) if wrist_camera else None
        return cls(
            robot,
            perception,
            goal,
            seed=seed,
            judge=Judge(robot, fixed, up, wanted=wanted, second=second),
            wrist=wrist,
            second=second,
            **more,
        )

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
        started = time.perf_counter()
        look = first = self.look() if look is None else look
        goal = self.task.goal(look.scene)
        budget = self.limits.actions * max(1, len(look.scene.movable))
        steps: list[StepRecord] = []
        wrong: list[str] = []
        stopped = ""
        try:
            self._check_place(look)
            chosen = self._first(look, goal)
            while chosen is not None and len(steps) < budget:
                look, chosen, said = self._looked_closer(look, chosen, goal)
                if chosen is None:
                    break
                step, look, found = self._act(look, chosen)
                steps.append(replace(step, events=(*said, *step.events)))
                wrong += found
                self._check_hand()
                self._check_place(look)
                pending = self._arms.pending
                chosen = pending[0] if pending else self._chooser(look, goal).choose()
            if chosen is not None:
                stopped = "budget"
                wrong.append(f"the budget of {budget} actions is spent, and there is more to do")
        except NoSafePlan as error:
            stopped = "no plan"
            wrong.append(str(error))
        except ArmFault as error:
            stopped = "arm"
            wrong.append(str(error))
        except ToppleError as error:
            stopped = "blind"
            wrong.append(f"no more could be seen: {error}")
        except KeyboardInterrupt:
            stopped = INTERRUPTED
            wrong.append(f"interrupted after {len(steps)} actions")
        missing = self._chooser(look, goal).unmet()
        missing += tuple(text for text in self.judge.unmet(goal) if text not in missing)
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
            notes=(*goal.assumptions, *(f"at the first look, {text}" for text in first.faults)),
            stopped=stopped,
            arm_parts=self.robot.arm.parts,
            assumed=look.assumed,
        )

    def _first(self, look: Look, goal: Goal) -> NextStep | None:
        """The first step, from an arm that stands clear.

        Raises:
            NoSafePlan: There is none, or the arm stands in something.
        """
        checker = Checker(
            self.robot.arm,
            self.robot.pose_base_to_world,
            look.situation.solids,
            tool_state=self.robot.tool_state,
        )
        deep = [contact for contact in checker.contacts(self.robot.q_target) if contact.distance < -STUCK]
        chooser = self._chooser(look, goal)
        if deep and chooser.unmet():
            where = f"{deep[0].a} is {-1e3 * deep[0].distance:.0f} mm inside {deep[0].b}"
            words = f"the arm starts in collision: {where}"
            raise NoSafePlan(words, (words,))
        return chooser.choose()

    def _looked_closer(
        self, look: Look, chosen: NextStep, goal: Goal
    ) -> tuple[Look, NextStep | None, tuple[str, ...]]:
        """What is seen and chosen after a second look, where the step is doubtful and there is a camera."""
        name, wrist = chosen.transfer.object, self.wrist
        if wrist is None or not doubtful(chosen.order, name):
            return look, chosen, ()
        again = second_look(wrist, self.robot, look.situation, chosen.order, self.seed)
        if again is None:
            return look, chosen, ()
        said = f"A second look before taking {name}, at a risk of {chosen.order.risk[name]:.2f}."
        self._say(said)
        look = self.perception.look(look.scene, (again[0],))
        return look, self._chooser(look, goal).choose(), (said,)

    def _check_hand(self) -> None:
        """See that the hand let go of what it held.

        Raises:
            ArmFault: It did not.
        """
        if self._stuck:
            raise ArmFault(self._stuck.rstrip("."))

    def _check_place(self, look: Look) -> None:
        """See that the arm is where it should be.

        Raises:
            ArmFault: The cameras see it elsewhere.
        """
        if (words := misplaced(self.robot, look.images, look.scene)) is not None:
            raise ArmFault(words)

    def _chooser(self, look: Look, goal: Goal) -> Chooser:
        station, second = self._arms.stations
        most = self.limits.attempts
        given_up = {name: f"{n} attempts failed" for name, n in self._attempts.items() if n >= most}
        own = {name: some for name, some in self.grasps.items() if name not in self._tried}
        context = Context(
            station, self._done, observed=True, given_up=given_up, avoid=self._failed, beliefs=self._beliefs,
            orderer=self.orderer, grasps=own, seed=self.seed + self._attempts.total(),
            second=second, besides=self._arms.besides(self.robot),
        )  # fmt: skip
        return self.task.chooser(look.situation, goal, context)

    def _act(self, look: Look, chosen: NextStep) -> tuple[StepRecord, Look, list[str]]:
        """Does one step, looks again and judges it."""
        started = time.perf_counter()
        transfer, name = chosen.transfer, chosen.transfer.object
        done = len(self.followed)
        left = chosen.order.order
        if self._arms.pending:  # of an order that was begun
            events, left = [], left[left.index(name) :]
        else:
            events = self._decided(chosen)  # said first: on a terminal the line that counts stays
        self._say(f"{done + 1} of {done + len(left)}: {chosen.action} {name}: {chosen.reason}")
        grip = chosen.grip or self._arms.grip
        self.judge.begin(transfer, None if grip is None else grip.object, chosen.by_second)
        outcome = self._arms.carry_out(chosen, self.judge.moment)
        expected = after(look.situation, transfer).scene if outcome.success else look.scene
        outcome = self._arms.withdraw(chosen, outcome, Situation(expected).solids)
        if outcome.stuck:
            self._stuck = outcome.text
        self.robot.wait(self.limits.settle)
        verdict = self.judge.verdict()
        self._tried.add(name)
        self._attempts[name] += 1
        attempts = self._attempts[name]
        events += self._learn(chosen, outcome)
        there = outcome.success and not chosen.buffer
        self._ahead = Ahead.of(chosen.order, name if there else None)
        seen = self.perception.look(expected)
        predicted = look.relations.updated(name, expected.clouds[name])
        different = unexpected(predicted, seen.relations)
        alone = {name, *transfer.riding} if outcome.success and chosen.action is not Action.PLACE else ()
        stirred = {name, *transfer.riding, *seen.surprises}
        self._beliefs = self._beliefs.after(chosen.order.chances, stirred, alone)
        events += [*seen.faults, *seen.surprises.values(), *different]
        if different or seen.surprises:
            events.append("the next step is planned from what is seen")
        step = StepRecord(
            object=name,
            action=str(chosen.action),
            fallbacks=tuple(map(str, chosen.all_fallbacks)),
            success=outcome.success,
            attempts=attempts,
            disturbed=verdict.disturbed,
            relations_as_predicted=not different,
            seconds=time.perf_counter() - started,
            reason=f"{chosen.reason}; {outcome.text}",
            events=tuple(events),
            robot_seconds=verdict.robot_seconds,
            picture_before=look.picture,
            picture_after=seen.picture,
            photo=look.photo,
            assumed=look.assumed,
            scene=look.scene,
            relations=look.relations.to_json(),
            order=chosen.order.to_json(),
            predicted=predicted.to_json(),
            observed=seen.relations.to_json(),
            tool_path=outcome.tool_path,
            motion=outcome.motion,
            tilts=verdict.tilts,
            slip=verdict.slip,
            dropped=verdict.dropped,
            forces=verdict.forces,
            impulses=verdict.impulses,
        )
        self._say(f"{name}: {outcome.text}")
        return step, seen, [f"{name}: {text}" for text in verdict.violations]

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
            self._done.append((name, str(chosen.action)))
            self.followed.append(chosen)
            if chosen.action is not Action.PLACE:  # what shall stay there and does not is tried again
                self._attempts.clear()  # what could not be taken may be now that this is out of its way
            return []
        if outcome.stuck:
            return [outcome.text]
        self._failed.setdefault(name, []).append(chosen.transfer.grasp)
        if chosen.grip is not None:
            self._failed.setdefault(chosen.grip.object, []).append(chosen.grip.grasp)
        left = self.limits.attempts - self._attempts[name]
        then = f"another grasp is tried, {left} attempts are left" if left > 0 else "it is given up"
        return [f"{outcome.text} {then[0].upper()}{then[1:]}."]

    def _say(self, line: str) -> None:
        log.info(line)
        if self.progress is not None:
            self.progress(line)
