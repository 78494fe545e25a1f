"""A scene in another frame."""

from topple.topology.arrays import FloatArray
from topple.topology.cloud import clean
from topple.topology.geometry.rigid import transformed
from topple.topology.scene import Scene


def in_frame(scene: Scene, pose_scene_to_frame: FloatArray, up: FloatArray) -> Scene:
    """Give a scene in another frame, as clouds: images, meshes and the robot's base are left out.

    Args:
        scene: The scene.
        pose_scene_to_frame: (4, 4) rigid transform.
        up: (3,) against gravity in that frame.
    """
    return Scene(
        {name: clean(transformed(cloud, pose_scene_to_frame)) for name, cloud in scene.clouds.items()},
        sorted(scene.fixed),
        up,
        transformed(scene.viewpoints, pose_scene_to_frame) if len(scene.viewpoints) else None,
        assumptions=scene.assumptions,
        masses=scene.masses,
        friction=scene.friction,
        models={name: fit.moved(pose_scene_to_frame) for name, fit in scene.models.items()},
        matter=transformed(scene.matter, pose_scene_to_frame),
    )
