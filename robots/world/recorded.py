"""A recording of the world that an arm acts in, where its engine can be recorded."""

from typing import TYPE_CHECKING

from topple.robots.world.acting_arm import ActingArm
from topple.topology.errors import InvalidInput

if TYPE_CHECKING:
    from topple.robots.world.recording import Recording


def recorded(robot: ActingArm, rate: float) -> "Recording":
    """Record what happens from now on.

    Args:
        robot: The arm; its world is recorded.
        rate: Samples a second.

    Raises:
        InvalidInput: The world is not played on PyBullet.
    """
    if robot.world.engine != "bullet":
        raise InvalidInput("recordings (--rerun) are of the engine bullet: leave out --engine, or --rerun")
    from topple.robots.world.recording import Recording
    from topple.robots.world.simulated_arm import SimulatedArm

    assert isinstance(robot, SimulatedArm)
    return Recording(robot, rate)
