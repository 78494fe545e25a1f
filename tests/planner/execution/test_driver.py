"""A transfer is carried out by anything that is a `Driver`: here by an arm without physics."""

from dataclasses import dataclass, field

import numpy as np
import pytest
from on_table import table

from topple.planner.execution.execute import LET_GO, MISSED, TAKEN, execute
from topple.planner.execution.look import Look
from topple.planner.execution.loop import ClosedLoop
from topple.planner.transfer.prediction import after
from topple.planner.transfer.transfer import Transfer, plan_transfer
from topple.robots import shapes
from topple.robots.arm.arm import Arm, Station
from topple.robots.arm.gripper import ToolState
from topple.robots.catalog import robot
from topple.robots.driver import Driver, Trajectory
from topple.robots.scenarios.scenario import pose_at
from topple.topology.base.arrays import FloatArray
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation

BASE = pose_at(-0.5, 0.0, 0.0)
HEIGHT = 0.12


def moved(points: FloatArray, pose: FloatArray) -> FloatArray:
    return points @ pose[:3, :3].T + pose[:3, 3]


@dataclass
class Ghost:
    """Goes where it is told at once; what is between its pads or below its lip hangs on it rigidly.

    It knows nothing of physics but that solid points do not pass through the table at z = 0.
    """

    arm: Arm
    pose_base_to_world: FloatArray
    clouds: dict[str, FloatArray]
    q_target: FloatArray = field(default_factory=lambda: np.empty(0))
    tool_state: ToolState = field(default_factory=ToolState)
    hung: tuple[str, str, FloatArray] | None = None  # name, tool, points in the tool's frame

    def __post_init__(self) -> None:
        self.q_target, self.tool_state = np.asarray(self.arm.home), self.arm.open_hand

    def _tool(self, tool: str) -> FloatArray:
        return self.pose_base_to_world @ self.arm.tool_pose(self.q_target, tool)[0]

    @property
    def opening(self) -> float:
        return self.tool_state.opening

    @property
    def holding(self) -> bool:
        return self.hung is not None

    def _go(self, q: FloatArray) -> None:
        self.q_target = q
        if self.hung is not None:
            name, tool, points = self.hung
            self.clouds[name] = moved(points, self._tool(tool))

    def follow(self, trajectory: Trajectory, *, keep_offset: bool = False) -> float:
        self._go(trajectory.positions[-1])
        return 0.0

    def follow_until(self, trajectory: Trajectory, force: float) -> float:
        assert force > 0.0
        for q in trajectory.positions:
            self._go(q)
            if self.hung is not None and self.clouds[self.hung[0]][:, 2].min() <= 0.0:
                break
            if (
                self.hung is None
                and self.tool_state.cup_extension
                and self._near("suction", -0.001) is not None
            ):
                break
        return 0.0

    def _near(self, tool: str, depth: float) -> str | None:
        """The object whose points are between the pads, or behind the lip by more than a depth."""
        for name, points in self.clouds.items():
            local = moved(points, np.linalg.inv(self._tool(tool)))
            if tool == "suction":
                met = (np.hypot(local[:, 0], local[:, 1]) < 0.015) & (local[:, 2] < -depth)
            else:
                met = (np.abs(local) < [0.01, self.opening / 2.0, 0.009]).all(axis=1)
            if np.count_nonzero(met) > 5:
                return name
        return None

    def _hang(self, tool: str, name: str | None) -> bool:
        if name is not None:
            self.hung = name, tool, moved(self.clouds[name], np.linalg.inv(self._tool(tool)))
        return name is not None

    def open(self, opening: float | None = None) -> None:
        assert self.arm.jaw is not None
        opening = self.arm.jaw.max_opening if opening is None else opening
        self.tool_state = ToolState(opening, self.tool_state.cup_extension)

    def close(self, force: float) -> float:
        width = 0.0
        if self._hang("fingers", self._near("fingers", 0.0)):
            assert self.hung is not None
            held = self.hung[2]
            between = (np.abs(held[:, [0, 2]]) < [0.01, 0.009]).all(axis=1)
            width = float(np.ptp(held[between, 1]))
        self.tool_state = ToolState(width, self.tool_state.cup_extension)
        return width

    def extend(self, extension: float) -> None:
        self.tool_state = ToolState(self.opening, extension)

    def suck(self) -> bool:
        return self._hang("suction", self._near("suction", -0.003))

    def release(self, opening: float | None = None) -> None:
        tool = "fingers" if self.hung is None else self.hung[1]
        self.hung = None
        if tool == "fingers":
            self.open(opening)

    def wait(self, seconds: float) -> None:
        assert seconds > 0.0


def seen(height: float = HEIGHT) -> Scene:
    points = shapes.box("box", (0.05, 0.05, height)).surface(6000, np.random.default_rng(0))
    return Scene({"box": points, "table": table(0.6)}, fixed=["table"], up=(0, 0, 1))


def planned(name: str) -> Transfer:
    arm = robot(name)
    found = plan_transfer("box", seen(), Station(arm, BASE, np.asarray(arm.home)))
    assert isinstance(found, Transfer)
    return found


@pytest.mark.parametrize(
    ("name", "tool"),
    [
        ("panda", "fingers"),
        ("panda-suction", "suction"),
        pytest.param("xarm6", "fingers", marks=pytest.mark.slow),
    ],
)
def test_another_driver_carries_a_transfer_out(name, tool):
    transfer, moments = planned(name), []
    ghost = Ghost(robot(name), BASE, {"box": seen().clouds["box"].copy()})
    driver: Driver = ghost
    outcome = execute(transfer, driver, lambda moment, with_what: moments.append((moment, with_what)))
    assert outcome.success, outcome.text
    assert moments == [(TAKEN, tool), (LET_GO, tool)]
    there, wanted = ghost.clouds["box"], after(Situation(seen()), transfer).scene.clouds["box"]
    assert np.abs(there.mean(axis=0) - wanted.mean(axis=0)).max() < 0.005
    assert -1e-3 <= there[:, 2].min() < 0.006, "it was let go on the table, as high as its place is safe"
    assert np.abs(ghost.q_target - transfer.q_end).max() < 1e-6 and not ghost.holding


def test_another_driver_stops_where_what_it_holds_stands():
    """What reaches 8 mm deeper than it looked stands sooner."""
    transfer = planned("panda")
    points = seen().clouds["box"]
    foot = points[points[:, 2] < 1e-6] - [0.0, 0.0, 0.008]
    ghost = Ghost(robot("panda"), BASE, {"box": np.concatenate([points, foot])})
    assert execute(transfer, ghost).success
    assert ghost.clouds["box"][:, 2].min() == pytest.approx(0.0, abs=1e-3)


def test_a_hand_that_closes_on_nothing_goes_back():
    moments: list[str] = []
    ghost = Ghost(robot("panda"), BASE, {})
    outcome = execute(planned("panda"), ghost, lambda moment, _: moments.append(moment))
    assert (outcome.success, outcome.text) == (False, "the fingers closed on nothing.")
    assert moments == [MISSED]
    assert ghost.opening == pytest.approx(0.08)


@dataclass
class Sighted:
    """Sees the points that a ghost moves about."""

    ghost: Ghost

    def look(self, expected: Scene | None = None) -> Look:
        scene = seen()
        for name, points in self.ghost.clouds.items():
            scene = scene.with_cloud(name, points)
        return Look((), Situation(scene), None)


def test_the_loop_reaches_a_goal_with_another_driver_other_eyes_and_no_judge():
    """A block on a box: the block goes first, without a simulator anywhere in the loop."""
    on_top = np.array([0.0, 0.0, HEIGHT + 0.0005])
    block = shapes.block("block", 0.04).surface(3000, np.random.default_rng(1)) + on_top
    ghost = Ghost(robot("panda"), BASE, {"box": seen().clouds["box"].copy(), "block": block})
    record = ClosedLoop(ghost, Sighted(ghost), "free box").run()
    assert record.success, record.violations
    assert [(step.object, step.action) for step in record.steps] == [("block", "remove"), ("box", "free")]
    assert all(step.disturbed == {} and step.robot_seconds is None for step in record.steps)
    assert ghost.clouds["block"][:, 2].min() < 0.01


@dataclass
class Missing(Ghost):
    """Closes on nothing as often as it says where it should take the box."""

    misses: int = 3

    def close(self, force: float) -> float:
        if self._near("fingers", 0.0) == "box" and self.misses:
            self.misses -= 1
            return 0.0
        return super().close(force)


@pytest.mark.slow
def test_what_was_given_up_is_tried_again_once_another_thing_is_out_of_its_way():
    beside = np.array([0.0, 0.06, 0.0])
    block = shapes.block("block", 0.04).surface(3000, np.random.default_rng(1)) + beside
    ghost = Missing(robot("panda"), BASE, {"box": seen().clouds["box"].copy(), "block": block})
    record = ClosedLoop(ghost, Sighted(ghost), "free box").run()
    assert record.success, record.violations
    assert [(step.object, step.success) for step in record.steps] == [
        *[("box", False)] * 3,
        ("block", True),
        ("box", True),
    ]


@dataclass
class Clenched(Ghost):
    """Closes its hand, and does not open it any more."""

    def open(self, opening: float | None = None) -> None:
        if self.hung is None and self.tool_state.opening > 0.06:
            super().open(opening)

    def release(self, opening: float | None = None) -> None:
        pass


def test_a_hand_that_does_not_let_go_keeps_the_arm_where_it_is():
    transfer = planned("panda")
    ghost = Clenched(robot("panda"), BASE, {"box": seen().clouds["box"].copy()})
    outcome = execute(transfer, ghost)
    assert not outcome.success
    assert outcome.stuck
    assert "does not open and holds box still" in outcome.text
    assert np.abs(ghost.q_target - transfer.q_end).max() > 1e-3, "it did not back out with the box in hand"


def test_a_run_whose_hand_does_not_let_go_ends_and_says_so():
    ghost = Clenched(robot("panda"), BASE, {"box": seen().clouds["box"].copy()})
    record = ClosedLoop(ghost, Sighted(ghost), "free box").run()
    assert record.stopped == "arm"
    assert not record.success
    assert any("does not open" in text for text in record.violations)


def test_a_hand_that_does_not_open_goes_nowhere():
    ghost = Clenched(robot("panda"), BASE, {"box": seen().clouds["box"].copy()})
    ghost.tool_state = ToolState(0.0)
    outcome = execute(planned("panda"), ghost)
    assert outcome.text.startswith("the hand does not open: its pads are 0 mm instead of")
    assert np.array_equal(ghost.q_target, ghost.arm.home)


@dataclass
class Jostled(Ghost):
    """Is pushed off its path at half of its first motion, as often as it says."""

    pushes: int = 1
    joined: int = 0

    def follow(self, trajectory: Trajectory, *, keep_offset: bool = False) -> float:
        if self.pushes and np.ptp(trajectory.positions, axis=0).max() > 0.1:
            self.pushes -= 1
            self._go(trajectory.positions[len(trajectory.positions) // 2] + 0.05)
            return float(np.abs(self.q_target - trajectory.positions[-1]).max())
        self.joined += bool(np.ptp(trajectory.positions, axis=0).max() == 0.0)
        return super().follow(trajectory, keep_offset=keep_offset)


def test_an_arm_that_is_pushed_comes_back_to_its_path_and_says_so():
    ghost = Jostled(robot("panda"), BASE, {"box": seen().clouds["box"].copy()}, pushes=2)
    outcome = execute(planned("panda"), ghost)
    assert outcome.success, outcome.text
    assert "off its path during the move" in outcome.text
    assert ghost.joined == 2


def test_an_arm_that_is_held_up_again_and_again_gives_up():
    ghost = Jostled(robot("panda"), BASE, {"box": seen().clouds["box"].copy()}, pushes=100)
    outcome = execute(planned("panda"), ghost)
    assert not outcome.success
    assert "held up during the move" in outcome.text
