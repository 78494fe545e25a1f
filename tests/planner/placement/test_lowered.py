"""Things lowered to where they are told to lie."""

from dataclasses import replace

import numpy as np
from on_table import on_table

from topple.planner.placement.lowered import lower
from topple.robots.scenarios.scenario import pose_at
from topple.robots.shapes import box
from topple.topology import Scene
from topple.topology.situation.situation import Situation

UP = np.array([0.0, 0.0, 1.0])


def seen_over_the_table(points: np.ndarray) -> Scene:
    scene = on_table((box("box", (0.05, 0.05, 0.05)), (0.0, 0.0, 0.0)), points=1500)
    board = scene.clouds["table"]
    leg = np.column_stack([np.zeros((len(board) // 4, 2)), np.linspace(-0.5, -0.05, len(board) // 4)])
    table = np.vstack([board, leg, points])
    return replace(scene, clouds={**scene.clouds, "table": table})


def height_beside(points: np.ndarray) -> float:
    place = lower("box", Situation.of(seen_over_the_table(points)), pose_at(0.2, 0.0, 0.0))
    assert place is not None
    return float(place.pose_at_rest(UP)[2, 3])


def test_a_thing_among_the_points_of_a_table_is_something_to_lie_on():
    level = np.column_stack([np.tile(np.arange(5), 5), np.repeat(np.arange(5), 5)]) * 0.004
    tile = np.column_stack([level[:, 0] + 0.19, level[:, 1], np.full(25, 0.02)])
    free = height_beside(np.zeros((0, 3)))
    assert abs(free) < 0.002
    assert abs(height_beside(tile) - free - 0.02) < 0.002
