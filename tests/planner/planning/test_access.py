"""What leaves a hand no room is told apart from what would move."""

import numpy as np
import pytest

from topple.planner.planning.order import order
from topple.topology.scene.scene import Scene

AREAL = 150_000  # points a square metre: 2.5 mm apart, as a camera sees them at a metre


def _block(centre: tuple[float, float], size: tuple[float, float, float]) -> np.ndarray:
    """Points on the surface of a block that stands on z = 0."""
    rng = np.random.default_rng(0)
    count = round(AREAL * 2 * _faces(size).sum())
    points = rng.uniform(-0.5, 0.5, (count, 3))
    axis = rng.choice(3, count, p=_faces(size) / _faces(size).sum())
    points[np.arange(count), axis] = rng.choice([-0.5, 0.5], count)
    return points * size + [*centre, size[2] / 2]


def _faces(size: tuple[float, float, float]) -> np.ndarray:
    return np.array([size[1] * size[2], size[0] * size[2], size[0] * size[1]])


def _scene(**blocks: np.ndarray) -> Scene:
    rng = np.random.default_rng(1)
    table = np.column_stack([rng.uniform(-0.4, 0.4, (8000, 2)), np.zeros(8000)])
    return Scene({**blocks, "table": table}, fixed=["table"], up=[0, 0, 1])


BAR = _block((0, 0), (0.2, 0.04, 0.04))
LEFT, RIGHT = (_block((0, side * 0.05), (0.3, 0.05, 0.12)) for side in (-1, 1))


def test_a_bar_that_stands_free_is_barred_by_nobody():
    assert order(_scene(bar=BAR), "bar", robot="panda").access == ()


def test_who_stands_so_close_that_no_finger_fits_is_named():
    (bar,) = order(_scene(bar=BAR, left=LEFT), "bar", robot="panda").access
    assert (bar["first"], bar["then"]) == ("left", "bar")
    assert "leaves the hand no room" in bar["reason"]


@pytest.mark.slow
def test_both_are_named_where_only_together_they_leave_room():
    found = order(_scene(bar=BAR, left=LEFT, right=RIGHT), "bar", robot="panda")
    assert {bar["first"] for bar in found.access} <= {"left", "right"}
    assert len(found.access) >= 1
    assert found.order == ("bar",)  # nobody would move: no dependency


def test_what_no_hand_can_hold_is_said():
    found = order(_scene(slab=_block((0, 0), (0.18, 0.18, 0.05))), "slab", robot="panda")
    assert found.access == ()
    assert any("finds no grasp of slab" in text for text in found.assumptions)


@pytest.mark.parametrize("robot", [None, "panda"])
def test_access_stands_in_the_document(robot):
    document = order(_scene(bar=BAR, left=LEFT), "bar", robot=robot).to_json()
    assert document["access"] == (
        []
        if robot is None
        else [{"first": "left", "then": "bar", "reason": "left leaves the hand no room at bar"}]
    )
