"""A matrix is what was counted; where the relation is not what Table 1 reads in it, the pair says why."""

import sys
from pathlib import Path

import numpy as np
import pytest

from topple.topology.relations.inferred import FLOATS, MEET
from topple.topology.relations.relate import relate
from topple.topology.relations.robust import APART, CLOSE, FEW, HOLLOW
from topple.topology.scene.scene import Scene
from topple.topology.sixim.pair import PairRelation
from topple.topology.sixim.table import Relation, classify

sys.path.insert(0, str(Path(__file__).parents[1]))
from made import UP, ball, bowl, pile, seen, whole


def check(pair: PairRelation, size_a: int, size_b: int) -> None:
    """The matrix counts every point once, and only a reason parts the relation from it."""
    assert pair.matrix.sum(axis=1).tolist() == [size_a, size_b]
    assert classify(pair.matrix) is pair.relation or pair.reason is not None, pair
    assert pair.converse.reason == pair.reason
    assert pair.to_json()["reason"] == pair.reason


@pytest.mark.parametrize("cameras", [0, 1, 3])
@pytest.mark.parametrize("plain", [False, True])
def test_only_a_reason_parts_the_relation_from_the_matrix(cameras, plain):
    for seed in range(8):
        rng = np.random.default_rng(seed)
        boxes = pile(rng)
        scene = seen(boxes, rng, cameras) if cameras else whole(boxes, rng)
        relations = relate(scene, plain=plain)
        sizes = {one.name: one.size for one in relations.prepared}  # type: ignore[attr-defined]
        for pair in relations:
            check(pair, sizes[pair.a], sizes[pair.b])
            assert not plain or pair.reason is None
            assert pair.inferred == (pair.reason in (FLOATS, MEET))


def between(a: np.ndarray, b: np.ndarray, deviation: float | None = None) -> PairRelation:
    relations = relate(Scene({"a": a, "b": b}, fixed=["a", "b"], up=UP), deviation)
    check(relations.between("a", "b"), *(one.size for one in relations.prepared))
    return relations.between("a", "b")


def test_surfaces_that_meet_between_their_points_touch_within_the_deviation():
    grid = np.stack(np.meshgrid(np.linspace(-0.3, 0.3, 13), np.linspace(-0.3, 0.3, 13), [0.0]), -1)
    pair = between(np.array([[0.013, 0.021, 0.001], [0.013, 0.021, 0.05]]), grid.reshape(-1, 3), 0.002)
    assert (pair.relation, pair.reason) == (Relation.TOUCH, CLOSE)
    assert pair.matrix[:, :2].sum() == 0


def test_points_of_cells_that_are_near_do_not_make_surfaces_touch():
    rng = np.random.default_rng(0)
    lower = np.c_[rng.uniform(-0.1, 0.1, (6000, 2)), np.zeros(6000)]
    pair = between(lower + 0.005 * UP, lower, 0.002)
    assert (pair.relation, pair.reason) == (Relation.DISJOINT, APART)
    assert (pair.matrix[:, 1] > 0).all()


def test_a_ball_below_the_rim_is_held_in_the_hollow_of_its_bowl():
    rng = np.random.default_rng(1)
    pair = between(ball(rng, 0.015, np.array([0, 0, 0.034])), bowl(rng))
    assert (pair.relation, pair.reason) == (Relation.WITHIN, HOLLOW)
    assert pair.matrix[0, 2] > 0


def test_a_few_points_inside_put_nothing_into_the_other():
    rng = np.random.default_rng(2)
    above = ball(rng, 0.02, np.array([0.0, 0.0, 0.085]), 992)
    wick = np.linspace(0.02, 0.065, 8)[:, None] * UP
    pair = between(np.concatenate([above, wick]), bowl(rng))
    assert (pair.relation, pair.reason) == (Relation.DISJOINT, FEW)
    assert 0 < pair.matrix[0, 0] < 8
