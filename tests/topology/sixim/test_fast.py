"""The fast paths answer as the paper's rule written down plainly, for clouds of every shape there is.

Where a distance is the deviation to the last bit, rounding decides, and in either differently: the deviation
here is no multiple of the steps in which the clouds are made.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from topple.topology.geometry.hull import Hull
from topple.topology.relations.relate import relate
from topple.topology.scene.scene import Scene
from topple.topology.sixim.fast.regions import Regions
from topple.topology.sixim.plain import counts, plain_relations

DEVIATION = 0.0020137


def lattice(*sides: int) -> np.ndarray:
    """(N, 3) points a centimetre apart."""
    return np.stack(np.meshgrid(*(np.arange(side) for side in sides), indexing="ij"), -1).reshape(-1, 3) / 100


def shell(rng: np.random.Generator, count: int, flat: int) -> np.ndarray:
    """(N, 3) points on an ellipsoid without extent along some axes."""
    points = rng.normal(size=(count, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    return points * rng.uniform(0.01, 0.06, 3) * (np.arange(3) >= flat)


SHAPES = {
    "point": lambda rng: np.zeros((1, 3)),
    "one point many times": lambda rng: np.zeros((40, 3)),
    "two points": lambda rng: np.array([[0.0, 0.0, 0.0], [0.0, 0.03, 0.04]]),
    "three points": lambda rng: rng.uniform(-0.05, 0.05, (3, 3)),
    "segment": lambda rng: shell(rng, 30, 2),
    "segment of equal steps": lambda rng: lattice(9, 1, 1),
    "sheet": lambda rng: shell(rng, 200, 1),
    "lattice in a plane": lambda rng: lattice(6, 5, 1),
    "thinner than a hull": lambda rng: shell(rng, 200, 0) * [1, 1, 1e-8],
    "thin": lambda rng: shell(rng, 200, 0) * [1, 1, 1e-4],
    "corners of a cube": lambda rng: lattice(2, 2, 2) * 5,
    "block of a lattice": lambda rng: lattice(5, 4, 3),
    "ellipsoid": lambda rng: shell(rng, 400, 0),
    "dense": lambda rng: shell(rng, 9000, 0) + rng.normal(0, 5e-4, (9000, 3)),
    "each point twice": lambda rng: np.repeat(shell(rng, 100, 0), 2, axis=0),
}


def made(name: str, rng: np.random.Generator) -> np.ndarray:
    """A shape near the origin: moved a little, upright or turned, large or small."""
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    cloud = SHAPES[name](rng) * rng.choice([0.3, 1.0, 1.5])
    return (cloud @ turn if rng.random() < 0.5 else cloud) + rng.uniform(-0.03, 0.03, 3)


@given(st.integers(0, 2**32), st.lists(st.sampled_from(sorted(SHAPES)), min_size=2, max_size=4))
@settings(max_examples=150, deadline=None)
def test_relations_and_matrices_are_those_of_the_plain_rule(seed, names):
    rng = np.random.default_rng(seed)
    clouds = {f"{number} {name}": made(name, rng) for number, name in enumerate(names)}
    if rng.random() < 0.2:
        clouds["again"] = clouds[f"0 {names[0]}"]
    relations = relate(Scene(clouds), deviation=DEVIATION, plain=True)
    for (a, b), (relation, matrix) in plain_relations(clouds, DEVIATION).items():
        pair = relations.between(a, b)
        assert pair.relation is relation, (a, b, matrix)
        assert pair.matrix.tolist() == matrix.tolist(), (a, b)
        assert pair.reason is None


@given(st.integers(0, 2**32), st.sampled_from(sorted(SHAPES)), st.sampled_from(sorted(SHAPES)))
@settings(max_examples=60, deadline=None)
def test_prepared_regions_count_like_every_facet_for_every_point(seed, one, other):
    rng = np.random.default_rng(seed)
    points, hull = made(one, rng), Hull.of(made(other, rng))
    assert Regions(hull, DEVIATION).counts(points).tolist() == counts(points, hull, DEVIATION).tolist()


@pytest.mark.parametrize("facets", [60, 600])
def test_tables_of_a_hull_with_many_facets_change_no_count(facets):
    """So many distances that a table of the hull enlarged and shrunk by the deviation pays for itself."""
    rng = np.random.default_rng(facets)
    ball = rng.normal(size=(facets, 3))
    hull = Hull.of(0.05 * ball / np.linalg.norm(ball, axis=1, keepdims=True))
    points = rng.uniform(-0.06, 0.06, (4000, 3))
    assert Regions(hull, DEVIATION).counts(points).tolist() == counts(points, hull, DEVIATION).tolist()
