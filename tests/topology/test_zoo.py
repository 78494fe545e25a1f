"""Degenerate clouds through every pair and both rules: no exception, no warning, and answers that agree."""

import json
from itertools import combinations

import numpy as np
import pytest

from topple.topology.relations.relate import relate
from topple.topology.scene.scene import Scene
from topple.topology.sixim.pair import PairRelation
from topple.topology.sixim.table import ONE_SIDED_CONTACT, Relation, classify, converse_matrix

UP = (0.0, 0.0, 1.0)
FAR = 1e3  # [m] where coordinates have lost seven of their sixteen digits


def box(count: int, seed: int = 0, low: float = 0.0) -> np.ndarray:
    """(N, 3) points on the sides of a box of 10 cm, its underside at height `low` [m]."""
    rng = np.random.default_rng(seed)
    points = rng.uniform(-0.05, 0.05, (count, 3))
    points[np.arange(count), rng.integers(0, 3, count)] = rng.choice([-0.05, 0.05], count)
    return points + np.array([0.0, 0.0, low + 0.05])


def flat(height: float = 0.0) -> np.ndarray:
    """(N, 3) points exactly in one plane."""
    across = np.linspace(-0.1, 0.1, 30)
    return np.stack(np.meshgrid(across, across, [height]), axis=-1).reshape(-1, 3)


ZOO = {
    "point": np.array([[0.02, 0.01, 0.1]]),
    "two points": np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.1]]),
    "coincident pair": np.array([[0.05, 0.0, 0.05], [0.05, 0.0, 0.05]]),
    "all equal": np.full((500, 3), 0.05),
    "collinear": np.linspace([-0.1, 0.0, 0.05], [0.1, 0.0, 0.05], 40),
    "three points": np.array([[0.05, 0.0, 0.0], [0.0, 0.05, 0.0], [-0.05, -0.05, 0.0]]),
    "flat": flat(),
    "tilted flat": flat() @ np.array([[0.8, 0.0, -0.6], [0.0, 1.0, 0.0], [0.6, 0.0, 0.8]]).T,
    "1e-6 thin": np.concatenate([flat(0.1), flat(0.1 + 1e-6)]),
    "sparse": box(12),
    "dense": box(40_000, low=0.1),
    "box": box(3000),
    "the same box": box(3000),
    "one facet": box(3000)[np.abs(box(3000)[:, 0] - 0.05) < 1e-9],
    "cube corners": box(8, 3).round(2),
    "far": box(2000, 5) + np.array([FAR, FAR, 0.0]),
    "far flat": flat() + np.array([FAR + 0.05, FAR, 0.0]),
    "far point": np.array([[FAR, FAR, 0.1]]),
}
PAIRS = list(combinations(ZOO, 2))


def check(pair: PairRelation, sizes: tuple[int, int]) -> None:
    """What holds for every pair: matrix, relation, gap and confidence fit each other and the clouds."""
    matrix = pair.matrix
    assert matrix.shape == (2, 3)
    assert matrix.dtype.kind == "i"
    assert (matrix >= 0).all()
    assert (matrix.sum(axis=1) > 0).all()
    assert (matrix.sum(axis=1) <= sizes).all()
    assert classify(matrix) is pair.relation or pair.reason is not None
    assert np.isfinite(pair.gap)
    assert 0.0 <= pair.confidence <= 1.0
    assert json.loads(json.dumps(pair.to_json(), allow_nan=False))["relation"] == pair.relation
    other = pair.converse
    assert other.relation is pair.relation.converse
    assert np.array_equal(other.matrix, converse_matrix(matrix))
    assert (other.a, other.b, other.gap) == (pair.b, pair.a, pair.gap)


@pytest.mark.parametrize("plain", [False, True], ids=["default", "plain"])
@pytest.mark.parametrize(("a", "b"), PAIRS, ids=[f"{a} - {b}" for a, b in PAIRS])
def test_every_two_of_the_zoo(a, b, plain):
    first, second = ZOO[a], ZOO[b]
    pair = relate(Scene({a: first, b: second}), plain=plain).between(a, b)
    check(pair, (len(first), len(second)))
    turned = relate(Scene({b: second, a: first}), plain=plain).between(a, b)
    assert turned.relation is pair.relation
    assert np.array_equal(turned.matrix, pair.matrix)
    assert turned.gap == pytest.approx(pair.gap, abs=1e-9)


@pytest.mark.parametrize("plain", [False, True])
def test_the_whole_zoo_in_one_scene(plain):
    scene = Scene(ZOO, up=UP, fixed=["flat"], viewpoints=[[0.0, -0.5, 0.8]])
    relations = relate(scene, plain=plain)
    assert len(relations) == len(relations.pairs) == len(PAIRS)
    for pair in relations:
        assert classify(pair.matrix) is pair.relation or pair.reason is not None
    text = json.dumps(relations.to_json(), allow_nan=False)
    assert len(json.loads(text)["relations"]) == len(PAIRS)


@pytest.mark.parametrize("plain", [False, True])
def test_a_segment_under_two_names_lies_on_itself(plain):
    for name in ("point", "all equal", "collinear", "flat", "sparse", "far", "far flat"):
        pair = relate(Scene({"one": ZOO[name], "again": ZOO[name]}), plain=plain).between("one", "again")
        assert pair.relation in (Relation.TOUCH, Relation.CROSS), name
        assert pair.gap <= 0.0 + 1e-9


@pytest.mark.parametrize("plain", [False, True])
@pytest.mark.parametrize(
    "name", ["point", "two points", "all equal", "collinear", "flat", "1e-6 thin", "sparse"]
)
def test_a_thing_far_off_is_related_as_near(name, plain):
    ground = flat(float(ZOO[name][:, 2].min()))
    near = relate(Scene({"thing": ZOO[name], "ground": ground}), plain=plain)
    away = relate(Scene({"thing": ZOO[name] + FAR, "ground": ground + FAR}), plain=plain)
    assert away.between("thing", "ground").relation is near.between("thing", "ground").relation
    pair = near.between("thing", "ground")
    # By the paper's rule a thing narrower than the ground's spacing may have no point of it on its boundary.
    assert pair.relation is Relation.TOUCH or (plain and pair.kind == ONE_SIDED_CONTACT)
