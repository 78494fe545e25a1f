import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from topple.planner.grasp.cells import Cells, Region


def poses(count: int, rng: np.random.Generator) -> np.ndarray:
    found = np.tile(np.eye(4), (count, 1, 1))
    found[:, :3, :3] = Rotation.random(count, random_state=rng).as_matrix()
    found[:, :3, 3] = rng.uniform(-0.4, 0.4, (count, 3))
    return found


def plain(clouds: list[np.ndarray], hands: np.ndarray, region: Region) -> np.ndarray:
    """Every point by itself."""
    found = np.zeros((len(hands), len(clouds)), dtype=np.int64)
    for row, hand in enumerate(hands):
        for column, cloud in enumerate(clouds):
            local = (cloud - hand[:3, 3]) @ hand[:3, :3]
            inside = ((local > region.lower[row]) & (local < region.upper[row])).all(axis=1)
            found[row, column] = np.count_nonzero(inside & (np.hypot(*local[:, :2].T) < region.radius))
    return found


@pytest.mark.parametrize("edge", [0.004, 0.012, 0.1])
@pytest.mark.parametrize("radius", [np.inf, 0.05])
def test_counts_are_those_of_every_point_by_itself(edge, radius):
    rng = np.random.default_rng(0)
    clouds = [
        rng.uniform(-0.3, 0.3, (size, 3)) * [1.0, 1.0, flat]
        for size, flat in ((6000, 0.01), (900, 1.0), (1, 1.0))
    ]
    hands, lower = poses(150, rng), rng.uniform(-0.15, 0.0, (150, 3))
    region = Region(lower, lower + rng.uniform(0.005, 0.2, (150, 3)), radius)
    other = Region(lower - 0.05, lower + 0.01, np.inf)
    cells, expected = Cells.of(clouds, edge), plain(clouds, hands, region)
    assert expected.max() > 100
    assert np.array_equal(cells.counts(hands, region), expected)
    more = (expected > 2) | (plain(clouds, hands, other) > 2)
    assert np.array_equal(cells.more_than(2, hands, [region, other]), more)


def test_no_points_no_hands_and_no_regions_are_nothing():
    rng = np.random.default_rng(0)
    hands = poses(3, rng)
    region = Region(np.full((3, 3), -1.0), np.full((3, 3), 1.0))
    assert Cells.of([]).counts(hands, region).shape == (3, 0)
    cells = Cells.of([np.zeros((1, 3))])
    assert cells.counts(hands[:0], Region(region.lower[:0], region.upper[:0])).shape == (0, 1)
    assert not cells.more_than(0, hands, []).any()
