"""Round bodies from the side of them that was seen."""

import numpy as np
import pytest

from topple.topology.base.arrays import FloatArray
from topple.topology.bodies.complete import complete_body
from topple.topology.geometry.round import Cylinder, Spheroid, fits_of, round_body
from topple.topology.views.free_space import FreeSpace

EYE = np.array([0.6, 0.0, 0.6])


def _seen(surface: FloatArray, outward: FloatArray, seed: int = 0) -> tuple[FloatArray, FloatArray]:
    """What one camera sees of a convex surface, with a millimetre of noise, and the normals there."""
    rays = EYE - surface
    rays /= np.linalg.norm(rays, axis=1)[:, None]
    front = (rays * outward).sum(axis=1) > 0.1
    noise = np.random.default_rng(seed).normal(0.0, 0.001, (int(front.sum()), 1))
    return surface[front] + noise * rays[front], outward[front]


def _ball(radius: float = 0.035, stretch: float = 1.0) -> tuple[FloatArray, FloatArray]:
    """A ball on the ground, or one that is longer along y."""
    shape = np.array([1.0, stretch, 1.0])
    rays = np.random.default_rng(1).normal(size=(2000, 3))
    rays /= np.linalg.norm(rays, axis=1)[:, None]
    outward = rays / shape
    return (radius * rays * shape + [0.0, 0.0, radius], outward / np.linalg.norm(outward, axis=1)[:, None])


def _lying_can(radius: float = 0.033, length: float = 0.1) -> tuple[FloatArray, FloatArray]:
    """A can that lies along y."""
    rng = np.random.default_rng(2)
    angle, along = rng.uniform(0, 2 * np.pi, 2000), rng.uniform(-length / 2, length / 2, 2000)
    outward = np.column_stack([np.cos(angle), np.zeros(2000), np.sin(angle)])
    return radius * outward + np.column_stack([np.zeros(2000), along, np.full(2000, radius)]), outward


def _box(size: tuple[float, float, float] = (0.06, 0.04, 0.08)) -> tuple[FloatArray, FloatArray]:
    rng = np.random.default_rng(3)
    points, outward = rng.uniform(-0.5, 0.5, (3000, 3)), np.zeros((3000, 3))
    axis, side = rng.integers(0, 3, 3000), rng.choice([-0.5, 0.5], 3000)
    row = np.arange(3000)
    points[row, axis], outward[row, axis] = side, 2 * side
    return points * size + [0.0, 0.0, size[2] / 2], outward


def test_half_a_ball_tells_the_whole():
    found = round_body(fits_of(*_seen(*_ball(0.035))), box_residual=0.01, floor=0.0)
    assert isinstance(found, Spheroid)
    assert found.radius == pytest.approx(0.035, abs=0.002)
    assert found.centre == pytest.approx([0.0, 0.0, 0.035], abs=0.002)


def test_a_lemon_is_longer_than_thick():
    found = round_body(fits_of(*_seen(*_ball(0.03, stretch=1.45))), box_residual=0.01, floor=0.0)
    assert isinstance(found, Spheroid)
    assert found.stretch > 1.0
    assert abs(found.axis[1]) > 0.95
    assert np.ptp(found.surface(0.004)[:, 1]) == pytest.approx(0.087, abs=0.012)


def test_a_can_that_lies_is_as_thick_as_wide():
    found = round_body(fits_of(*_seen(*_lying_can())), box_residual=0.01, floor=0.0)
    assert isinstance(found, Cylinder)
    assert abs(found.axis[1]) > 0.98
    assert found.radius == pytest.approx(0.033, abs=0.003)
    assert found.half == pytest.approx(0.05, abs=0.004)


def test_a_box_stays_a_box():
    assert round_body(fits_of(*_seen(*_box())), box_residual=0.001, floor=0.0) is None


def test_a_dome_is_no_ball():
    points, outward = _seen(*_ball(0.07))
    above = points[:, 2] > 0.07  # a bowl upside down: the upper half of a ball, on the ground
    assert np.count_nonzero(above) > 200
    assert isinstance(round_body(fits_of(points, outward), box_residual=0.02, floor=0.0), Spheroid), (
        "the whole is one"
    )
    found = round_body(fits_of(points[above], outward[above]), box_residual=0.02, floor=0.07)
    assert not isinstance(found, Spheroid)


def test_a_ball_is_completed_to_its_far_side():
    points, _ = _seen(*_ball(0.035))
    x, y = np.meshgrid(np.arange(-0.4, 0.4, 0.01), np.arange(-0.4, 0.4, 0.01))
    table = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    shadow = np.linalg.norm(table - [-0.03, 0.0, 0.0], axis=1) < 0.08
    sight = FreeSpace({"seen": np.concatenate([points, table[~shadow]])}, EYE[None])
    whole = complete_body(points, sight, floor=0.0)
    assert np.ptp(points[:, 0]) < 0.066
    assert np.ptp(whole, axis=0) == pytest.approx([0.07, 0.07, 0.07], abs=0.005)
    assert whole[:, 2].min() >= min(0.0, points[:, 2].min())
