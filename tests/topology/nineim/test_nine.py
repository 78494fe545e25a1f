"""The nine intersections: the eight relations of exact solids, and what noise leaves open."""

import numpy as np
import pytest

from topple.planner.planning.order import order
from topple.planner.planning.step import ORDERERS
from topple.robots.shapes.boxes import box
from topple.topology import Relation, Scene, relate
from topple.topology.nineim.matrix import RELATIONS, Solid, nine_intersections

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
def test_what_is_clear_is_told_and_its_converse_too(other: Solid, relation: str) -> None:
    found = nine_intersections(cube(0.1), other, NOISE)
    assert found.cells == RELATIONS[relation] and found.possible == (relation,) and found.why_open is None
    assert nine_intersections(other, cube(0.1), NOISE).possible == (CONVERSE.get(relation, relation),)


@pytest.mark.parametrize("gap", [-0.001, 0.0, 0.001])
@pytest.mark.parametrize("noise", [0.0015, 0.004])
def test_touch_is_never_told_from_a_gap_or_an_overlap_within_the_noise(gap: float, noise: float) -> None:
    found = nine_intersections(cube(0.1), cube(0.1, 0.1 + gap, 0, 0), noise)
    assert found.possible == ("disjoint", "meet", "overlap")
    assert "cannot tell disjoint from meet from overlap" in (found.why_open or "")
    assert f"deviation of {1e3 * noise:.1f} mm" in (found.why_open or "")


def test_the_truth_is_always_among_what_is_possible() -> None:
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


def test_a_solid_of_several_parts_has_no_surface_between_them() -> None:
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


def test_as_a_rule_it_says_touch_where_that_is_possible_and_why_it_cannot_tell(stack: Scene) -> None:
    relations = relate(stack, rule="9im")
    pair = relations.between("top", "low")
    assert pair.relation is Relation.TOUCH and pair.confidence == pytest.approx(1 / 3)
    assert (pair.reason or "").startswith("9IM cannot tell disjoint from meet from overlap")
    assert relations.between("top", "apart").relation is Relation.DISJOINT
    assert pair.matrix.sum(axis=1).min() > 100 and relations.between("low", "top").relation is Relation.TOUCH
    assert order(stack, "low", relations=relations).order == ("top", "low")
    moved = relations.updated("top", stack.clouds["top"] + np.array([0.0, 0.2, -0.0802]))
    assert moved.between("top", "low").relation is Relation.DISJOINT


def test_support_features_are_a_rule_too(stack: Scene) -> None:
    relations = relate(stack, rule="features")
    assert relations.between("top", "low").relation is Relation.TOUCH
    assert relations.between("low", "table").relation is Relation.TOUCH
    assert relations.between("top", "table").relation is Relation.DISJOINT
    assert relations.between("top", "low").reason == "support features"


def test_a_support_tree_takes_the_highest_level_first(stack: Scene) -> None:
    tree = ORDERERS["support-tree"]
    everything = tree(stack, stack.movable, seed=0)
    assert everything.order[0] == "top" and set(everything.order) == {"low", "top", "apart"}
    assert everything.explanation[0] == "top is on level 2 of the support tree"
    assert tree(stack, ["low"], seed=0).order == ("top", "low")
    assert tree(stack, ["apart"], seed=0).order == ("apart",)
