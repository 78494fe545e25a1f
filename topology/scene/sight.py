"""What the cameras of a scene saw to be empty."""

from topple.topology.base.arrays import FloatArray
from topple.topology.scene.scene import Scene
from topple.topology.scene.tolerances import RAYS
from topple.topology.views.free_space import FreeSpace


def seen_in(scene: Scene) -> FreeSpace | None:
    """Gather the space that cameras saw to be empty; None where no camera is known."""
    if not scene.images and len(scene.viewpoints) == 0:
        return None
    clouds = {name: seen_points(scene, name) for name in scene.names}
    return FreeSpace(clouds, scene.viewpoints, scene.images)


def seen_points(scene: Scene, name: str) -> FloatArray:
    """(N, 3) points of an object that end lines of sight [m]: a spread of them, of a dense cloud."""
    cloud = scene.seen(name)
    return cloud[:: -(-len(cloud) // RAYS)]
