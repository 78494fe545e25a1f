import numpy as np
import pytest

from topple.topology.bodies.parts import convex_parts
from topple.topology.geometry.hull import Hull
from topple.topology.relations.cavity import is_surrounded

UP = np.array([0.0, 0, 1])
LINE = np.linspace([0, 0, 0], [0.1, 0, 0], 30)
COMPLETE = np.zeros((0, 3))


def bowl(count=2500, radius=0.08, depth=0.05, thickness=0.003, seed=0):
    """Both sides of a paraboloid shell standing on z = 0."""
    rng = np.random.default_rng(seed)
    reach, turn = radius * np.sqrt(rng.random(count)), rng.uniform(0, 2 * np.pi, count)
    height = depth * (reach / radius) ** 2 + thickness * rng.integers(0, 2, count)
    return np.c_[reach * np.cos(turn), reach * np.sin(turn), height]


def box(count=2500, size=(0.06, 0.1, 0.2), seed=0):
    rng = np.random.default_rng(seed)
    points = rng.uniform(-1, 1, (count, 3))
    axis = rng.integers(0, 3, count)
    points[np.arange(count), axis] = np.sign(points[np.arange(count), axis])
    return points * np.asarray(size) / 2


def arc(count=2500, radius=0.08, thickness=0.018, seed=0):
    """A banana: a third of a ring lying flat on z = 0."""
    rng = np.random.default_rng(seed)
    along, around = rng.uniform(np.pi / 6, np.pi * 5 / 6, count), rng.uniform(0, 2 * np.pi, count)
    reach = radius + thickness * np.cos(around)
    return np.c_[reach * np.cos(along), reach * np.sin(along), thickness * (1 + np.sin(around))]


def volume(parts):
    return sum(Hull.of(part).volume for part in parts)


@pytest.mark.parametrize("viewpoints", [None, COMPLETE])
def test_a_convex_cloud_is_one_part(viewpoints):
    assert len(convex_parts(box(), viewpoints=viewpoints)) == 1


@pytest.mark.parametrize(("shape", "share"), [(bowl, 0.6), (arc, 0.9)])
def test_parts_of_a_hollow_cloud_leave_the_hollow_empty(shape, share):
    points = shape()
    parts = convex_parts(points, viewpoints=COMPLETE)
    assert len(parts) > 2
    assert volume(parts) < share * Hull.of(points).volume


@pytest.mark.parametrize("shape", [bowl, arc, box])
def test_every_point_lies_in_some_part(shape):
    points = shape(count=1200)
    parts = [Hull.of(part) for part in convex_parts(points, viewpoints=COMPLETE)]
    assert np.min([part.signed_distance(points) for part in parts], axis=0).max() < 1e-9


def test_sides_no_camera_saw_are_no_hollow():
    points = box()
    seen = points[(points[:, 2] > 0.0999) | (points[:, 1] > 0.0499)]  # top and front only
    assert len(convex_parts(seen, viewpoints=np.array([[0.0, 1.0, 1.0]]))) == 1


@pytest.mark.parametrize(
    "points", [np.zeros((1, 3)), np.zeros((9, 3)), np.linspace([0, 0, 0], [0.1, 0, 0], 30)]
)
def test_degenerate_clouds_are_one_part(points):
    assert len(convex_parts(points, viewpoints=COMPLETE)) == 1


def test_a_wall_with_a_gap_of_a_quarter_still_surrounds_and_half_a_wall_does_not():
    turn = np.linspace(0, 2 * np.pi, 200)
    wall = np.c_[0.1 * np.cos(turn), 0.1 * np.sin(turn), np.full(200, 0.05)]
    middle = np.zeros((1, 3))
    assert is_surrounded(middle, wall[turn < 1.55 * np.pi], UP, 0.004).all()
    assert not is_surrounded(middle, wall[turn < 1.1 * np.pi], UP, 0.004).any()
