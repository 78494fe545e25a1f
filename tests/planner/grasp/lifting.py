"""Lifts in PyBullet for the tests here: straight ways of the tool, solved one state after the other."""

import numpy as np

from topple.robots.arm.arm import Arm
from topple.robots.world.simulated_arm import SimulatedArm
from topple.topology.arrays import FloatArray


def at(x: float, y: float, z: float) -> FloatArray:
    pose = np.eye(4)
    pose[:3, 3] = [x, y, z]
    return pose


def table(x: float = 0.0) -> FloatArray:
    axis = np.arange(-0.4, 0.4, 0.006)
    grid = np.meshgrid(axis + x, axis)
    return np.column_stack([grid[0].ravel(), grid[1].ravel(), np.zeros(grid[0].size)])


class Way:
    """Joint values, one after the other in equal times."""

    def __init__(self, states: FloatArray, seconds: float = 1.5) -> None:
        self.positions = states
        self.times = np.linspace(0.0, seconds, len(states))
        self.velocities = np.gradient(states, self.times, axis=0)


def straight(
    robot: SimulatedArm, arm: Arm, start: FloatArray, end: FloatArray, tool: str = "fingers"
) -> None:
    """Drive the tool straight from one pose to another without turning it."""
    states = [robot.q_target]
    for share in np.linspace(0.0, 1.0, 12):
        states.append(arm.inverse(start + share * (end - start), tool, near=states[-1])[0][0])
    robot.follow(Way(np.array(states[1:])))
