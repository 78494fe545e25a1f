import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import ConvexHull, QhullError
from scipy.spatial.transform import Rotation

from topple.topology.base.errors import InvalidInput
from topple.topology.geometry.hull import Hull

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.3, 0.4, 0]], float)
ZOO = {
    "point": np.array([[1.0, 2, 3]]),
    "one point many times": np.tile([[1.0, 2, 3]], (50, 1)),
    "segment": np.array([[0.0, 0, 0], [1, 1, 1]]),
    "collinear": np.linspace([0.0, 0, 0], [1, 2, 3], 40),
    "triangle": np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]),
    "flat": SQUARE,
    "flat with duplicates": np.concatenate([SQUARE, SQUARE]),
    "nearly flat": SQUARE + np.outer([1e-9, 0, 0, 0, 0], [0, 0, 1]),
    "tetrahedron": np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]),
    "far away": SQUARE + 1000,
    "cube": np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float),
}
DIMENSION = dict(zip(ZOO, (0, 0, 1, 1, 2, 2, 2, 2, 3, 2, 3), strict=True))


@pytest.mark.parametrize("name", ZOO)
def test_every_cloud_has_a_hull_of_its_dimension(name):
    assert Hull.of(ZOO[name]).dimension == DIMENSION[name]


@pytest.mark.parametrize("name", ZOO)
def test_a_cloud_lies_in_its_own_hull(name):
    hull = Hull.of(ZOO[name])
    assert hull.facet_distance(ZOO[name]).max() <= 1e-9
    assert hull.signed_distance(ZOO[name]).max() <= 2e-9


@pytest.mark.parametrize("name", ZOO)
def test_normals_have_unit_length_and_the_box_is_the_clouds(name):
    hull = Hull.of(ZOO[name])
    np.testing.assert_allclose(np.linalg.norm(hull.normals, axis=1), 1, atol=1e-12)
    np.testing.assert_array_equal(hull.lower, ZOO[name].min(axis=0))
    np.testing.assert_array_equal(hull.upper, ZOO[name].max(axis=0))


@pytest.mark.parametrize("name", ZOO)
def test_a_hull_is_unchanged_by_a_turn_of_the_world(name):
    turn = Rotation.from_rotvec([0.3, -1.1, 0.7]).as_matrix()
    probes = np.random.default_rng(0).uniform(-2, 4, (200, 3))
    before = Hull.of(ZOO[name])
    after = Hull.of(ZOO[name] @ turn.T)
    assert after.dimension == before.dimension
    np.testing.assert_allclose(
        after.signed_distance(probes @ turn.T), before.signed_distance(probes), atol=1e-8
    )


def test_faces_look_outward():
    hull = Hull.of(np.random.default_rng(1).normal(size=(100, 3)))
    corners = hull.vertices[hull.faces]
    assert len(corners) == 2 * len(hull.vertices) - 4, (
        "as Euler counts the faces of a closed hull of triangles"
    )
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (np.einsum("ij,ij->i", normal, corners[:, 0] - hull.vertices.mean(axis=0)) > 0).all()


def test_distance_outside_an_edge_is_euclidean_and_not_the_facets():
    wedge = Hull.of(ZOO["cube"])
    corner = np.array([[1.3, 1.4, 0.5]])
    assert wedge.signed_distance(corner)[0] == pytest.approx(0.5)
    assert wedge.facet_distance(corner)[0] == pytest.approx(0.4)


def test_depth_inside_is_that_below_the_nearest_facet():
    assert Hull.of(ZOO["cube"]).signed_distance(np.array([[0.5, 0.5, 0.9]]))[0] == pytest.approx(-0.1)


@pytest.mark.parametrize("shape", ["ball", "box", "thin"])
@pytest.mark.parametrize("noise", [0.0, 5e-4])
def test_dropping_inner_points_keeps_the_hull(shape, noise):
    rng = np.random.default_rng(2)
    points = rng.normal(size=(12000, 3))
    if shape == "ball":
        points /= np.linalg.norm(points, axis=1, keepdims=True)
    else:
        points /= np.abs(points).max(axis=1, keepdims=True)
    points = points * [0.1, 0.2, 0.002 if shape == "thin" else 0.1] + rng.normal(0, noise, points.shape)
    reference = ConvexHull(points)
    hull = Hull.of(points)
    assert hull.volume == pytest.approx(reference.volume, rel=1e-9)
    probes = rng.uniform(-0.2, 0.2, (50, 3))
    expected = (probes @ reference.equations[:, :3].T + reference.equations[:, 3]).max(axis=1)
    np.testing.assert_allclose(hull.facet_distance(probes), expected, atol=1e-9)


@given(st.integers(0, 10**6), st.integers(1, 30))
def test_any_small_cloud_has_a_hull_that_holds_it(seed, count):
    rng = np.random.default_rng(seed)
    points = rng.integers(0, 3, (count, 3)) * 0.1  # lattice clouds: flat, collinear and doubled ones abound
    hull = Hull.of(points)
    assert hull.facet_distance(points).max() <= 1e-12
    try:
        assert hull.volume == pytest.approx(ConvexHull(points).volume)
    except QhullError:
        assert hull.dimension < 3


@pytest.mark.parametrize("bad", [np.zeros((0, 3)), np.zeros((3, 2)), np.full((4, 3), np.nan)])
def test_what_is_no_cloud_is_refused(bad):
    with pytest.raises(InvalidInput, match="finite points"):
        Hull.of(bad)


def test_places_lie_on_the_hull_and_all_over_it():
    hull = Hull.of(np.random.default_rng(0).normal(size=(200, 3)))
    places = hull.spread(256)
    np.testing.assert_allclose(hull.facet_distance(places), 0, atol=1e-9)
    assert np.ptp(places, axis=0).min() > 0.7 * np.ptp(hull.vertices, axis=0).min()
    assert len(Hull.of(np.zeros((1, 3))).spread(256)) == 1


def test_places_turn_with_the_hull():
    rng = np.random.default_rng(3)
    points, turn = rng.normal(size=(300, 3)) * [0.05, 0.04, 0.02], np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    np.testing.assert_allclose(
        Hull.of(points @ turn.T).spread(64), Hull.of(points).spread(64) @ turn.T, atol=1e-9
    )
