"""Answers that are kept for whoever asks about the same arrays again."""

import numpy as np

from topple.topology.base.remembered import remember


def test_arrays_count_by_their_numbers_and_the_longest_unused_answer_goes_first():
    asked: list[float] = []

    @remember(2)
    def total(points: np.ndarray, more: str) -> float:
        asked.append(float(points.sum()))
        return asked[-1]

    one, two = np.arange(6.0), np.arange(6.0) + 1
    assert total(one, "a") == total(one.copy(), "a") == 15.0
    assert len(asked) == 1, "a copy is the same"
    total(one.reshape(2, 3), "a")
    assert len(asked) == 2, "another shape is not"
    total(one, "a")
    total(two, "a")  # drops the other shape
    total(one, "a")
    assert len(asked) == 3
    total(one, "b")
    total(two, "a")
    assert len(asked) == 5, "what else is given counts, too"
    total(two, more="b")
    assert len(asked) == 6


def test_an_array_that_was_written_to_is_another_one():
    double = remember(4)(lambda points: 2 * points)
    points = np.ones(3)
    assert (double(points) == 2).all()
    points[:] = 3
    assert (double(points) == 6).all()
    assert (double(points[::-1]) == 6).all(), "whatever its layout"
