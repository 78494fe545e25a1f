import numpy as np
import pytest
from scipy.interpolate import LinearNDInterpolator

from topple.topology.bodies.complete import _interpolated, complete_body
from topple.topology.views.free_space import FreeSpace


@pytest.mark.parametrize("count", [3, 30, 500])
def test_heights_between_points_are_those_of_scipy(count):
    rng = np.random.default_rng(count)
    tops, cells = rng.uniform(0, 0.2, (count, 3)), rng.uniform(-0.02, 0.22, (3000, 2))
    expected = LinearNDInterpolator(tops[:, :2], tops[:, 2])(cells)
    np.testing.assert_allclose(_interpolated(tops, cells), expected, rtol=0, atol=1e-12)


def test_points_in_a_row_span_no_heights():
    tops = np.c_[np.linspace(0, 0.1, 20), np.zeros(20), np.ones(20)]
    assert np.isnan(_interpolated(tops, np.array([[0.05, 0.0], [0.05, 0.01]]))).all()


def test_a_bowl_seen_from_one_side_gets_its_far_wall_and_its_foot():
    rng = np.random.default_rng(0)
    angle, share = rng.uniform(-np.pi, 0, 3000), rng.uniform(0.35, 1, 3000)
    near = np.c_[0.08 * share * np.cos(angle), 0.08 * share * np.sin(angle), 0.05 * share**2]
    rim = rng.uniform(-np.pi, np.pi, 600)
    seen = np.concatenate([near, np.c_[0.08 * np.cos(rim), 0.08 * np.sin(rim), np.full(600, 0.05)]])
    whole = complete_body(seen, FreeSpace({"seen": seen}, np.array([[0.0, -0.5, 0.5]])))
    added = whole[len(seen) :]
    assert (whole[: len(seen)] == seen).all()
    assert (added[:, 1] > 0.02).any()
    assert added[:, 2].min() < 0.02
    assert np.linalg.norm(added[:, :2], axis=1).max() < 0.09
