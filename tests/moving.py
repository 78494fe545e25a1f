"""Simple motions of simulated arms, for tests in which a real one takes part."""

import numpy as np

from topple.robots.world.simulated_arm import SimulatedArm
from topple.topology.base.arrays import FloatArray

FLIP = np.diag([1.0, -1.0, -1.0, 1.0])  # a tool that points down


class Way:
    """Joint values (t, n), one after the other in equal times."""

    def __init__(self, states: FloatArray, seconds: float = 1.5) -> None:
        self.positions = states
        self.times = np.linspace(0.0, seconds, len(states))
        self.velocities = np.gradient(states, self.times, axis=0)

    @classmethod
    def between(cls, start: FloatArray, end: FloatArray, seconds: float = 1.5) -> "Way":
        """A smooth motion from one state (n,) to another."""
        u = np.linspace(0.0, 1.0, 50)[:, None]
        return cls(start + (10 * u**3 - 15 * u**4 + 6 * u**5) * (end - start), seconds)


def at(x: float, y: float, z: float) -> FloatArray:
    """(4, 4) a place in [m], upright."""
    pose = np.eye(4)
    pose[:3, 3] = [x, y, z]
    return pose


def down(x: float, y: float, z: float) -> FloatArray:
    """(4, 4) a tool at a place in [m] that points down."""
    return at(x, y, z) @ FLIP


def way_to(arm: SimulatedArm, pose: FloatArray, tool: str = "fingers", seconds: float = 1.5) -> Way:
    """A smooth joint motion from where an arm is to where its tool has a pose in the base."""
    return Way.between(arm.q_target, arm.arm.inverse(pose, tool, near=arm.q_target)[0][0], seconds)


def go(arm: SimulatedArm, pose: FloatArray, tool: str = "fingers") -> float:
    """Move an arm until its tool has a pose in the base; the joint error at the end in [rad]."""
    return arm.follow(way_to(arm, pose, tool))


def straight(arm: SimulatedArm, start: FloatArray, end: FloatArray, tool: str = "fingers") -> None:
    """Drive the tool straight from one pose to another without turning it."""
    states = [arm.q_target]
    for share in np.linspace(0.0, 1.0, 12):
        states.append(arm.arm.inverse(start + share * (end - start), tool, near=states[-1])[0][0])
    arm.follow(Way(np.array(states[1:])))
