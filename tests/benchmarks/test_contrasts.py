"""Models to compare with: nine intersections of exact and noisy solids, support features and their tree."""

import numpy as np
import pytest

from topple.benchmarks.contrasts.features import support_features
from topple.benchmarks.contrasts.nine import RELATIONS, Solid, nine, nine_intersections
from topple.benchmarks.contrasts.support_tree import support_tree
from topple.robots.shapes.boxes import box
from topple.topology import Relation, Scene

NOISE = 0.002  # [m]
CONVERSE = {"inside": "contains", "covered by": "covers", "contains": "inside", "covers": "covered by"}


def cube(side: float, *place: float) -> Solid:
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * side / 2
    return Solid.of("cube", (corners + np.array(place or (0.0, 0.0, 0.0)),))


@pytest.mark.parametrize(
    ("other", "relation"),
    [
        (cube(0.1, 0.2, 0, 0), "disjoint"),
        (cube(0.1, 0.05, 0.05, 0.05), "overlap"),
        (cube(0.2), "inside"),
        (cube(0.04), "contains"),
    ],
)
def test_what_is_clear_is_told_and_its_converse_too(other, relation):
    found = nine_intersections(cube(0.1), other, NOISE)
    assert found.cells == RELATIONS[relation] and found.possible == (relation,)
    assert nine_intersections(other, cube(0.1), NOISE).possible == (CONVERSE.get(relation, relation),)


@pytest.mark.parametrize("gap", [-0.001, 0.0, 0.001])
@pytest.mark.parametrize("noise", [0.0015, 0.004])
def test_touch_is_never_told_from_a_gap_or_an_overlap_within_the_noise(gap, noise):
    found = nine_intersections(cube(0.1), cube(0.1, 0.1 + gap, 0, 0), noise)
    assert found.possible == ("disjoint", "meet", "overlap")


def test_the_truth_is_always_among_what_is_possible():
    rng = np.random.default_rng(0)
    for _ in range(60):
        side, place = rng.uniform(0.03, 0.2), rng.uniform(-0.15, 0.15, 3)
        reach = np.abs(place).max() - (0.1 + side) / 2
        true = "disjoint" if reach > 0 else "overlap"
        if np.abs(place).max() + side / 2 < 0.05:
            true = "contains"
        if np.abs(place).max() + 0.05 < side / 2:
            true = "inside"
        found = nine_intersections(cube(0.1), cube(side, *place), NOISE)
        assert true in found.possible
        assert abs(reach) < 3 * NOISE or true not in ("disjoint", "overlap") or found.possible == (true,)


def test_a_solid_of_several_parts_has_no_surface_between_them():
    corners = cube(0.1).hulls[0].vertices
    two = Solid.of("bar", (corners, corners + np.array([0.06, 0, 0])))
    inner = nine_intersections(cube(0.02, 0.03, 0, 0), two, NOISE)
    assert inner.possible == ("inside",)


@pytest.fixture(scope="module")
def stack() -> Scene:
    """A box on a box on a table, and one that stands apart."""
    rng = np.random.default_rng(0)
    x, y = np.meshgrid(np.arange(-0.3, 0.4, 0.008), np.arange(-0.3, 0.3, 0.008))
    side = (0.08, 0.08, 0.08)
    clouds = {
        "table": np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)]),
        "low": box("low", side).surface(2500, rng),
        "top": box("top", side).surface(2500, rng) + np.array([0.0, 0.0, 0.0802]),
        "apart": box("apart", side).surface(2500, rng) + np.array([0.25, 0.0, 0.0]),
    }
    return Scene(clouds, fixed=["table"], up=[0, 0, 1])


def test_of_a_scene_it_says_touch_where_that_is_possible(stack):
    found = nine(stack)
    assert found["low", "top"] is Relation.TOUCH and found["top", "apart"] is Relation.DISJOINT
    there = {**stack.clouds, "top": stack.clouds["top"] + np.array([0.0, 0.2, -0.0802])}
    assert nine(Scene(there, fixed=["table"], up=[0, 0, 1]))["low", "top"] is Relation.DISJOINT


def test_support_features_tell_what_carries(stack):
    found = support_features(stack)
    assert found["low", "top"] is Relation.TOUCH and found["table", "low"] is Relation.TOUCH
    assert found["table", "top"] is Relation.DISJOINT


def test_a_support_tree_takes_the_highest_level_first(stack):
    pairs, order = support_tree(stack)
    assert pairs == {("top", "low")} and order[0] == "top" and set(order) == {"low", "top", "apart"}
