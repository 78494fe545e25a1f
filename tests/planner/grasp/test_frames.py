import tracemalloc

import numpy as np

from topple.planner.grasp.frames import frames
from topple.planner.grasp.surface import surface_of

UP = np.array([0.0, 0.0, 1.0])


def test_sides_of_a_close_up_of_tens_of_thousands_of_points_are_found_in_little_memory():
    rng = np.random.default_rng(0)
    face = rng.uniform([0.0, -0.1, 0.0], [0.0, 0.1, 0.25], (16_000, 3))
    side = rng.uniform([0.0, 0.1, 0.0], [0.1, 0.1, 0.25], (8_000, 3))
    lean = np.array([[np.cos(0.2), 0.0, np.sin(0.2)], [0.0, 1.0, 0.0], [-np.sin(0.2), 0.0, np.cos(0.2)]])
    cloud = np.vstack([face, side]) @ lean.T
    surface = surface_of(cloud, UP, np.array([[-1.0, 0.5, 0.6]]))
    tracemalloc.start()
    found = list(frames(surface, UP, (0.0,), count=2))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 3e8  # a matrix of each with each would be 4.6e9
    normal = lean @ [1.0, 0.0, 0.0]
    assert any(np.abs(turn[:, 1] @ normal) > np.cos(0.05) for turn in found[0].rotations)
