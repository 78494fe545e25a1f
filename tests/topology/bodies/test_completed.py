import numpy as np

from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation


def seen_from_one_side(viewpoints: list[list[float]]) -> Scene:
    """Top and front of a box on a table."""
    rng = np.random.default_rng(0)
    faces = rng.uniform(0.0, 1.0, (2, 1500, 3))
    faces[0, :, 2], faces[1, :, 0] = 1.0, 0.0
    seen = (faces.reshape(-1, 3) - [0.5, 0.5, 0.0]) * [0.05, 0.06, 0.1]
    grid = np.stack(np.meshgrid(np.arange(-0.4, 0.4, 0.008), np.arange(-0.4, 0.4, 0.008)), -1).reshape(-1, 2)
    behind = (grid[:, 0] > -0.03) & (grid[:, 0] < 0.1) & (np.abs(grid[:, 1]) < 0.03)
    table = np.column_stack([grid[~behind], np.zeros((~behind).sum())])
    return Scene({"box": seen, "table": table}, fixed=["table"], up=(0, 0, 1), viewpoints=viewpoints)


def test_the_unseen_back_of_a_box_is_part_of_the_whole_and_not_of_what_is_kept_clear_of():
    scene = seen_from_one_side([[-0.6, 0.0, 0.6]])
    situation = Situation(scene)
    whole, solids = situation.completed, situation.solids
    behind = np.array([0.02, 0.0, 0.02])

    def reach(parts: object) -> float:
        points = np.vstack(list(parts))  # type: ignore[call-overload]
        low = points[points[:, 2] < 0.03]
        return float(low[:, 0].max()) if len(low) else -np.inf

    assert reach(whole["box"]) > behind[0] - 0.005
    assert len(whole["box"]) == 1
    assert whole["table"] is solids["table"]


def test_nothing_is_guessed_where_nobody_says_from_where_it_was_seen():
    situation = Situation(seen_from_one_side([]))
    assert situation.completed is situation.solids
