"""Where an object goes when it is taken: up, or level from under what is fixed over it."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from topple.robots.shapes import box
from topple.topology.base.arrays import BoolArray, FloatArray
from topple.topology.statics.way_out import continued_boards, way_out

UP = np.array([0.0, 0.0, 1.0])
TURN = Rotation.from_euler("zyx", [0.4, 0.3, -0.2]).as_matrix()
THING = box(size=(0.06, 0.06, 0.1)).surface(2000, np.random.default_rng(0))


def slab(size: tuple[float, float, float], *place: float) -> FloatArray:
    return box(size=size).surface(8000, np.random.default_rng(1)) + np.array(place)


TABLE = slab((1.0, 1.0, 0.02), 0.0, 0.0, -0.02)
BOARD = slab((0.3, 0.6, 0.02), 0.1, 0.0, 0.3)  # 5 cm beyond the thing at -x
FRONT = slab((0.02, 0.6, 0.3), -0.06, 0.0, 0.0)
BACK = slab((0.02, 0.6, 0.3), 0.26, 0.0, 0.0)
ASIDE = slab((0.3, 0.6, 0.02), 0.3, 0.0, 0.3)
HIGH = slab((0.3, 0.6, 0.02), 0.1, 0.0, 0.7)
SIDE = slab((0.3, 0.02, 0.3), 0.1, 0.3, 0.0)


@pytest.mark.parametrize(
    ("fixed", "way"),
    [
        ((TABLE,), (0.0, 0.0, 1.0)),
        ((TABLE, SIDE), (0.0, 0.0, 1.0)),
        ((TABLE, ASIDE), (0.0, 0.0, 1.0)),
        ((TABLE, HIGH), (0.0, 0.0, 1.0)),
        ((TABLE, BOARD), (-1.0, 0.0, 0.0)),
        ((TABLE, BOARD, FRONT), (1.0, 0.0, 0.0)),
        ((TABLE, BOARD, FRONT, BACK, SIDE), (0.0, -1.0, 0.0)),
        ((TABLE, BOARD, FRONT, BACK, SIDE, SIDE * [1.0, -1.0, 1.0]), (0.0, 0.0, 1.0)),
    ],
)  # fmt: skip
def test_the_way_out_is_up_or_the_shortest_free_one_from_under_a_board(fixed, way):
    still = np.concatenate(fixed)
    assert np.allclose(way_out(THING, still, UP), way, atol=0.02)
    turned = way_out(THING @ TURN.T, still @ TURN.T, TURN @ UP)
    assert np.allclose(turned, TURN @ np.array(way), atol=0.02)


def test_a_few_strays_over_an_object_bar_nothing():
    strays = np.array([[0.01 * k, 0.0, 0.2] for k in range(3)])
    assert np.array_equal(way_out(THING, np.concatenate([TABLE, strays]), UP), UP)
    assert np.array_equal(way_out(THING, np.empty((0, 3)), UP), UP)


def test_a_wall_that_a_thin_thing_stands_against_is_not_over_it():
    thin = box(size=(0.012, 0.1, 0.1)).surface(2000, np.random.default_rng(0))
    wall = slab((0.02, 0.6, 0.3), -0.017, 0.0, 0.0)
    assert np.array_equal(way_out(thin, np.concatenate([TABLE, wall]), UP), UP)
    assert not np.array_equal(way_out(thin, np.concatenate([TABLE, BOARD]), UP), UP)


def test_a_board_that_a_picture_ends_on_goes_on_over_its_shelf_unless_that_is_seen_to_be_empty():
    shelf = np.concatenate(
        [slab((0.5, 0.6, 0.02), 0.15, 0.0, -0.02), slab((0.12, 0.6, 0.02), -0.04, 0.0, 0.3)]
    )

    def hidden(places: FloatArray) -> BoolArray:
        return np.zeros(len(places), dtype=np.bool_)

    guessed = continued_boards(shelf, UP, hidden)
    assert np.allclose(np.ptp(guessed, axis=0), [0.5, 0.6, 0.0], atol=0.03)
    assert np.allclose(guessed[:, 2], 0.32, atol=0.004)
    thing = THING + np.array([0.08, 0.0, 0.0])
    assert np.array_equal(way_out(thing, shelf, UP), UP)
    assert np.allclose(way_out(thing, np.concatenate([shelf, guessed]), UP), [-1.0, 0.0, 0.0], atol=0.02)
    assert len(continued_boards(shelf, UP, lambda places: ~hidden(places))) == 0
    assert len(continued_boards(TABLE, UP, hidden)) == 0
