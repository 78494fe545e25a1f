"""Arms behind controllers, one that lags by 20 ms and MuJoCo's position actuators, do what the loop asks."""

import runpy
import sys
from collections.abc import Callable, Iterator
from copy import deepcopy
from dataclasses import dataclass, field, replace
from operator import attrgetter
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from moving import down
from on_table import BASE, on_table
from scipy.interpolate import CubicHermiteSpline

from topple.planner.execution.demo import loop_in
from topple.planner.execution.execute import execute
from topple.planner.execution.loop import ClosedLoop
from topple.planner.execution.second_look import second_look
from topple.planner.motion.trajectory import retime
from topple.planner.planning.order import cautious
from topple.planner.transfer.transfer import Transfer, plan_transfer
from topple.robots import robot, scenario, shapes
from topple.robots.arm.arm import Station
from topple.robots.driver import Driver
from topple.robots.driver.trajectories import TrajectoryDriver
from topple.robots.engines import INSTALLED, arm_in, new_world, playing_on
from topple.robots.scenarios.scenario import pose_at
from topple.robots.world.acting_arm import ActingArm
from topple.robots.world.camera import Camera
from topple.robots.world.simulated_arm import SimulatedArm
from topple.robots.world.world import World
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput

LAG = 0.02  # [s]
EXAMPLES, OWN = Path(__file__).parents[3] / "examples", ("q", "opening", "sealed", "extend")


@dataclass
class Splines:
    """Follows cubics through positions and velocities, late; stopped, it holds; the hand is the arm's."""

    moved: ActingArm
    spline: CubicHermiteSpline | None = None
    begun: float = 0.0
    force: float = 0.0
    sent: list[FloatArray] = field(default_factory=list)

    joints, opening, sealed, extend = (property(attrgetter(f"moved.{n}")) for n in OWN)
    moving = property(lambda self: self.spline is not None)

    def tare(self) -> None:
        self.moved.tare()
        self.force = 0.0

    def start(self, times: FloatArray, positions: FloatArray, velocities: FloatArray) -> None:
        self.spline = CubicHermiteSpline(times, positions, velocities)
        self.begun = self.moved.world.time + LAG
        self.sent.append(positions)

    def stop(self) -> None:
        self.spline, self.moved.q_target = None, self.moved.q

    def wait(self, seconds: float) -> None:
        for _ in range(max(1, round(seconds / self.moved.world.time_step))):
            speed = np.zeros_like(self.moved.q_target)
            if self.spline is not None and (now := self.moved.world.time - self.begun) >= 0.0:
                now = min(now, self.spline.x[-1])
                self.moved.q_target, speed = self.spline(now), self.spline(now, 1)
                self.spline = self.spline if now < self.spline.x[-1] else None
            self.moved._send(self.moved.q_target, speed)
            self.moved._advance()
            self.force = self.moved.wrist.force()

    def move(self, opening: float, force: float) -> None:
        _ = self.moved.open(opening) if opening > 0.0 else self.moved.close(force)

    def switch(self, on: bool) -> None:
        _ = self.moved.suck() if on else self.moved.unseal()


def behind_a_controller(arm: ActingArm) -> TrajectoryDriver:
    example = runpy.run_path(str(EXAMPLES / "13_mujoco_driver.py"))
    both = (example["Actuators"] if arm.world.engine == "mujoco" else Splines)(arm)
    return TrajectoryDriver(arm.arm, arm.pose_base_to_world, both, both)


@pytest.fixture(params=INSTALLED)
def arm(request) -> Iterator[ActingArm]:
    """An arm at a table with a box on it."""
    with playing_on(request.param), new_world() as world:
        world.add_table()
        world.add(shapes.box("box", (0.05, 0.05, 0.1)), pose_at(0, 0, 0))
        world.settle()
        yield arm_in(world, robot("panda"), BASE)


def test_a_transfer_goes_through_it_and_lets_go(arm):
    driver, world = behind_a_controller(arm), arm.world
    assert isinstance(driver, Driver)
    scene, before = on_table((world.body("box"), (0.0, 0.0, 0.0))), world.pose("box")
    transfer = plan_transfer("box", scene, Station(arm.arm, arm.pose_base_to_world, arm.q_target))
    assert isinstance(transfer, Transfer)
    outcome = execute(transfer, driver)
    assert outcome.success, outcome.text
    wanted = transfer.placement.pose_before_to_after @ before
    assert np.abs(world.pose("box")[:3, 3] - wanted[:3, 3]).max() < 0.01
    assert not driver.holding and np.abs(driver.q_target - transfer.q_end).max() < 0.01


def test_a_guarded_motion_stops_where_the_hand_is_held_up(arm):
    driver, way = behind_a_controller(arm), [np.asarray(arm.arm.home)]
    for height in np.linspace(0.2, 0.0, 21):
        way.append(arm.arm.inverse(down(0.5, 0.0, height)[None], "fingers", near=way[-1])[0][0])
    driver.close(10.0)
    driver.follow(retime(arm.arm, np.array(way[:2]), 0.5))
    assert driver.follow_until(retime(arm.arm, np.array(way[1:]), 0.1), 5.0) == 0.0
    assert not driver.controller.moving
    tip, standing = arm.arm.tool_pose(driver.q_target, "fingers")[0][2, 3], arm.q
    assert 0.09 < tip < 0.13, "it stands on the box, which it has not pushed through"
    driver.wait(0.3)
    assert np.abs(arm.q - standing).max() < 0.01
    assert arm.world.pose("box")[2, 3] == pytest.approx(0.0, abs=0.02)


def test_a_second_look_goes_through_it():
    with World() as world:
        world.add_table()
        world.add(shapes.box("wall", (0.03, 0.12, 0.05)), pose_at(0.06, 0.0, 0.0))
        world.add(shapes.block("low"), pose_at(0.0, 0.0, 0.0))
        world.add(shapes.block("upper"), pose_at(0.0, 0.0, 0.0502))
        world.settle()
        arm = SimulatedArm(world, robot("panda"), pose_at(-0.45, 0.0, 0.0))
        eye = Camera.looking_at((0.6, 0.1, 0.45), (0.0, 0.0, 0.05))
        loop = ClosedLoop.simulated(world, arm, [eye], "free low", wrist_camera=True)
        driver, first = behind_a_controller(arm), loop.look()
        assert loop.wrist is not None
        taken = second_look(loop.wrist, driver, first.situation, cautious(first.situation, ["low"]), seed=0)
        assert taken is not None
        assert np.linalg.norm(taken[0].viewpoint - taken[1].eye) < 0.01
        np.testing.assert_allclose(driver.q_target, arm.arm.home, atol=0.01)


def test_what_is_sent_begins_where_the_arm_is_held(arm):
    driver, home = TrajectoryDriver(arm.arm, BASE, Splines(arm)), np.asarray(arm.arm.home)
    driver.q_target = home + 0.01
    assert driver.follow(retime(arm.arm, np.stack([home, home + 0.1]), 0.5)) < 0.005
    (sent,) = driver.controller.sent
    assert np.allclose(sent[0], home + 0.01) and np.allclose(sent[-1], home + 0.1)
    driver.follow(retime(arm.arm, np.stack([home, home - 0.1]), 0.5), keep_offset=True)
    assert np.allclose(driver.controller.sent[-1][-1], home, atol=0.01)


def test_without_a_hand_it_follows_and_refuses_to_take(arm):
    driver = TrajectoryDriver(arm.arm, arm.pose_base_to_world, Splines(arm))
    driver.open()
    assert driver.opening == 0.0 and not driver.holding
    for take in (driver.suck, lambda: driver.close(10.0)):
        with pytest.raises(InvalidInput, match="no hand to take with"):
            take()


class Ros:
    """As much of ROS 2 as the example calls: one node, whose controller is that of the splines."""

    def __init__(self, splines: Splines) -> None:
        self.splines, self.pushed, self.told = splines, False, dict[str, Callable[[Any], None]]()
        goal = SimpleNamespace(trajectory=SimpleNamespace(joint_names=[], points=[]))
        self.FollowJointTrajectory = SimpleNamespace(Goal=lambda: deepcopy(goal))

    def __getattr__(self, name: str) -> Any:
        return lambda *_: self

    def JointTrajectoryPoint(self, **given: Any) -> Any:
        return SimpleNamespace(**given, time_from_start=SimpleNamespace(sec=0, nanosec=0))

    def create_subscription(self, _: Any, topic: str, call: Callable[[Any], None], __: int) -> None:
        self.told[topic] = call

    def now(self) -> Any:
        return SimpleNamespace(nanoseconds=round(1e9 * self.splines.moved.world.time))

    def spin_once(self, _: Any, timeout_sec: float) -> None:
        self.splines.wait(min(timeout_sec, 0.005))
        force = SimpleNamespace(x=0.0, y=0.0, z=5.0 + 50.0 * (self.pushed and self.splines.moving))
        self.told["wrench"](SimpleNamespace(wrench=SimpleNamespace(force=force)))
        now = {"name": self.splines.moved.arm.joints, "position": self.splines.joints.tolist()}
        self.told["joint_states"](SimpleNamespace(**now))

    def send_goal_async(self, goal: Any) -> Any:
        points = goal.trajectory.points
        times = [p.time_from_start.sec + 1e-9 * p.time_from_start.nanosec for p in points]
        ways = ([p.positions for p in points], [p.velocities for p in points])
        self.splines.start(*map(np.array, (times, *ways)))
        return self

    def cancel_goal_async(self) -> None:
        self.splines.stop()

    def done(self) -> bool:
        return not self.splines.moving


def test_the_example_sends_trajectories_to_a_controller_of_ros(arm, monkeypatch):
    ros, home = Ros(splines := Splines(arm)), np.asarray(arm.arm.home)
    messages = [f"{kind}_msgs.msg" for kind in ("sensor", "geometry", "trajectory")]
    for name in ("rclpy", "rclpy.action", "control_msgs.action", *messages):
        monkeypatch.setitem(sys.modules, name, ros)
    example = runpy.run_path(str(EXAMPLES / "12_ros_driver.py"))
    controller = example["RosArm"](ros, arm.arm)
    controller.wait(0.1)
    driver = TrajectoryDriver(arm.arm, arm.pose_base_to_world, controller)
    assert np.abs(driver.q_target - home).max() < 0.01
    path = retime(arm.arm, np.stack([home, home + 0.1]), 0.5)
    assert driver.follow(path) < 2e-3 and np.allclose(splines.sent[0], path.positions, atol=0.01)
    assert driver.follow_until(retime(arm.arm, np.stack([home + 0.1, home]), 0.5), 30.0) < 2e-3
    ros.pushed = True
    assert driver.follow_until(retime(arm.arm, np.stack([home, home + 0.3]), 0.2), 30.0) == 0.0
    assert np.abs(arm.q - home).max() < 0.05 and not controller.moving, "it was stopped at once"


@pytest.mark.slow
def test_the_dishes_are_cleared_through_it():
    with scenario("dishes", 0) as stage:
        loop = loop_in(stage)
        assert isinstance(loop.robot, ActingArm)
        record = replace(loop, robot=behind_a_controller(loop.robot)).run()
        assert record.success, record.violations
