"""Scenes that everybody knows, from small parts to crates: the drawing tells, whatever its size."""

import json

import networkx as nx
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import topple
from topple.benchmarks.truth.pool import PoolScene, pool
from topple.benchmarks.truth.views import WIDE, seen
from topple.topology import DepthImage, Scene
from topple.topology.base.arrays import FloatArray
from topple.topology.scene.frame import enlarge
from topple.topology.situation.situation import Situation

Block = tuple[tuple[float, float, float], tuple[float, float, float], float]
"""Edges [dm], middle [dm], by how much it leans back about y [degrees]."""

PIERS: dict[str, Block] = {"left": ((0.5, 0.8, 1), (-1, 0, 0.5), 0), "right": ((0.5, 0.8, 1), (1, 0, 0.5), 0)}
POSTS: dict[str, Block] = {
    f"post {x} {y}": ((0.3, 0.3, 1), (x, 0.7 * y, 0.5), 0) for x in (-1, 1) for y in (-1, 1)
}
SINE, COSINE = np.sin(np.radians(20)), np.cos(np.radians(20))
SCENES: dict[str, tuple[dict[str, Block], set[tuple[str, str]]]] = {
    "bridge": (PIERS | {"bridge": ((3, 0.8, 0.4), (0, 0, 1.2), 0)}, {("bridge", pier) for pier in PIERS}),
    "slab on posts": (
        POSTS | {"slab": ((2.6, 2, 0.2), (0, 0, 1.1), 0)}, {("slab", post) for post in POSTS},
    ),
    "leaning book": (
        {
            "block": ((0.8, 1, 1.8), (0, 0, 0.9), 0),
            "book": ((0.2, 1.2, 1.6), (0.4 + 0.1 * COSINE + 0.8 * SINE, 0, 0.8 * COSINE + 0.1 * SINE), -20),
        },
        {("book", "block")},
    ),
    "tower and neighbour": (
        {f"cube {k}": ((1, 1, 1), (0, 0, 0.5 + k), 0) for k in range(3)}
        | {"side": ((1, 1, 1), (1.2, 0, 0.5), 0)},
        {("cube 1", "cube 0"), ("cube 2", "cube 1"), ("cube 2", "cube 0")},
    ),
}  # fmt: skip


def surface(block: Block, rng: np.random.Generator) -> FloatArray:
    """2,000 points on a block [dm]."""
    edges, middle, lean = block
    x, y, z = edges
    faces = rng.choice(6, 2000, p=np.repeat([y * z, x * z, x * y], 2) / (2 * (y * z + x * z + x * y)))
    points = rng.uniform(-0.5, 0.5, (2000, 3))
    points[np.arange(2000), faces // 2] = faces % 2 - 0.5
    return Rotation.from_euler("y", lean, degrees=True).apply(points * edges) + middle


@pytest.mark.parametrize(
    "size", [0.01, 0.05, 0.6, *(pytest.param(each, marks=pytest.mark.slow) for each in (0.02, 0.1, 0.3))]
)
@pytest.mark.parametrize("name", SCENES)
def test_a_textbook_scene_is_told_as_it_is_drawn(name, size):
    blocks, wanted = SCENES[name]
    rng = np.random.default_rng(7)
    noise = 2e-4 if size < 0.1 else 1e-3
    side = np.linspace(-4, 4, 120)
    clouds = {"table": np.stack([*np.meshgrid(side, side), np.zeros((120, 120))], axis=-1).reshape(-1, 3)}
    clouds |= {name: surface(block, rng) for name, block in blocks.items()}
    scene = Scene(
        {name: points * size + rng.normal(0, noise, points.shape) for name, points in clouds.items()},
        fixed=["table"], up=(0, 0, 1),
    )  # fmt: skip
    order = topple.order(scene)
    edges = nx.transitive_closure(nx.DiGraph([(d.first, d.then) for d in order.graph.dependencies])).edges
    assert set(edges) == wanted
    assert not order.groups


def test_pictures_are_enlarged_with_what_they_show():
    scene = _pictured(next(scene for scene in pool() if scene.set == "settled"))
    small = Situation(enlarge(scene, 0.1))
    assert small.sized.unit == pytest.approx(0.1, rel=0.6)
    assert Situation(scene).sized.unit == 1.0
    places = np.concatenate([scene.clouds[name] for name in scene.movable])
    large = small.sized
    assert large.shown(places * 0.1 / large.unit, 0.01).all()
    behind = places + 0.05 * (places - scene.viewpoints[0])
    seen_behind = [Situation(scene).shown(behind, 0.005), large.shown(behind * 0.1 / large.unit, 0.005)]
    assert (seen_behind[0] == seen_behind[1]).mean() > 0.95
    past = scene.images[0].depth_past(behind, around=True)  # what was asked is not kept in the larger picture
    assert np.allclose(scene.images[0].enlarged(3.0).depth_past(behind * 3.0, around=True), past * 3.0)


def test_a_scene_asked_again_gives_the_same_relations():
    scene = _pictured(next(scene for scene in pool() if scene.name == "settled 44000020"))
    assert len({json.dumps(topple.relate(scene).to_json()) for _ in range(2)}) == 1


def test_three_cameras_tell_most_boards_from_what_they_lean_on():
    scenes = [scene for scene in pool() if scene.set == "leaning"][:12]  # of those that teach nothing
    told = [
        {(d.first, d.then) for d in topple.order(_pictured(scene, 3)).graph.dependencies} for scene in scenes
    ]
    lean = [
        (board, "wall") in found
        for scene, found in zip(scenes, told, strict=True)
        for board, moves in scene.labels["wall"].items()
        if moves and board.startswith("board")
    ]
    assert len(lean) >= 12 and np.mean(lean) >= 0.6


def _pictured(pile: PoolScene, cameras: int = 1) -> Scene:
    """A scene as cameras see it."""
    arrays = seen(pile.resting, cameras, 0, WIDE)
    names = {k + 1: str(name) for k, name in enumerate(arrays["names"])}
    images = [
        DepthImage(
            arrays[f"depth_{k}"].astype(float),
            arrays["K"],
            arrays[f"label_{k}"].astype(int),
            arrays[f"pose_{k}"],
            names,
        )
        for k in range(cameras)
    ]
    return Scene.from_images(images, fixed=["table"], up=(0, 0, 1))
