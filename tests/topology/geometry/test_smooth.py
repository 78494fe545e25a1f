import numpy as np
from scipy.spatial import ConvexHull

from topple.topology.geometry.smooth import smoothed

NOISE = 0.0015


def box(size: tuple[float, float, float], seed: int) -> np.ndarray:
    """Points 3 mm apart on a box, in no order."""
    rng = np.random.default_rng(seed)
    areas = np.array([size[1] * size[2], size[0] * size[2], size[0] * size[1]])
    points = rng.uniform(-0.5, 0.5, (int(2 * areas.sum() / 0.003**2), 3))
    axis = rng.choice(3, len(points), p=areas / areas.sum())
    points[np.arange(len(points)), axis] = rng.choice([-0.5, 0.5], len(points))
    return points * size


def noisy(points: np.ndarray, seed: int) -> np.ndarray:
    return points + np.random.default_rng(seed).normal(0.0, NOISE, points.shape)


def test_the_hull_of_a_noisy_box_has_its_volume_again() -> None:
    size, grown = (0.05, 0.06, 0.08), []
    for seed in range(5):
        points = noisy(box(size, seed), seed)
        grown.append([ConvexHull(cloud).volume / np.prod(size) for cloud in (points, smoothed(points))])
    assert np.min(grown, axis=0)[0] > 1.2
    assert np.abs(np.array(grown)[:, 1] - 1.0).max() < 0.12


def test_a_ball_is_not_cut_off() -> None:
    rng = np.random.default_rng(0)
    directions = rng.normal(size=(1400, 3))
    ball = 0.03 * directions / np.linalg.norm(directions, axis=1)[:, None]
    radii = np.linalg.norm(smoothed(noisy(ball, 1)), axis=1)
    assert abs(radii.mean() - 0.03) < 0.0005
    assert radii.std() < NOISE / 2


def test_a_flying_pixel_is_left_out_and_too_few_points_are_as_they_were() -> None:
    points = noisy(box((0.05, 0.06, 0.08), 0), 0)
    assert smoothed(np.vstack([points, [[0.0, 0.0, 0.15]]]))[:, 2].max() < 0.06
    assert smoothed(points[:5]) is not None and (smoothed(points[:5]) == points[:5]).all()


def test_where_nothing_is_noisy_nothing_moves() -> None:
    grid = np.stack(np.meshgrid(np.arange(0, 0.06, 0.003), np.arange(0, 0.06, 0.003)), -1).reshape(-1, 2)
    sheet = np.column_stack([grid, 0.3 * grid[:, 0]])
    drawn = smoothed(sheet)
    assert np.abs(drawn[:, 2] - 0.3 * drawn[:, 0]).max() < 1e-5
