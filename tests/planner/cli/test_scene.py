"""`topple scene`: from files of views to a scene file that the other commands take."""

from pathlib import Path

import numpy as np
import pytest

from topple.robots import scenario
from topple.topology.io import load_scene

pytest.importorskip("small_gicp", reason="small_gicp is not installed: pip install '.[views]'")


@pytest.fixture(scope="module")
def views(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Three views of a pile; the second one's pose is off by 4 cm."""
    folder, rng = tmp_path_factory.mktemp("views"), np.random.default_rng(1)
    paths: list[Path] = []
    with scenario("pile", 1) as stage:
        for number, camera in enumerate(stage.cameras):
            image = camera.look(stage.world, rng)
            pose = image.pose_camera_to_world.copy()
            pose[:3, 3] += [0.03, -0.025, 0.01] if number == 1 else 0.0
            names = [image.name_of(k) if k else "" for k in range(int(image.label.max()) + 1)]
            arrays = {"depth": image.depth, "K": image.K, "label": image.label, "names": np.array(names)}
            paths.append(folder / f"view_{number}.npz")
            np.savez_compressed(paths[-1], pose_camera_to_world=pose, **arrays)
    return paths


def test_views_become_a_scene_that_is_ordered(views, tmp_path, typed):
    place = tmp_path / "scene.npz"
    document = typed("scene", *views, "-o", place, "--json").document
    assert (document["format"], document["masked"], document["fixed"]) == ("topple.scene", True, ["table"])
    first, second, third = document["views"]
    assert first["registration"] is None and first["ground"]["residual"] < 0.005
    assert second["registration"]["shift"] == pytest.approx(0.04, abs=0.008)
    assert third["registration"]["shift"] < 0.008
    assert all(view["registration"]["residual"] < 0.003 for view in (second, third))
    scene = load_scene(place)
    assert set(scene.movable) == {"bowl_0", "box_1", "box_2", "can_3", "box_4", "spoon_5", "spoon_6"}
    assert len(scene.viewpoints) == 3 and sum(map(len, scene.clouds.values())) < 70_000
    assert "bowl_0" in typed("order", place, "--target", "bowl_0").out


def test_the_table_says_how_far_each_step_can_be_trusted(views, tmp_path, typed):
    bare = []
    for path in views[:2]:
        with np.load(path) as view:
            bare.append(tmp_path / path.name)
            np.savez(bare[-1], **{key: view[key] for key in ("depth", "K", "pose_camera_to_world")})
    printed = typed("scene", *bare, "-o", tmp_path / "s.npz").out
    for word in ("residual", "looked through", "by their shape", "dropped as outliers", "no masks"):
        assert word in printed


def test_what_is_no_view_is_one_line(views, tmp_path, typed):
    np.savez(tmp_path / "clouds.npz", cup=np.random.default_rng(0).random((50, 3)))
    for argv, words in (
        ((views[0],), "expected two views or more"),
        ((views[0], tmp_path / "clouds.npz"), "clouds.npz: the RGB-D frame has no depth"),
        ((views[0], tmp_path / "gone.npz"), "gone.npz: cannot be read"),
        ((views[0], views[1], "-o", tmp_path / "no" / "scene.npz"), "does not exist"),
    ):
        printed = typed("scene", *argv, code=2)
        assert words in printed.err and printed.err.count("\n") == 1 and printed.out == ""
