import fcl
import numpy as np
import pytest

from topple.robots.collision.convex import bounding_sphere, hull_of, reduce_hull
from topple.robots.collision.separation import Candidates, ConvexSets, Frames, gaps


def solid(vertices: np.ndarray) -> fcl.CollisionObject:
    corners, triangles = hull_of(vertices)
    faces = np.concatenate([np.full((len(triangles), 1), 3), triangles], axis=1).ravel()
    return fcl.CollisionObject(fcl.Convex(corners, len(triangles), faces))


@pytest.mark.parametrize("seed", range(5))
def test_a_gap_never_exceeds_the_distance(seed):
    rng = np.random.default_rng(seed)
    many = [
        rng.normal(size=(80, 3)) * rng.uniform(0.02, 0.2, 3) + rng.uniform(-0.3, 0.3, 3) for _ in range(12)
    ]
    many = [hull_of(points)[0] for points in many]
    sets = ConvexSets.of(many, [0] * 12)
    a, b = np.triu_indices(12, k=1)
    frames = Frames(np.eye(3, 4, dtype=np.float32)[None, :, :, None])
    direction = rng.normal(size=(len(a), 3)).astype(np.float32)
    candidates = Candidates(np.zeros_like(a), a, b, direction, np.full(len(a), np.inf, dtype=np.float32))
    found = gaps(sets, frames, candidates, iterations=40)
    distances = np.array(
        [
            fcl.distance(solid(many[i]), solid(many[j]), fcl.DistanceRequest(), fcl.DistanceResult())
            for i, j in zip(a, b, strict=True)
        ]
    )
    apart = distances > 0
    assert apart.any()
    assert not apart.all()
    assert (found <= np.maximum(distances, 0) + 1e-5).all()
    assert (found[~apart] <= 0).all()
    assert np.median(distances[apart] - found[apart]) < 0.006


@pytest.mark.parametrize("seed", range(3))
def test_a_reduced_hull_stays_within_its_error(seed):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(400, 3))
    whole = hull_of(points / np.linalg.norm(points, axis=1, keepdims=True) * 0.1)[0]
    kept, error = reduce_hull(whole, 0.004)
    assert len(kept) < len(whole)
    assert 0 < error < 0.008
    for direction in rng.normal(size=(200, 3)):
        direction /= np.linalg.norm(direction)
        assert (whole @ direction).max() <= (kept @ direction).max() + error + 1e-9


def test_hulls_of_flat_thin_and_single_points_have_a_volume():
    square = np.array([[x, y, 0.0] for x in (0, 1) for y in (0, 1)])
    for points in (square, square[:2], square[:1], np.repeat(square[:1], 5, axis=0)):
        vertices, triangles = hull_of(points)
        assert len(triangles) >= 4
        assert np.ptp(vertices, axis=0).min() > 1e-5


def test_triangles_of_a_hull_look_outward():
    vertices, triangles = hull_of(np.random.default_rng(0).normal(size=(50, 3)))
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    outward = np.einsum("ij,ij->i", np.cross(b - a, c - a), a - vertices.mean(axis=0))
    assert len(outward) == 2 * len(vertices) - 4, "as Euler counts the faces of a closed hull of triangles"
    assert (outward > 0).all()


def test_a_bounding_sphere_holds_all_points():
    points = np.random.default_rng(1).normal(size=(100, 3))
    centre, radius = bounding_sphere(points)
    assert np.linalg.norm(points - centre, axis=1).max() <= radius + 1e-12
