"""Which boxes are near each other."""

import numpy as np

from topple.topology.geometry.broadphase import near_both_ways


def test_pairs_both_ways_are_those_of_looking_at_all_in_order():
    rng = np.random.default_rng(0)
    for count in (0, 1, 2, 40):
        lower, sizes = rng.uniform(0.0, 1.0, (count, 2)), rng.uniform(0.0, 0.2, (count, 2))
        boxes = [(low, low + size) for low, size in zip(lower, sizes, strict=True)]
        near = [
            (i, j)
            for i, one in enumerate(boxes)
            for j, other in enumerate(boxes)
            if i != j and (one[0] <= other[1] + 0.05).all() and (other[0] <= one[1] + 0.05).all()
        ]
        assert near_both_ways(boxes, 0.05) == near
        assert count < 40 or near
