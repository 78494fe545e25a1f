"""Rows added, measured and compared axis by axis: the bits of numpy's own."""

import numpy as np
import pytest

from topple.topology.base.arrays import (
    bounds,
    lengths,
    median_of,
    middle_of,
    quantiles_of,
    sum_of_rows,
    within_corners,
)


@pytest.mark.parametrize("size", [2, 3])
@pytest.mark.parametrize("count", [1, 7, 2501])
def test_short_rows_are_read_to_the_last_bit_as_numpy_reads_them(count, size):
    rng = np.random.default_rng(count)
    points = rng.normal(size=(count, size)) + 3 * rng.normal(size=size)
    assert np.array_equal(middle_of(points), points.mean(axis=0))
    assert np.array_equal(lengths(points), np.linalg.norm(points, axis=1))
    assert np.array_equal(sum_of_rows(points), points.sum(axis=1))
    lower, upper = bounds(points)
    assert np.array_equal(lower, points.min(axis=0))
    assert np.array_equal(upper, points.max(axis=0))
    low, high = np.quantile(points, [0.2, 0.8], axis=0)
    inside = ((points >= low) & (points <= high)).all(axis=1)
    assert np.array_equal(within_corners(points, low, high), inside)


@pytest.mark.parametrize("count", [1, 2, 7, 40, 2501])
def test_quantiles_are_those_of_numpy_to_the_last_bit(count):
    for values in (rng := np.random.default_rng(count)).normal(size=count), rng.normal(size=count).round(1):
        shares = (0.005, 0.05, 0.5, 0.9, 0.995, *rng.random(20))
        assert quantiles_of(values, *shares) == np.quantile(values, shares).tolist()
        assert median_of(values) == np.median(values)
