"""Overlap of hulls is that of their volumes, and completed bodies are held against those that were seen."""

import numpy as np
import pytest

from topple.benchmarks.completion import completion_rows, overlap


def _cuboid(x: float) -> np.ndarray:
    return np.array([[x + a, b, c] for a in (0.0, 0.1) for b in (0.0, 0.05) for c in (0.0, 0.02)])


@pytest.mark.parametrize(("shift", "share"), [(0.0, 1.0), (0.05, 1 / 3), (0.2, 0.0)])
def test_the_overlap_of_two_cuboids_is_what_they_share(shift, share):
    assert overlap(_cuboid(0.0), _cuboid(shift), seed=0) == pytest.approx(share, abs=0.02)


@pytest.mark.slow
def test_completed_bodies_have_more_of_the_true_ones_than_was_seen():
    rows = completion_rows(0, 1, lambda text: None)
    one, known = (row for row in rows if row.bar == ">= 80")
    assert one.baseline_value is not None
    assert 100 > known.value > one.value > one.baseline_value > 0
    assert [row.bar for row in rows] == [
        *(None, None, ">= 90", ">= 90", None, None, "<= 2"),
        *(None, None, ">= 80", ">= 80", None, None, "<= 2"),
    ]
