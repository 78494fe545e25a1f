"""What people hand over in memory: taken, or refused in one clear line."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import trimesh

import topple
from topple.topology import DepthImage, Scene, scene_from_objects, scene_from_rgbd

RNG = np.random.default_rng(0)
FLAT = RNG.uniform(-0.3, 0.3, (800, 3)) * [1, 1, 0]
BOX = np.asarray(trimesh.creation.box((0.1, 0.1, 0.1)).sample(500, seed=0)) + np.array([0, 0, 0.05])
CLOUDS = {"table": FLAT, "box": BOX}
MESH = trimesh.creation.box((0.1, 0.1, 0.1))
K = np.array([[30.0, 0, 15], [0, 30, 10], [0, 0, 1]])
ONES = np.ones((20, 30))


def _scene(fixed: Any = "table") -> Scene:
    return Scene(CLOUDS, fixed, (0, 0, 1))


@pytest.mark.parametrize(
    "names", ["box", np.str_("box"), ["box"], ("box",), {"box"}, np.array(["box"]), np.array("box")], ids=repr
)
def test_names_may_come_in_any_collection_or_as_one(names):
    assert topple.order(_scene(), names).order == ("box",)
    assert _scene(names).fixed == {"box"}


def test_a_path_is_taken_where_a_scene_is(tmp_path):
    path = tmp_path / "scene.npz"
    np.savez(path, up=[0, 0, 1], **CLOUDS)
    down = np.diag([1.0, -1, -1, 1])
    down[2, 3] = 0.08
    for given in (path, str(path)):
        assert topple.order(given).order == ("box",)
        assert topple.relate(given).between("table", "box").relation == "touch"
        assert len(topple.rank_grasps(given, down[None])) == 1
    assert Scene.from_images(DepthImage(ONES, K, ONES.astype(int))).names == ("1",)


REFUSED: dict[str, tuple[Callable[[], object], str]] = {
    "a number as fixed": (lambda: _scene(3), r"fixed is 3: expected Iterable\[str\] \| str \| None"),
    "a list of clouds": (
        lambda: Scene([FLAT, BOX]),
        r"clouds is of <class 'list'>: expected Mapping\[str, array\]",
    ),
    "one cloud": (lambda: Scene(BOX), "clouds is of <class 'numpy.ndarray'>"),
    "one mesh": (lambda: scene_from_objects(MESH), r"objects is of <class 'trimesh.*expected Mapping\[str"),
    "a scene of trimesh": (
        lambda: topple.order(trimesh.Scene(MESH)),
        "scene is of <class 'trimesh.*expected Scene",
    ),
    "a mesh to plan on": (lambda: topple.plan(MESH, "box", "panda"), "scene is of .*expected Scene"),
    "clouds to relate": (lambda: topple.relate(CLOUDS), "scene is of <class 'dict'>"),
    "nothing": (lambda: topple.relate(None), "scene is None"),
    "a number to load": (lambda: topple.load_scene(3), "path is 3: expected str"),
    "bytes to load": (lambda: topple.load_scene(b"a"), "path is of <class 'bytes'>"),
    "a set of names": (
        lambda: scene_from_rgbd(ONES, K, ONES[None], {"a"}),
        "names is a set, which has no order",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_no_scene_is_refused_in_a_line(name):
    make, words = REFUSED[name]
    with pytest.raises(topple.InvalidInput, match=words):
        make()
