import numpy as np
import pytest

from topple.topology.geometry.outline import covers, outline
from topple.topology.relations.relate import relate
from topple.topology.scene.scene import Scene

UP = np.array([0.0, 0.0, 1.0])


def _band(start, end, radius=0.1, width=0.008, count=800, seed=0):
    """A noisy arc of a rim around (0.3, 0.2), in degrees."""
    rng = np.random.default_rng(seed)
    angle = np.radians(rng.uniform(start, end, count))
    length = radius + rng.uniform(-width, 0, count)
    points = np.c_[length * np.cos(angle), length * np.sin(angle), rng.uniform(0, 0.01, count)]
    return points + np.array([0.3, 0.2, 0.0]) + rng.normal(0, 0.001, points.shape)


@pytest.mark.parametrize("arc", [(0, 110), (-80, 80), (30, 330)])
def test_an_arc_of_a_rim_covers_its_circle(arc):
    rim = _band(*arc)
    flat = outline(rim, UP)
    assert (flat[: len(rim)] == rim[:, :2]).all()
    distances = np.linalg.norm(flat[len(rim) :] - [0.3, 0.2], axis=1)
    assert len(distances) > 0
    assert np.abs(distances - 0.096).max() < 0.012
    assert covers([flat], np.array([0.3, 0.2]), 0.0)


def test_what_is_no_arc_covers_what_was_seen_of_it():
    rng = np.random.default_rng(1)
    corner = np.concatenate(
        [np.c_[rng.uniform(0, 0.1, 400), np.zeros(400)], np.c_[np.zeros(400), rng.uniform(0, 0.1, 400)]]
    )
    straight = np.c_[rng.uniform(0, 0.2, 400), rng.normal(0, 0.001, 400)]
    full = rng.uniform(-0.1, 0.1, (800, 2))
    for flat in (corner, straight, full, corner[:5], corner[:1]):
        points = np.column_stack([flat, rng.uniform(0, 0.05, len(flat))])
        assert len(outline(points, UP)) == len(points)
    assert not covers([corner], np.array([0.08, 0.08]), 0.0)
    assert covers([corner, np.array([[0.1, 0.1]])], np.array([0.08, 0.08]), 0.0)


def test_the_outline_does_not_depend_on_where_up_points():
    rim = _band(0, 150)
    turned = outline(rim[:, [2, 0, 1]], np.array([1.0, 0.0, 0.0]))
    centre = turned[len(rim) :].mean(axis=0)
    assert np.linalg.norm(turned[len(rim) :] - centre, axis=1).std() < 1e-9
    assert len(turned) == len(outline(rim, UP))


def test_a_plate_on_a_plate_of_which_a_crescent_shows_is_not_held_by_the_table():
    rng = np.random.default_rng(2)
    angle, share = rng.uniform(0, 2 * np.pi, 6000), np.sqrt(rng.uniform(0, 1, 6000))
    dish = np.c_[0.1 * share * np.cos(angle), 0.1 * share * np.sin(angle), 0.02 * share**4 + 0.012]
    upper = dish + np.array([0.3, 0.2, 0.012])
    lower = _band(-170, -10, radius=0.104) + np.array([0, 0, 0.022])  # its rim, on the camera's side
    ground = np.c_[rng.uniform(-0.2, 0.8, (9000, 2)), np.zeros(9000)]
    shadow = np.linalg.norm(ground[:, :2] - [0.3, 0.22], axis=1) < 0.13
    scene = Scene(
        {"table": ground[~shadow], "lower": lower, "upper": upper},
        fixed=["table"],
        up=UP,
        viewpoints=[[0.3, -0.5, 0.7]],
    )
    relations = relate(scene)
    assert str(relations.between("upper", "lower").relation) == "touch", relations.between("upper", "lower")
    assert str(relations.between("upper", "table").relation) == "disjoint"
