"""A scene in another frame, of another size, or with objects elsewhere."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from topple.topology.base.arrays import FloatArray
from topple.topology.geometry.rigid import move_points
from topple.topology.scene.cloud import clean
from topple.topology.scene.mesh import Mesh
from topple.topology.scene.scene import Scene


def in_frame(scene: Scene, pose_scene_to_frame: FloatArray, up: FloatArray) -> Scene:
    """Give a scene in another frame, as clouds: images, meshes and the robot's base are left out.

    Args:
        scene: The scene.
        pose_scene_to_frame: (4, 4) rigid transform.
        up: (3,) against gravity in that frame.
    """
    return Scene(
        {name: clean(move_points(cloud, pose_scene_to_frame)) for name, cloud in scene.clouds.items()},
        sorted(scene.fixed),
        up,
        move_points(scene.viewpoints, pose_scene_to_frame) if len(scene.viewpoints) else None,
        assumptions=scene.assumptions,
        masses=scene.masses,
        friction=scene.friction,
        models={name: fit.moved(pose_scene_to_frame) for name, fit in scene.models.items()},
        matter=move_points(scene.matter, pose_scene_to_frame),
        centres={n: move_points(each[None], pose_scene_to_frame)[0] for n, each in scene.centres.items()},
    )


def enlarge(scene: Scene, factor: float) -> Scene:
    """Give a scene in which everything is larger by a factor, masses by its cube.

    Args:
        scene: The scene; meshes, matter and the robot's base are left out.
        factor: How many times as long everything is.
    """
    return Scene(
        {name: cloud * factor for name, cloud in scene.clouds.items()},
        sorted(scene.fixed),
        scene.up,
        scene.viewpoints * factor,
        [image.enlarged(factor) for image in scene.images],
        assumptions=scene.assumptions,
        masses={name: mass * factor**3 for name, mass in scene.masses.items()},
        friction=scene.friction,
        models={name: replace(fit, seen=fit.seen * factor) for name, fit in scene.models.items()},
        centres={name: centre * factor for name, centre in scene.centres.items()},
    )


def shift_objects(scene: Scene, shifts: Mapping[str, FloatArray]) -> Scene:
    """Give a scene of whole surfaces with some objects elsewhere, their meshes and centres with them.

    Args:
        scene: The scene, which no camera saw.
        shifts: name -> (3,) how far, in the scene's frame [m].
    """
    places = {name: shifts.get(name, np.zeros(3)) for name in scene.names}
    return Scene(
        {name: cloud + places[name] for name, cloud in scene.clouds.items()},
        [name for name in scene.names if name in scene.fixed],
        scene.up,
        meshes={n: Mesh(mesh.vertices + places[n], mesh.faces) for n, mesh in scene.meshes.items()},
        robot_base=scene.robot_base,
        assumptions=scene.assumptions,
        masses=scene.masses,
        friction=scene.friction,
        models=scene.models,
        matter=scene.matter,
        centres={name: centre + places[name] for name, centre in scene.centres.items()},
    )
