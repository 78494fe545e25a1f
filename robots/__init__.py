"""What can act: arms, grippers, cameras, bodies and the PyBullet world they share."""

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from topple.robots.bodies import Body as Body
    from topple.robots.camera import Camera as Camera
    from topple.robots.catalog import robot as robot
    from topple.robots.observe import scene_from_world as scene_from_world
    from topple.robots.world import World as World

_HOMES = {
    "Body": "topple.robots.bodies",
    "Camera": "topple.robots.camera",
    "World": "topple.robots.world",
    "robot": "topple.robots.catalog",
    "scene_from_world": "topple.robots.observe",
}
__all__ = ["Body", "Camera", "World", "robot", "scene_from_world"]


def __getattr__(name: str) -> Any:
    """Import what is asked for when it is asked for: PyBullet takes a third of a second."""
    if name not in _HOMES:
        raise AttributeError(f"module 'topple.robots' has no attribute {name!r}")
    return getattr(importlib.import_module(_HOMES[name]), name)
