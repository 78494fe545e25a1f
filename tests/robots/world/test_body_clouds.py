"""Pieces of bodies from points of their surfaces."""

import numpy as np
from scipy.spatial import ConvexHull

from topple.robots import shapes
from topple.robots.world.body_clouds import Piece, shell, smooth, solid
from topple.topology.base.arrays import FloatArray
from topple.topology.base.tolerances import VOXEL
from topple.topology.geometry.thin import voxel_means


def _holds(pieces: list[Piece], point: list[float]) -> bool:
    planes = [ConvexHull(piece.corners).equations for piece in pieces]
    return any(bool((each[:, :3] @ point + each[:, 3] <= 0).all()) for each in planes)


def _cloud(name: str, noise: float = 0.0) -> FloatArray:
    rng = np.random.default_rng(0)
    cloud = getattr(shapes, name)().surface(6000, rng) + rng.normal(0.0, noise, (6000, 3))
    return voxel_means(cloud, VOXEL)


def test_a_shell_leaves_its_hollow_free_and_has_a_floor():
    for name in ("bowl", "mug", "cup"):
        cloud = _cloud(name)
        pieces = shell(cloud, cloud, None)
        assert 8 < len(pieces) < 70
        assert not _holds(pieces, [0.0, 0.0, 0.03])
        base = [[r * np.cos(a), r * np.sin(a), 0.002] for r in (0.008, 0.02) for a in np.arange(8) * 0.785]
        assert np.mean([_holds(pieces, point) for point in base]) > 0.85


def test_noise_does_not_make_a_solid_larger_than_some_noise():
    cloud = _cloud("box", noise=0.001)
    true = shapes.box()
    corners = solid(cloud, cloud)[0].corners
    assert np.abs(corners.max(axis=0) - true.upper).max() < 0.004
    assert np.abs(corners.min(axis=0) - true.lower).max() < 0.004


def test_a_wall_seen_from_one_side_grows_away_from_the_camera():
    x, y = np.meshgrid(np.linspace(-0.05, 0.05, 26), np.linspace(-0.05, 0.05, 26))
    sheet = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    pieces = shell(sheet, sheet, np.array([[0.0, 0.0, 0.5]]))
    corners = np.concatenate([piece.corners for piece in pieces])
    assert corners[:, 2].max() < 1e-6
    assert corners[:, 2].min() < -0.003


def _top(pieces: list[Piece], x: float, y: float) -> float:
    """Height of the highest piece over a place [m], -inf where there is none."""
    found = [-np.inf]
    for piece in pieces:
        slope, up = piece.planes[:, :2] @ [x, y] + piece.planes[:, 3], piece.planes[:, 2]
        high, low = (-slope[up > 0] / up[up > 0]).min(), (-slope[up < 0] / up[up < 0]).max()
        found += [high] if high >= low and (slope[up == 0] <= 0).all() else []
    return max(found)


def test_a_plate_seen_from_above_is_rebuilt_even_and_hollow_with_noise_and_flying_pixels():
    rng = np.random.default_rng(0)
    grid = np.arange(-0.12, 0.12, 0.003)
    x, y = (axis.ravel() for axis in np.meshgrid(grid, grid))
    away = np.hypot(x, y)
    flange = 0.01 * np.clip((away - 0.08) / 0.03, 0.0, 1.0)  # 1 cm high, 3 cm wide, round a flat
    cloud = np.column_stack([x, y, flange + rng.normal(0.0, 0.0014, len(x))])[away < 0.115]
    cloud[rng.random(len(cloud)) < 0.01, 2] += 0.008
    pieces = shell(cloud, cloud, np.array([[0.5, 0.0, 0.6], [-0.3, 0.4, 0.6], [-0.3, -0.4, 0.6]]))
    places = [(r * np.cos(a), r * np.sin(a)) for r in (0.0, 0.02, 0.04, 0.06) for a in np.arange(8) * 0.785]
    heights = np.array([_top(pieces, *place) for place in places])
    assert np.abs(heights).max() < 0.002  # what a lip bridges
    assert len(pieces) < 60


def test_smoothing_keeps_a_face_where_it_is():
    rng = np.random.default_rng(1)
    face = np.column_stack([rng.uniform(-0.05, 0.05, (2000, 2)), rng.normal(0.0, 0.001, 2000)])
    after = smooth(voxel_means(face, VOXEL))
    assert after[:, 2].std() < 0.0007
    assert abs(after[:, 2].mean()) < 3e-4


def test_a_single_point_is_a_grain():
    pieces = solid(np.array([[0.1, 0.2, 0.3]]), np.array([[0.1, 0.2, 0.3]]))
    np.testing.assert_allclose(pieces[0].corners.mean(axis=0), [0.1, 0.2, 0.3])
    assert np.ptp(pieces[0].corners) < 0.5
