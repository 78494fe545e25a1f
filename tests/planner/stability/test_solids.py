"""Bodies of noisy clouds: convex ones to about their noise, and no others."""

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from topple.planner.stability.check import check
from topple.planner.stability.solids import solid_of
from topple.robots import shapes
from topple.topology import Scene
from topple.topology.scene.cloud import noise_and_spacing

NOISE = 0.0005


def cloud(mesh: trimesh.Trimesh, seed: int = 0) -> np.ndarray:
    points = trimesh.sample.sample_surface(mesh, 5000, seed=seed)[0]
    return points + np.random.default_rng(seed).normal(0, NOISE, points.shape)


@pytest.mark.parametrize("size", [(0.1, 0.08, 0.05), (0.25, 0.06, 0.01)])
def test_the_faces_of_a_box_are_where_all_their_points_say(size):
    turn = Rotation.from_euler("xyz", [0.4, -0.7, 1.1])
    points = turn.apply(cloud(trimesh.creation.box(size)))
    solid = solid_of(points, *noise_and_spacing(points))
    assert solid is not None
    extent = np.ptp(solid.vertices @ turn.as_matrix(), axis=0)
    assert np.abs(extent - size).max() < 1.2 * NOISE
    assert trimesh.Trimesh(solid.vertices, solid.faces).volume == pytest.approx(np.prod(size), rel=0.03)


def test_a_ball_is_as_large_as_it_is_within_its_noise_and_hollow_things_are_no_solids():
    ball = cloud(trimesh.creation.icosphere(subdivisions=4, radius=0.03))
    solid = solid_of(ball, *noise_and_spacing(ball))
    assert solid is not None
    assert np.abs(np.ptp(solid.vertices, axis=0) - 0.06).max() < 3 * NOISE
    for body in (shapes.bowl("bowl"), shapes.cup("cup")):
        parts = [trimesh.convex.convex_hull(part) for part in body.parts]
        hollow = cloud(trimesh.util.concatenate(parts))
        assert solid_of(hollow, NOISE, noise_and_spacing(hollow)[1]) is None


@pytest.mark.parametrize(("beyond", "verdict"), [(-0.003, "stands"), (0.004, "tips")])
def test_the_edge_of_a_cloud_is_told_to_millimetres(beyond, verdict):
    boxes = {
        "table": ((0.6, 0.6, 0.04), (0, 0, -0.02)),
        "base": ((0.08, 0.1, 0.06), (0, 0, 0.03)),
        "odd": ((0.06, 0.07, 0.05), (0.04 + beyond, 0, 0.085)),
    }
    clouds = {
        name: cloud(trimesh.creation.box(size), k) + np.array(at)
        for k, (name, (size, at)) in enumerate(boxes.items())
    }
    found = check(Scene(clouds, ["table"], (0, 0, 1)), margins=False)
    assert str(found.objects["odd"].verdict) == verdict
    assert found.objects["base"].stands
