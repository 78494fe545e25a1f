"""The closed loop: look, relate, order, take the next object, look again, until the goal holds."""

import logging
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from topple.planner.errors import NoSafePlan
from topple.planner.execute import execute
from topple.planner.judge import displacements, violations
from topple.planner.order import Order, order
from topple.planner.report.raster import picture
from topple.planner.report.record import RunRecord, StepRecord
from topple.planner.solids import solids_of
from topple.planner.transfer import Transfer, TransferFailure, plan_transfer, scene_after
from topple.robots.camera import Camera
from topple.robots.simulated_arm import SimulatedArm
from topple.robots.world import World
from topple.topology.arrays import FloatArray
from topple.topology.image import DepthImage
from topple.topology.relate import Relations, relate
from topple.topology.relation import Relation
from topple.topology.scene import Scene

log = logging.getLogger(__name__)

Progress = Callable[[str], None]


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


@dataclass
class ClosedLoop:
    """Frees targets in a world with an arm, looking again after every action.

    The loop decides from depth images and masks alone; the true poses serve only to judge what it did.

    Attributes:
        world: The world with the objects and the arm in it.
        robot: The arm.
        cameras: The depth cameras, at least one.
        targets: Names to be lifted clear and put down elsewhere.
        fixed: Names that never move.
        up: (3,) up direction in the world.
        seed: Seed of sensor noise and of every search.
        limits: When to give up.
        progress: Called with a line before and after each action.
    """

    world: World
    robot: SimulatedArm
    cameras: Sequence[Camera]
    targets: tuple[str, ...]
    fixed: tuple[str, ...] = ("table",)
    up: FloatArray = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    seed: int = 0
    limits: RunLimits = field(default_factory=RunLimits)
    progress: Progress | None = None

    def __post_init__(self) -> None:
        self._rng = np.random.default_rng(self.seed)
        self._put_down: list[str] = []
        self._attempts: dict[str, int] = {}

    def run(self, goal: str) -> RunRecord:
        """Acts until the targets are free, nothing more can be done, or the budget is spent.

        Args:
            goal: The goal in words, for the record.

        Returns:
            Every step with what it disturbed, and whether the goal holds without a violation.
        """
        started = time.perf_counter()
        steps: list[StepRecord] = []
        wrong: list[str] = []
        look = self.look()
        budget = self.limits.actions * max(1, len(look.scene.movable))
        try:
            while (left := self._left()) and len(steps) < budget:
                step, look, found = self._one_action(look, left)
                steps.append(step)
                wrong += found
        except NoSafePlan as error:
            wrong.append(str(error))
        missing = self._left()
        if missing and len(steps) >= budget:
            wrong.append(f"gave up after {budget} actions with {', '.join(missing)} not free")
        return RunRecord(
            goal=goal,
            robot=self.robot.arm.name,
            seed=self.seed,
            success=not missing and not wrong,
            violations=tuple(wrong),
            steps=tuple(steps),
            seconds=time.perf_counter() - started,
            scene=look.scene,
            relations=look.relations.to_json(),
        )

    def look(self) -> Look:
        """Takes a picture with every camera and relates what is seen."""
        images = tuple(camera.look(self.world, self._rng) for camera in self.cameras)
        scene = Scene.from_images(images, fixed=self.fixed, up=self.up)
        return Look(images, scene, relate(scene))

    def _left(self) -> list[str]:
        return [name for name in self.targets if name not in self._put_down]

    def _one_action(self, look: Look, left: list[str]) -> tuple[StepRecord, Look, list[str]]:
        """Chooses, plans and does one action, looks again and judges it."""
        started, robot_started = time.perf_counter(), self.world.time
        chosen = order(look.scene, left, relations=look.relations, seed=self.seed)
        transfer = self._first_possible(look.scene, chosen)
        name = transfer.object
        self._attempts[name] = self._attempts.get(name, 0) + 1
        reason = self._reason(name, left, chosen)
        self._say(f"{name}: {reason}")
        before = self.world.poses()
        self.robot.touched.clear()
        outcome = execute(transfer, self.robot)
        self.robot.wait(self.limits.settle)
        after = self.world.poses()
        if outcome.success:
            self._put_down.append(name)
        seen = self.look()
        predicted = relate(scene_after(look.scene, transfer))
        handled = (name, *self.fixed)
        wrong = [f"{name}: {text}" for text in violations(before, after, self.robot.touched, handled)]
        step = StepRecord(
            object=name,
            action="lift clear and put down" if name in self.targets else "take off and put down",
            success=outcome.success,
            attempts=self._attempts[name],
            disturbed=displacements(before, after, handled),
            relations_as_predicted=not unexpected(predicted, seen.relations),
            seconds=time.perf_counter() - started,
            reason=f"{reason} {outcome.text}",
            robot_seconds=self.world.time - robot_started,
            picture_before=_picture(look.images[0]),
            picture_after=_picture(seen.images[0]),
            scene=look.scene,
            relations=look.relations.to_json(),
            order=chosen.to_json(),
            predicted=predicted.to_json(),
            observed=seen.relations.to_json(),
            tool_path=outcome.tool_path,
            forces={
                other: touch.force for other, touch in self.robot.touched.items() if other not in handled
            },
        )
        self._say(f"{name}: {outcome.text}")
        return step, seen, wrong

    def _first_possible(self, scene: Scene, chosen: Order) -> Transfer:
        """A transfer of the first object in the order that nothing has to precede and the arm can move.

        Raises:
            NoSafePlan: Nothing that may go now can be moved; says why for each.
        """
        waiting = {edge.then for edge in chosen.graph.dependencies if edge.first in chosen.order}
        solids, failures = solids_of(scene), list[str]()
        for name in (name for name in chosen.order if name not in waiting):
            if self._attempts.get(name, 0) >= self.limits.attempts:
                failures.append(f"{name} was tried {self.limits.attempts} times")
                continue
            found = plan_transfer(
                name,
                scene,
                solids,
                self.robot.arm,
                self.robot.pose_base_to_world,
                self.robot.q_target,
                seed=self.seed + self._attempts.get(name, 0),
            )
            if not isinstance(found, TransferFailure):
                return found
            failures.append(str(found))
        why = "; ".join(failures) or f"no safe order frees {', '.join(chosen.targets)}"
        raise NoSafePlan(why, certificate=tuple(failures))

    def _reason(self, name: str, left: Sequence[str], chosen: Order) -> str:
        """Why this object now, in a sentence."""
        if name in left:
            return "nothing has to go before it any more."
        why = [
            f"{edge.then} ({edge.reason})"
            for edge in chosen.graph.dependencies
            if edge.first == name and edge.then in chosen.order
        ]
        return f"it has to go before {' and '.join(why) or 'the target'}."

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


def _picture(image: DepthImage) -> bytes | None:
    return None if image.rgb is None else picture(image.rgb)
