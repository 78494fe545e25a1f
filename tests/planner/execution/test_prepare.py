"""The step that is chosen while the arm acts: done where the look shows what was foreseen."""

import os
import signal
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from multiprocessing import active_children

import pytest

from topple.planner.execution.loop import ClosedLoop
from topple.planner.execution.prepare import cores
from topple.planner.formats.run_record import RunRecord
from topple.planner.planning.order import cautious
from topple.planner.planning.step import Orderer
from topple.robots import shapes
from topple.robots.catalog import robot
from topple.robots.scenarios.scenario import around, pose_at
from topple.robots.world.simulated_arm import SimulatedArm
from topple.robots.world.world import World

pytestmark = pytest.mark.skipif(cores() < 2, reason="nothing is prepared where there is one core")


@dataclass
class Stage:
    """A block on another one, a third beside them, and what happens as the first is let go."""

    world: World
    happens: Callable[[], object] = lambda: None

    def run(self, ahead: bool = True, orderer: Orderer = cautious) -> RunRecord:
        stage = self

        class Arm(SimulatedArm):
            released = 0

            def release(self, opening: float | None = None) -> None:
                super().release(opening)
                self.released += 1
                if self.released == 1:
                    stage.happens()

        arm = Arm(self.world, robot("panda"), pose_at(-0.45, 0.0, 0.0))
        eyes = around((0.0, 0.0, 0.03))[:2]
        return ClosedLoop.simulated(self.world, arm, eyes, "free low", ahead=ahead, orderer=orderer).run()


def set_up() -> Stage:
    world = World()
    world.add_table(size=(1.2, 1.2), centre=(-0.05, 0.0))
    world.add(shapes.block("low"), pose_at(0.0, 0.0, 0.0))
    world.add(shapes.block("upper"), pose_at(0.0, 0.0, 0.0502))
    world.add(shapes.block("beside"), pose_at(0.05, 0.2, 0.0))
    world.settle()
    return Stage(world)


@pytest.fixture
def stage() -> Iterator[Stage]:
    made = set_up()
    with made.world:
        yield made


def told(record: RunRecord) -> dict[str, object]:
    """What a record says of all but the time of day."""
    document = record.to_json()
    steps = [{k: v for k, v in s.items() if k not in ("seconds", "waited")} for s in document["steps"]]
    return {**document, "seconds": None, "steps": steps}


@pytest.mark.parametrize("twice", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_a_step_that_was_foreseen_is_done_and_the_same_seed_does_the_same(stage, twice):
    record = stage.run()
    assert record.success, record.violations
    taken = [(step.object, step.prepared) for step in record.steps if step.success]
    assert taken == [("upper", False), ("low", True)]
    assert all(step.waited is not None and step.waited > 0.0 for step in record.steps)
    assert active_children() == []
    if twice:
        with (again := set_up()).world:
            assert told(again.run()) == told(record)


@pytest.mark.slow
def test_where_a_thing_was_moved_meanwhile_the_step_is_chosen_anew(stage):
    stage.happens = lambda: stage.world.place("low", pose_at(0.0, -0.08, 0.0))
    record = stage.run()
    assert [(step.object, step.prepared) for step in record.steps] == [("upper", False), ("low", False)]
    assert any("low is" in event and "from where it should be" in event for event in record.steps[0].events)
    assert "low is not free" not in record.violations
    assert active_children() == []


@pytest.mark.slow
def test_where_the_process_is_killed_the_run_goes_on_by_itself(stage):
    killed: list[int] = []

    def kill() -> None:
        killed.extend(child.pid for child in active_children() if child.pid is not None)
        for pid in killed:
            os.kill(pid, signal.SIGKILL)

    stage.happens = kill
    record = stage.run()
    assert len(killed) == 1
    assert record.success, record.violations
    assert [step.object for step in record.steps] == ["upper", "low"]
    assert active_children() == []


def test_who_interrupts_leaves_no_process_behind(stage):
    def interrupt() -> None:
        raise KeyboardInterrupt

    stage.happens = interrupt
    assert stage.run().interrupted
    assert active_children() == []


@pytest.mark.slow
def test_what_cannot_go_to_another_process_is_chosen_in_this_one(stage):
    record = stage.run(orderer=lambda situation, targets, **more: cautious(situation, targets, **more))
    assert record.success, record.violations
    assert not any(step.prepared for step in record.steps)


@pytest.mark.slow
def test_without_it_no_process_is_started(stage):
    seen: list[int] = []
    stage.happens = lambda: seen.append(len(active_children()))
    record = stage.run(ahead=False)
    assert record.success and seen == [0]
    assert not any(step.prepared for step in record.steps)
