import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from topple.planner.motion.trajectory import retime
from topple.robots.catalog import robot


def random_path(seed: int, count: int, spread: float) -> np.ndarray:
    return robot("panda").home + spread * np.random.default_rng(seed).uniform(-1, 1, (count, 7))


@settings(deadline=None, max_examples=40)
@given(
    seed=st.integers(0, 1000),
    count=st.integers(2, 12),
    spread=st.floats(1e-3, 1.5),
    speed=st.sampled_from([0.1, 0.5, 1.0]),
)
def test_limits_are_kept_and_the_ends_are_at_rest(seed, count, spread, speed):
    arm, path = robot("panda"), random_path(seed, count, spread)
    found = retime(arm, path, speed)
    assert np.array_equal(found.positions[0], path[0])
    assert np.array_equal(found.positions[-1], path[-1])
    assert (np.diff(found.times) > 0).all()
    assert not found.velocities[[0, -1]].any()
    assert (np.abs(found.velocities) <= speed * arm.velocity * 1.001).all()
    change = np.abs(np.diff(found.velocities[:-1], axis=0)) * 240
    assert (change <= speed**2 * arm.acceleration * 1.01 + 1e-9).all()


def test_velocities_are_the_slopes_of_the_positions():
    found = retime(robot("panda"), random_path(0, 2, 1.0))
    slopes = np.diff(found.positions, axis=0) / np.diff(found.times)[:, None]
    means = (found.velocities[1:] + found.velocities[:-1]) / 2
    assert np.abs(slopes - means).max() < 0.02


def test_every_sample_lies_on_the_path():
    path = random_path(3, 5, 0.8)
    found = retime(robot("panda"), path, 1.0)
    starts, ways = path[:-1], np.diff(path, axis=0)
    assert len(found.positions) > 10 * len(path)
    for q in found.positions:
        t = np.clip(np.einsum("ij,ij->i", q - starts, ways) / np.einsum("ij,ij->i", ways, ways), 0, 1)
        assert np.linalg.norm(starts + t[:, None] * ways - q, axis=1).min() < 1e-9


def test_a_faster_share_takes_less_time():
    arm, path = robot("panda"), random_path(1, 4, 1.0)
    fast, fair, slow = (retime(arm, path, share).times[-1] for share in (1.0, 0.5, 0.2))
    assert fast < fair < slow


def test_a_path_that_goes_nowhere_takes_no_time():
    arm = robot("panda")
    for path in (arm.home[None], np.array([arm.home, arm.home])):
        found = retime(arm, path)
        assert found.times[-1] == 0
        assert found.positions.shape == (1, 7)


def test_a_trajectory_cannot_be_written_to():
    found = retime(robot("panda"), random_path(1, 4, 1.0))
    with pytest.raises(ValueError, match="read-only"):
        found.positions[0] = 1.0
