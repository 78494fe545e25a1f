import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from topple.topology.geometry.hull import Hull
from topple.topology.sixim.plain import directed_distances, intersection_matrix, plain_relations
from topple.topology.sixim.table import Relation, classify

DEVIATION = 0.002


def surface(rng, count=400):
    """Points on a box or a ball somewhere near the origin, some of them flat, collinear or single."""
    direction = rng.normal(size=(count, 3))
    norm = np.linalg.norm(direction, axis=1) if rng.random() < 0.5 else np.abs(direction).max(axis=1)
    size = rng.uniform(0.01, 0.1, 3) * rng.choice([0.0, 1.0], 3, p=[0.1, 0.9])
    return direction / norm[:, None] * size + rng.uniform(-0.08, 0.08, 3)


def matrix_of(a, b, deviation=DEVIATION):
    return intersection_matrix(a, Hull.of(a), b, Hull.of(b), deviation)


def relation_of(a, b):
    return classify(matrix_of(a, b))


@given(st.integers(0, 10**6))
def test_rows_add_up_to_the_sizes_of_the_clouds(seed):
    rng = np.random.default_rng(seed)
    a, b = surface(rng, 200), surface(rng, 300)
    assert matrix_of(a, b).sum(axis=1).tolist() == [200, 300]


def test_directed_distances_are_those_of_equation_2():
    """n.(a - b1) / |n| for the outward normal n of the facet through b1, b2, b3."""
    rng = np.random.default_rng(0)
    hull, points = Hull.of(rng.normal(size=(30, 3))), rng.normal(size=(20, 3))
    first, second, third = (hull.vertices[hull.faces[:, k]] for k in range(3))
    normal = np.cross(second - first, third - first)
    expected = ((points[:, None] - first) * normal).sum(axis=2) / np.linalg.norm(normal, axis=1)
    found = directed_distances(points, hull)
    np.testing.assert_allclose(np.sort(found, axis=1), np.sort(expected, axis=1), atol=1e-9)


def test_every_pair_is_told_once_with_the_matrix_it_follows_from():
    rng = np.random.default_rng(1)
    clouds = {name: surface(rng) for name in "abcd"}
    found = plain_relations(clouds, DEVIATION)
    assert list(found) == [("a", "b"), ("a", "c"), ("a", "d"), ("b", "c"), ("b", "d"), ("c", "d")]
    for (a, b), (relation, matrix) in found.items():
        assert relation is classify(matrix)
        np.testing.assert_array_equal(matrix, matrix_of(clouds[a], clouds[b]))


UP = np.array([0.0, 0, 1])
CUBE = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * 0.05
SLAB = np.array([[x, y, z] for x in np.linspace(-1, 1, 9) for y in np.linspace(-1, 1, 9) for z in (0,)]) * 0.2


def test_a_cube_on_a_flat_noiseless_table_touches_it():
    assert relation_of(CUBE + 0.05 * UP, SLAB) is Relation.TOUCH


def test_a_gap_below_the_deviation_still_touches():
    assert relation_of(CUBE + 0.0505 * UP, SLAB) is Relation.TOUCH


def test_a_gap_above_the_deviation_is_disjoint():
    assert relation_of(CUBE + 0.0525 * UP, SLAB) is Relation.DISJOINT


def test_a_small_cube_inside_is_within():
    assert relation_of(CUBE * 0.3, CUBE) is Relation.WITHIN
    assert relation_of(CUBE, CUBE * 0.3) is Relation.CONTAIN


def test_a_rod_that_sticks_out_is_partial_within():
    rod = np.linspace([0, 0, 0], [0, 0, 0.2], 50)
    assert relation_of(rod, CUBE) is Relation.PARTIAL_WITHIN
    assert relation_of(CUBE, rod) is Relation.PARTIAL_CONTAIN


def test_corners_in_each_other_cross():
    dense = CUBE[:, None] * np.linspace(0.2, 1, 5)[:, None]
    assert relation_of(dense.reshape(-1, 3), dense.reshape(-1, 3) + 0.03) is Relation.CROSS


def test_the_same_cloud_twice_touches_itself():
    assert relation_of(CUBE, CUBE) is Relation.TOUCH


@pytest.mark.parametrize("cloud", [np.zeros((1, 3)), np.linspace([0, 0, 0], [0.1, 0, 0], 5), SLAB])
def test_clouds_without_volume_have_no_interior(cloud):
    assert matrix_of(CUBE, cloud)[0, 0] == 0
