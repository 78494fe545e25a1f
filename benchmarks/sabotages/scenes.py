"""Other scenes than the plan was made for."""

import numpy as np

from topple.topology.scene.scene import Scene


def another_up(scene: Scene, _target: str) -> Scene:
    return scene.with_up([0.0, np.sin(0.1), np.cos(0.1)])


def forty_points(scene: Scene, target: str) -> Scene:
    cloud = scene.clouds[target]
    return scene.with_cloud(target, cloud[np.linspace(0, len(cloud) // 3, 40).astype(int)])


def thing_elsewhere(scene: Scene, target: str) -> Scene:
    return scene.with_cloud(target, scene.clouds[target] + np.array([0.03, 0.0, 0.0]))


def thing_larger(scene: Scene, target: str) -> Scene:
    cloud = scene.clouds[target]
    return scene.with_cloud(target, cloud.mean(axis=0) + 1.4 * (cloud - cloud.mean(axis=0)))


def arm_20_cm_beside(scene: Scene, _target: str) -> Scene:
    base = np.eye(4)
    base[:2, 3] = (-0.5, 0.2)  # plans are made with an arm half a metre behind
    return scene.with_base(base)


def thing_of_30_kg(scene: Scene, target: str) -> Scene:
    return scene.weighed({target: 30.0})


def thing_of_4_kg(scene: Scene, target: str) -> Scene:
    """More than a Panda is rated for, and less than its hand holds."""
    return scene.weighed({target: 4.0})
