import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from topple.topology.geometry.hull import Hull
from topple.topology.sixim.matrix import Regions, intersection_matrix
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


@given(st.integers(0, 10**6), st.sampled_from([1, 5, 300, 20000]))
@settings(max_examples=30, deadline=None)
def test_prepared_regions_count_like_the_plain_way(seed, count):
    rng = np.random.default_rng(seed)
    a, b = surface(rng), surface(rng, count)
    expected = matrix_of(a, b)
    np.testing.assert_array_equal(Regions(Hull.of(b), DEVIATION).counts(a), expected[0])
    np.testing.assert_array_equal(Regions(Hull.of(a), DEVIATION).counts(b), expected[1])


@given(st.integers(0, 10**6))
def test_rows_add_up_to_the_sizes_of_the_clouds(seed):
    rng = np.random.default_rng(seed)
    a, b = surface(rng, 200), surface(rng, 300)
    assert matrix_of(a, b).sum(axis=1).tolist() == [200, 300]


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
