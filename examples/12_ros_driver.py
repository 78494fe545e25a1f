"""An arm of ROS 2 as a `Driver`: its joint trajectory controller and its wrist, without the gripper."""

from importlib import import_module
from typing import Any

import numpy as np

from topple.robots import robot
from topple.robots.driver.trajectories import TrajectoryDriver


class RosArm:
    """A `Controller`: a client of FollowJointTrajectory."""

    def __init__(self, node: Any, arm: Any, name: str = "arm_controller/follow_joint_trajectory") -> None:
        self.ros, self.node, self.names, self.ended = import_module("rclpy"), node, arm.joints, None
        self.action = import_module("control_msgs.action").FollowJointTrajectory
        self.client = import_module("rclpy.action").ActionClient(node, self.action, name)
        self.q, self.felt, self.bias = dict.fromkeys(arm.joints, np.nan), np.zeros(3), np.zeros(3)
        states, wrenches = import_module("sensor_msgs.msg"), import_module("geometry_msgs.msg")
        take = lambda told: self.q.update(zip(told.name, told.position, strict=True))  # noqa: E731
        node.create_subscription(states.JointState, "joint_states", take, 1)
        press = lambda told: np.copyto(self.felt, [getattr(told.wrench.force, at) for at in "xyz"])  # noqa: E731
        node.create_subscription(wrenches.WrenchStamped, "wrench", press, 1)

    joints = property(lambda self: np.array([self.q[name] for name in self.names]))
    force = property(lambda self: float(np.linalg.norm(self.felt - self.bias)))
    moving = property(lambda self: self.ended is not None and not self.ended.done())

    def tare(self) -> None:  # noqa: D102
        self.wait(0.1)
        self.bias = self.felt.copy()

    def start(self, times: Any, positions: Any, velocities: Any) -> None:  # noqa: D102
        point, goal = import_module("trajectory_msgs.msg").JointTrajectoryPoint, self.action.Goal()
        goal.trajectory.joint_names = list(self.names)
        for when, q, v in zip(times, positions, velocities, strict=True):
            goal.trajectory.points.append(way := point(positions=q.tolist(), velocities=v.tolist()))
            way.time_from_start.sec, way.time_from_start.nanosec = divmod(round(1e9 * when), 10**9)
        self.ros.spin_until_future_complete(self.node, sent := self.client.send_goal_async(goal))
        self.goal, self.ended = sent.result(), sent.result().get_result_async()

    def stop(self) -> None:  # noqa: D102
        self.ros.spin_until_future_complete(self.node, self.goal.cancel_goal_async())

    def wait(self, seconds: float) -> None:  # noqa: D102
        end = (now := self.node.get_clock().now)().nanoseconds + 1e9 * seconds
        while (left := end - now().nanoseconds) > 0:
            self.ros.spin_once(self.node, timeout_sec=left / 1e9)


if __name__ == "__main__":
    import_module("topple.planner.cli.main").main(["robot", "panda", "--report", "ros_driver.png"])
    try:
        (ros := import_module("rclpy")).init()
        (there := RosArm(ros.create_node("topple"), robot("panda"))).wait(1.0)
        print("the arm is at", TrajectoryDriver(robot("panda"), np.eye(4), there).q_target.round(3))
    except ModuleNotFoundError as error:
        print(f"no ROS 2 here ({error}): source its setup first")
