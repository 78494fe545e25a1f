"""What happened in a world while an arm acted in it: poses of everything, sampled as time goes by."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from topple.robots.engine import pybullet
from topple.robots.world.simulated_arm import SimulatedArm
from topple.topology.arguments import checked_arguments
from topple.topology.arrays import FloatArray

RATE = 60.0  # samples a second of simulated time: enough for a smooth picture, and to tell a fall from a jump


@checked_arguments
@dataclass
class Recording:
    """Samples the world's state from the moment it is made on.

    Attributes:
        robot: The arm; its world is recorded.
        rate: Samples a second.
        times: Simulated time of each sample in [s].
        poses: For each sample name -> (4, 4) pose_object_to_world.
        links: For each sample name -> (4, 4) pose_link_to_world of every link of the arm and its hand.
        joints: For each sample (k,) values of every joint of the arm and its hand, as PyBullet numbers them.
        constraints: For each sample what ties bodies together.
    """

    robot: SimulatedArm
    rate: float = RATE
    times: list[float] = field(default_factory=list[float])
    poses: list[dict[str, FloatArray]] = field(default_factory=list[dict[str, FloatArray]])
    links: list[dict[str, FloatArray]] = field(default_factory=list[dict[str, FloatArray]])
    joints: list[FloatArray] = field(default_factory=list[FloatArray])
    constraints: list[tuple["Constraint", ...]] = field(default_factory=list[tuple["Constraint", ...]])

    def __post_init__(self) -> None:
        """Take the first sample and ask to be called at every step."""
        self._sample()
        self.robot.on_step.append(self._on_step)

    def stop(self) -> None:
        """Record no more."""
        self.robot.on_step.remove(self._on_step)

    def _on_step(self) -> None:
        if self.robot.world.time >= self.times[-1] + 1.0 / self.rate - 1e-9:
            self._sample()

    def _sample(self) -> None:
        world, client = self.robot.world, self.robot.world.client
        self.times.append(world.time)
        self.poses.append(world.poses())
        self.links.append(self.robot.link_poses())
        count = pybullet.getNumJoints(self.robot.id, physicsClientId=client)
        states: Any = pybullet.getJointStates(self.robot.id, list(range(count)), physicsClientId=client)
        self.joints.append(np.array([state[0] for state in states]))
        self.constraints.append(constraints(self.robot))


@dataclass(frozen=True)
class Constraint:
    """Something that ties two bodies together.

    Attributes:
        kind: PyBullet's number of the joint's type.
        parent: Name of one body; "robot" for the arm.
        child: Name of the other.
        max_force: What it holds at most in [N].
    """

    kind: int
    parent: str
    child: str
    max_force: float


def constraints(robot: SimulatedArm) -> tuple[Constraint, ...]:
    """Every constraint in the arm's world.

    Args:
        robot: The arm.
    """
    client = robot.world.client
    count: int = pybullet.getNumConstraints(physicsClientId=client)
    found: list[Constraint] = []
    for k in range(count):
        number = pybullet.getConstraintUniqueId(k, physicsClientId=client)
        info: Any = pybullet.getConstraintInfo(number, physicsClientId=client)
        parent, child = (
            "robot" if body == robot.id else robot.world.name_of(body) or "nobody"
            for body in (info[0], info[2])
        )
        found.append(Constraint(int(info[4]), parent, child, float(info[10])))
    return tuple(found)
