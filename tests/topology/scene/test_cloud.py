import numpy as np
import pytest

from topple.topology.geometry.thin import thinned
from topple.topology.scene.cloud import clean, estimate_deviation, noise_and_spacing


def plate(rng, noise, count=3000):
    return np.c_[rng.uniform(-0.1, 0.1, (count, 2)), rng.normal(0, noise, count)]


def test_thinning_leaves_a_point_near_every_dropped_one():
    points = plate(np.random.default_rng(0), 1e-3)
    kept = thinned(points, 0.01)
    assert len(kept) < len(points) / 3
    nearest = np.linalg.norm(points[:, None] - kept[None], axis=2).min(axis=1)
    assert nearest.max() <= 0.01 * np.sqrt(3)


@pytest.mark.parametrize("noise", [2e-4, 1e-3])
def test_noise_of_a_plane_is_measured(noise):
    assert noise_and_spacing(plate(np.random.default_rng(1), noise))[0] == pytest.approx(noise, rel=0.25)


def test_a_noisier_scene_has_a_larger_deviation():
    rng = np.random.default_rng(2)
    estimates = [estimate_deviation({"plate": plate(rng, noise, 50000)}) for noise in (0.0, 5e-4, 1e-3, 1e-2)]
    assert estimates == sorted(estimates)
    assert 0.0004 <= estimates[0] < estimates[-1] <= 0.01


def test_stray_points_are_dropped_and_the_surface_stays():
    rng = np.random.default_rng(3)
    surface = plate(rng, 2e-4)
    strays = rng.uniform(0.3, 1.0, (20, 3))
    kept = clean(np.concatenate([surface, strays]))
    assert kept[:, 2].max() < 0.1
    assert len(kept) > 0.99 * len(surface)


def test_a_board_with_dense_sides_keeps_its_faces():
    rng = np.random.default_rng(4)
    board = rng.uniform(-0.5, 0.5, (9000, 3))
    face = np.repeat(np.arange(3), 3000)  # as many points on the narrow sides as on the faces
    board[np.arange(9000), face] = rng.choice([-0.5, 0.5], 9000)
    assert len(clean(board * [1.2, 1.2, 0.04])) == 9000


@pytest.mark.parametrize("count", [1, 2, 5])
def test_tiny_clouds_come_back_whole(count):
    points = np.zeros((count, 3))
    assert len(clean(points)) == count
    assert noise_and_spacing(points) == (0.0, 0.0)
