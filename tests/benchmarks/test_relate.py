"""The bench of relations, where it is short enough."""

from topple.benchmarks.relate import Extent, _crowds
from topple.topology.relations.relate import MOST_OBJECTS


def test_more_objects_than_a_scene_may_have_unasked_are_measured():
    extent = Extent(
        (), crowds=(MOST_OBJECTS // 10, MOST_OBJECTS + 1), points=12, crowds_by_default=False, repeats=1
    )
    (found,) = _crowds(extent, seed=0)
    assert found.what.startswith(f"{MOST_OBJECTS + 1} objects x 12 points, plain rule")
    assert found.ratio is not None and found.ratio > 1.0
