"""A Panda of MuJoCo's position actuators as a `Driver`: it frees a plate, and true poses judge it."""

import sys
from dataclasses import replace
from typing import Any

import numpy as np
from PIL import Image
from scipy.interpolate import CubicHermiteSpline

from topple.planner.execution.demo import loop_in
from topple.robots import scenario
from topple.robots.arm.gripper import ToolState
from topple.robots.driver.trajectories import TrajectoryDriver

# stiffness [N m/rad], damping, limit [N m] of the arm as in MuJoCo Menagerie; of fingers and a cup [N/m], [N]
GAINS = np.array([(4500, 450, 87)] * 2 + [(3500, 350, 87)] * 2 + [(2000, 200, 12)] * 3 + [(1e4, 80, 100)] * 3)
SPEED = np.array([0.05, 0.05, 0.2])  # [m/s] of fingers and cup


class Actuators:
    """A `Controller` and a `HandController`: what they send is a position for each joint of arm and hand."""

    def __init__(self, arm: Any) -> None:
        self.arm, self.world, self.tare, self.extend, self.force = arm, arm.world, arm.tare, arm.extend, 0.0
        self.at, self.dof = np.array([self.world.joint(name) for name in arm.joint_names]).T
        self.gains, self.sent, self.push = GAINS[: len(self.at)].copy(), arm.joint_targets[7:], 5.0
        self.pads, self.world.drive = self.sent[:2], self.actuate
        self.stop()

    joints, opening = property(lambda self: self.arm.q), property(lambda self: self.arm.opening)
    sealed, moving = property(lambda self: self.arm.sealed), property(lambda self: self.world.time < self.end)

    def actuate(self) -> None:
        """Send the arm ahead of its lag and sag, and the hand only as far as its springs may push."""
        (model, data), (kp, kv, most), count = self.world.state, self.gains.T, len(self.sent)
        model.actuator_gainprm[:, 0], model.actuator_biasprm[:, 1:3] = kp, -self.gains[:, :2]
        model.actuator_forcelimited[:], model.actuator_forcerange[:] = True, np.outer(most, (-1.0, 1.0))
        weight = (data.qfrc_bias - data.qfrc_passive)[self.dof[:7]]
        told = np.array([*self.pads, self.arm.tool_state.cup_extension])[:count]
        stride = SPEED[:count] * model.opt.timestep
        self.sent = np.clip(told, self.sent - stride, self.sent + stride)
        push = np.array([self.push, self.push, 10.0 if self.sealed is None else 100.0])[:count]
        ahead = self.sent - data.qpos[self.at[7:]]
        self.sent -= ahead - np.clip(ahead, -push / kp[7:], push / kp[7:])
        data.ctrl[:] = [*(self.q + (kv[:7] * self.v + weight) / kp[:7]), *self.sent]

    def start(self, times: Any, positions: Any, velocities: Any) -> None:  # noqa: D102
        self.begun, self.end = self.world.time, self.world.time + times[-1] - 1e-9
        self.way = CubicHermiteSpline(times, positions, velocities)

    def stop(self) -> None:  # noqa: D102
        self.q, self.v, self.end = self.arm.q, np.zeros(7), 0.0

    def wait(self, seconds: float) -> None:  # noqa: D102
        for _ in range(max(1, round(seconds / self.world.time_step))):
            if self.moving:
                now = min(self.world.time + self.world.time_step - self.begun, self.way.x[-1])
                self.q, self.v = self.way(now), self.way(now, 1) * (now < self.way.x[-1])
                if np.abs(self.arm.q - self.q).max() > 0.03:  # [rad] it was pushed off
                    self.stop()
            self.arm.step()
            self.force = self.arm.wrist.force()

    def switch(self, on: bool) -> None:  # noqa: D102
        _ = self.arm.suck() if on else self.arm.unseal()

    def move(self, opening: float, force: float) -> None:  # noqa: D102
        self.pads = list(self.arm.jaw.values(ToolState(opening)).values())
        for share in (0.05, 1.0) if opening == 0.0 else (1.0,):  # the arm gives way until both pads touch
            self.gains[:7, :2], self.push = share * GAINS[:7, :2], force if share == 1.0 else min(force, 5.0)
            before = np.inf
            while abs(before - self.opening) > 1e-4:
                before = self.opening
                self.wait(0.1)
            if share < 1.0:
                self.stop()


if __name__ == "__main__":
    for seed in map(int, sys.argv[1:] or "0"):
        with scenario("dishes", seed, "mujoco") as stage:
            loop = loop_in(stage, seed=seed)
            there = Actuators(arm := loop.robot)
            driver = TrajectoryDriver(arm.arm, arm.pose_base_to_world, there, there)
            print(f"seed {seed}: {replace(loop, robot=driver).run().summary}", flush=True)
            picture = stage.cameras[0].look(stage.world, np.random.default_rng(0)).rgb
            Image.fromarray(picture).save("mujoco_driver.png")
