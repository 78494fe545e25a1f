"""What becomes of runs in which something goes wrong."""

import re
import traceback
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from topple.benchmarks.faults.arms import Jammed, Leaking, Misplaced, Pushed, Through
from topple.benchmarks.faults.cameras import Dark, Eye, Late, Millimetres, Split, Swapped, TakenAway, Unseen
from topple.benchmarks.faults.scene import ASIDE, LOWER, UPPER, small_scene
from topple.planner.decide.goal import parse_goal
from topple.planner.execution.attained import truly_unmet
from topple.planner.execution.judge import LIMITS, Judge
from topple.planner.execution.look import Observer
from topple.planner.execution.loop import ClosedLoop
from topple.planner.formats.run_record import RunRecord, StepRecord
from topple.robots.catalog import robot as robot_named
from topple.robots.scenarios.scenario import Scenario
from topple.robots.world.simulated_arm import SimulatedArm
from topple.robots.world.world import in_bullet
from topple.topology.base.errors import ToppleError

Eyes = Callable[[Scenario, np.random.Generator], list[Eye]]
Driving = Callable[[SimulatedArm, np.random.Generator], Through]


@dataclass(frozen=True)
class Fault:
    """Something that goes wrong in a run.

    Attributes:
        name: In a few words.
        named: What a report that names it says somewhere, a regular expression.
        eyes: The cameras of the run; None: as they should be.
        driver: The arm of the run; None: as it should be.
        robot: Name of the arm.
    """

    name: str
    named: str
    eyes: Eyes | None = None
    driver: Driving | None = None
    robot: str = "panda"


@dataclass(frozen=True)
class Run:
    """How one run with a fault went.

    Attributes:
        fault: Its name.
        seed: Of the scene, the noise and what goes wrong when.
        reached: The goal was reached, and nothing disturbed.
        named: The report names the fault.
        disturbed: Things that were moved, tipped or hit though no action was about them.
        dropped: Something fell out of the hand.
        lied: The loop took the goal for reached, and in the world it is not.
        crashed: The trace of an error that is none of topple's own; empty without.
        text: What the report says, lines joined.
    """

    fault: str
    seed: int
    reached: bool = False
    named: bool = False
    disturbed: int = 0
    dropped: bool = False
    lied: bool = False
    crashed: str = ""
    text: str = ""

    @property
    def survived(self) -> bool:
        """Reached, or ended with the fault named; nothing else disturbed, and nothing untrue said."""
        return (self.reached or self.named) and not (self.disturbed or self.lied or self.crashed)


@dataclass(frozen=True)
class FaultCount:
    """How runs with one fault went.

    Attributes:
        fault: Its name.
        runs: All of them.
    """

    fault: str
    runs: tuple[Run, ...]

    @property
    def survived(self) -> int:
        """Runs that reached the goal or named the fault, and disturbed nothing else."""
        return sum(run.survived for run in self.runs)


def play(fault: Fault, seed: int) -> Run:
    """One run with a fault.

    Args:
        fault: What goes wrong.
        seed: Of everything that is drawn.

    Returns:
        How it went; an error that is none of topple's own is an ending too.
    """
    rng = np.random.default_rng([seed, *fault.name.encode()])
    try:
        with small_scene(seed, fault.robot) as stage:
            return _played(fault, seed, stage, rng)
    except ToppleError as error:
        return Run(fault.name, seed, named=_names(fault, str(error)), text=str(error))
    except Exception:
        return Run(fault.name, seed, crashed=traceback.format_exc())


def _played(fault: Fault, seed: int, stage: Scenario, rng: np.random.Generator) -> Run:
    acting = SimulatedArm(in_bullet(stage.world), robot_named(fault.robot), stage.pose_base_to_world)
    eyes = list(stage.cameras) if fault.eyes is None else fault.eyes(stage, rng)
    perception = Observer(
        stage.world, eyes, np.random.default_rng(seed), stage.fixed, stage.up, robots=[acting]
    )
    loop = ClosedLoop(
        acting if fault.driver is None else fault.driver(acting, rng),
        perception,
        stage.goal,
        seed=seed,
        judge=Judge(acting, stage.fixed, stage.up),
    )
    first = loop.look()
    goal = parse_goal(stage.goal, first.scene)
    record = loop.run(first)
    there = all(name in stage.world.names for name in goal.names)
    untrue = there and bool(truly_unmet(goal, stage.world, stage.up))
    text = told(record)
    return Run(
        fault.name,
        seed,
        reached=record.success,
        named=_names(fault, text),
        disturbed=sum(_disturbed(step) for step in record.steps),
        dropped=any(step.dropped for step in record.steps),
        lied=untrue and not record.stopped,
        text=text,
    )


def told(record: RunRecord) -> str:
    """Everything that a report says in words.

    Args:
        record: The run.

    Returns:
        Lines.
    """
    lines = [*record.notes]
    for step in record.steps:
        lines += [f"{step.action} {step.object}: {step.reason}", *step.events]
    ending = record.stopped or ("reached" if record.success else "not reached")
    return "\n".join([*lines, f"{ending}: {'; '.join(record.violations)}"])


def _names(fault: Fault, text: str) -> bool:
    return re.search(fault.named, text) is not None


def _disturbed(step: StepRecord) -> int:
    """Objects an action moved, tipped or hit though it was not about them."""
    moved = {n for n, (way, turn) in step.disturbed.items() if way > LIMITS.distance or turn > LIMITS.angle}
    return len(moved | {name for name, hit in step.impulses.items() if hit > LIMITS.hit})


def _one(kind: Callable[[Eye, int], Eye], first: int = 0) -> Eyes:
    """One of the cameras goes wrong, from the first look or the next on, `first` at the earliest."""

    def eyes(stage: Scenario, rng: np.random.Generator) -> list[Eye]:
        found: list[Eye] = list(stage.cameras)
        which, since = int(rng.integers(len(found))), max(first, int(rng.integers(2)))
        found[which] = kind(found[which], since)
        return found

    return eyes


def _all(kind: Callable[[Eye, str], Eye]) -> Eyes:
    """The segmentation of every camera goes wrong with one object, drawn."""

    def eyes(stage: Scenario, rng: np.random.Generator) -> list[Eye]:
        name = str(rng.choice([LOWER, UPPER, ASIDE]))
        return [kind(camera, name) for camera in stage.cameras]

    return eyes


def _swapped(stage: Scenario, rng: np.random.Generator) -> list[Eye]:
    a, b = (str(name) for name in rng.choice([LOWER, UPPER, ASIDE], 2, replace=False))
    return [Swapped(camera, 1, 0, (a, b)) for camera in stage.cameras]


FAULTS = (
    Fault(
        "an object vanishes between looks",
        "seen nowhere",
        _all(lambda eye, name: TakenAway(eye, 1, name=name)),
    ),
    Fault(
        "a mask is not found any more",
        "no mask shows it|it is hidden",
        _all(lambda eye, name: Unseen(eye, 1, name=name)),
    ),
    Fault("two masks swap", "swapped", _swapped),
    Fault("a mask splits in two", "split", _all(lambda eye, name: Split(eye, 1, name=name))),
    Fault("a camera delivers nothing", r"camera \d delivers nothing", _one(Dark)),
    Fault("a camera delivers an old frame", r"camera \d delivers an old", _one(Late, 1)),
    Fault("depth in millimetres on one camera", "millimetres", _one(Millimetres)),
    Fault("the arm is pushed off its path by 2 cm", "off its path|held up", driver=Pushed),
    Fault("the gripper does not open", "does not open", driver=Jammed),
    Fault(
        "the cup loses its vacuum half-way",
        "slipped out of the hand|lost its vacuum",
        driver=Leaking,
        robot="panda-suction",
    ),
    Fault("the base stands 3 cm aside", "stands .* from where", driver=Misplaced),
)
"""Everything that is tried."""
