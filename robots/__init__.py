"""What can act: arms, grippers, cameras, bodies and the PyBullet world they share."""

from typing import TYPE_CHECKING

from topple.topology.base.public_names import lazy_names

if TYPE_CHECKING:
    from topple.robots.arm.gripper import ToolState
    from topple.robots.catalog import robot
    from topple.robots.driver import Driver
    from topple.robots.engines import arm_in, new_world
    from topple.robots.scenarios.by_name import scenario
    from topple.robots.scenarios.scenario import around
    from topple.robots.world.bodies import Body
    from topple.robots.world.camera import Camera
    from topple.robots.world.observe import scene_from_world
    from topple.robots.world.recording import Recording
    from topple.robots.world.simulated_arm import SimulatedArm
    from topple.robots.world.world import World

__all__ = [
    "Body",
    "Camera",
    "Driver",
    "Recording",
    "SimulatedArm",
    "ToolState",
    "World",
    "arm_in",
    "around",
    "new_world",
    "robot",
    "scenario",
    "scene_from_world",
]

__getattr__, __dir__ = lazy_names(
    __name__,
    {
        "arm.gripper": "ToolState",
        "catalog": "robot",
        "driver": "Driver",
        "engines": "arm_in new_world",
        "scenarios.by_name": "scenario",
        "scenarios.scenario": "around",
        "world.bodies": "Body",
        "world.camera": "Camera",
        "world.observe": "scene_from_world",
        "world.recording": "Recording",
        "world.simulated_arm": "SimulatedArm",
        "world.world": "World",
    },
)
