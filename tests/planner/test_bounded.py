"""Work is bounded by what is near, and refused beyond a stated number of objects."""

import time
import tracemalloc
from collections.abc import Callable

import numpy as np
import pytest

from topple.planner.planning.order import order
from topple.topology import InvalidInput, Scene, relate
from topple.topology.base.arrays import FloatArray
from topple.topology.relations.tolerances import MOST_OBJECTS
from topple.topology.sixim.plain import plain_relations

SECONDS = 5.0  # of processor; a room takes below one
UP = (0.0, 0.0, 1.0)


def box(size: float, middle: tuple[float, float, float], count: int) -> FloatArray:
    """Points all over a box, the same number on each side."""
    rng = np.random.default_rng(0)
    points = rng.uniform(-0.5, 0.5, (count, 3))
    side = np.arange(count) % 6
    points[np.arange(count), side // 2] = side % 2 - 0.5
    return points * size + middle


def stack() -> dict[str, FloatArray]:
    rng = np.random.default_rng(1)
    table = np.c_[rng.uniform(-0.4, 0.4, (4000, 2)), np.zeros(4000)]
    return {"table": table, **{f"box_{k}": box(0.06, (0.0, 0.0, 0.03 + 0.06 * k), 800) for k in range(3)}}


def spent(work: Callable[[], object]) -> float:
    begun = time.process_time()
    work()
    return time.process_time() - begun


@pytest.mark.slow
@pytest.mark.parametrize("fixed", [["table"], ["table", "hollow"]], ids=["movable", "fixed"])
@pytest.mark.parametrize("count", [3_000, 20_000])
@pytest.mark.parametrize("size", [1.0, 3.0, 19.0])
def test_what_encloses_a_stack_takes_no_longer_for_its_size(size, count, fixed):
    clouds = {**stack(), "hollow": box(size, (0.0, 0.0, 0.3), count)}
    scene = Scene(clouds, fixed, UP)
    assert spent(lambda: relate(scene)) < SECONDS
    assert spent(lambda: order(scene, check_gravity=False)) < SECONDS
    alone = relate(Scene(stack(), ["table"], UP), deviation=0.002)
    among = relate(scene, deviation=0.002)
    for pair in alone:
        assert among.between(pair.a, pair.b).relation is pair.relation


def test_the_hull_of_what_encloses_is_its_hull():
    clouds = {**stack(), "hollow": box(3.0, (0.0, 0.0, 0.3), 20_000)}
    pair = relate(Scene(clouds, ["table"], UP), plain=True).between("box_0", "hollow")
    relation, matrix = plain_relations(clouds, 0.002)["box_0", "hollow"]
    assert pair.relation is relation and pair.relation == "within"
    assert np.array_equal(pair.matrix, matrix)


@pytest.mark.parametrize("apart", [0.0, 0.2], ids=["identical", "disjoint"])
def test_more_objects_than_a_stated_number_are_refused_at_once(apart):
    small = box(0.05, (0.0, 0.0, 0.0), 40)
    scene = Scene(
        {f"o{k}": small + np.array([apart * (k % 60), apart * (k // 60), 0.0]) for k in range(3000)}, up=UP
    )
    tracemalloc.start()
    try:
        for work in (lambda: relate(scene), lambda: order(scene)):
            with pytest.raises(InvalidInput, match=r"3000 objects, and 500 are allowed.*max_objects=N"):
                work()
        assert tracemalloc.get_traced_memory()[1] < 50e6
    finally:
        tracemalloc.stop()


def test_pairs_that_are_near_each_other_count_too():
    small = box(0.05, (0.0, 0.0, 0.0), 40)
    with pytest.raises(InvalidInput, match="124750 pairs of objects near each other, and 10000 are allowed"):
        relate(Scene({f"o{k}": small for k in range(MOST_OBJECTS)}, up=UP))


def test_the_number_is_an_option():
    small = box(0.05, (0.0, 0.0, 0.0), 40)
    scene = Scene({f"o{k}": small + np.array([0.2 * k, 0.0, 0.0]) for k in range(4)}, up=UP)
    with pytest.raises(InvalidInput, match="4 objects, and 3 are allowed"):
        relate(scene, max_objects=3)
    assert len(relate(scene, max_objects=4)) == 6
    far = {f"o{k}": small + np.array([0.2 * (k % 60), 0.2 * (k // 60), 0.0]) for k in range(MOST_OBJECTS + 1)}
    assert len(relate(Scene(far, up=UP), max_objects=MOST_OBJECTS + 1)) == 125_250
