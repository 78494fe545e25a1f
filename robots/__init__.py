"""What can act: arms, grippers, cameras, bodies and the PyBullet world they share."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from topple.robots.catalog import robot
    from topple.robots.world.bodies import Body
    from topple.robots.world.camera import Camera
    from topple.robots.world.observe import scene_from_world
    from topple.robots.world.recording import Recording
    from topple.robots.world.simulated_arm import SimulatedArm
    from topple.robots.world.world import World

__all__ = [
    "Body",
    "Camera",
    "Recording",
    "SimulatedArm",
    "World",
    "robot",
    "scene_from_world",
]

_HOME = {
    "Body": "world.bodies",
    "Camera": "world.camera",
    "Recording": "world.recording",
    "SimulatedArm": "world.simulated_arm",
    "World": "world.world",
    "robot": "catalog",
    "scene_from_world": "world.observe",
}


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used: PyBullet takes a third of a second."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
    globals()[name] = value
    return value
