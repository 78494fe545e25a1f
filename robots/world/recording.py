"""What happened in a world while an arm acted in it: poses of everything, sampled as time goes by."""

from dataclasses import dataclass, field

from topple.robots.world.acting_arm import ActingArm
from topple.robots.world.physical_world import Constraint
from topple.topology.base.arguments import checked_arguments
from topple.topology.base.arrays import FloatArray

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
        joints: For each sample (k,) values [rad] or [m] of every joint of the arm, then of its hand.
        constraints: For each sample what ties bodies together.

    Examples:
        >>> with World() as world:
        ...     arm = SimulatedArm(world, robot("panda"), np.eye(4))
        ...     taken = Recording(arm)
        ...     arm.wait(0.1)
        >>> len(taken.times)
        7
    """

    robot: ActingArm
    rate: float = RATE
    times: list[float] = field(default_factory=list[float])
    poses: list[dict[str, FloatArray]] = field(default_factory=list[dict[str, FloatArray]])
    links: list[dict[str, FloatArray]] = field(default_factory=list[dict[str, FloatArray]])
    joints: list[FloatArray] = field(default_factory=list[FloatArray])
    constraints: list[tuple[Constraint, ...]] = field(default_factory=list[tuple[Constraint, ...]])

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
        robot, world = self.robot, self.robot.world
        self.times.append(world.time)
        self.poses.append(world.poses())
        self.links.append(robot.link_poses())
        self.joints.append(robot.joint_positions(robot.joint_names))
        self.constraints.append(world.constraints())
