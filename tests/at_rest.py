"""Scenes at rest for the tests of truth, and what physics says of them."""

import numpy as np

from topple.benchmarks.truth.geometry import relations_of
from topple.benchmarks.truth.oracle import labels_of
from topple.benchmarks.truth.resting import RestingScene
from topple.robots.world.bodies import Body


def at_rest(*placed: tuple[Body, np.ndarray]) -> RestingScene:
    bodies = tuple(body for body, _ in placed)
    scene = RestingScene(bodies, {body.name: pose for body, pose in placed})
    with scene.world() as world:
        world.settle(2.0)
        return RestingScene(bodies, world.poses())


def labelled(scene: RestingScene) -> tuple[dict[str, dict[str, int | None]], dict[tuple[str, str], str]]:
    with scene.world() as world:
        return labels_of(world, list(scene.poses)), dict(relations_of(scene, world))
