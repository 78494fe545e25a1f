"""The same scene told differently has the same dependencies and is taken apart in the same order."""

import sys
from pathlib import Path

import numpy as np
import pytest

from topple.planner.planning.order import order
from topple.topology.scene.scene import Scene

sys.path.insert(0, str(Path(__file__).parents[2] / "topology"))
from made import CHANGES, pile, seen, whole


def decided(scene: Scene) -> tuple[set[tuple[str, str, str]], list[str]]:
    """Dependencies with their reasons, and the order that takes everything near."""
    found = order(scene, [name for name in scene.movable if name != "far"])
    edges = {(edge.first, edge.then, str(edge.reason)) for edge in found.graph.dependencies}
    return {edge for edge in edges if "far" not in edge}, [name for name in found.order if name != "far"]


def same(change: str, cameras: int, seed: int) -> bool:
    """Whether what is decided of a made scene stays after a change."""
    rng = np.random.default_rng(seed)
    boxes = pile(rng)
    scene = seen(boxes, rng, cameras) if cameras else whole(boxes, rng)
    return decided(CHANGES[change](scene, rng)) == decided(scene)


@pytest.mark.parametrize("change", CHANGES)
def test_what_changes_nothing_in_the_scene_changes_no_step(change):
    assert same(change, 0, seed=3)


@pytest.mark.slow
@pytest.mark.parametrize("change", CHANGES)
@pytest.mark.parametrize("cameras", [0, 1, 3])
def test_of_many_scenes_hardly_one_is_taken_apart_differently(change, cameras):
    assert sum(same(change, cameras, seed) for seed in range(20, 40)) >= 19
