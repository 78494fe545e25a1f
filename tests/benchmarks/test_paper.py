"""The paper's scenes: what is listed, that bodies settle to it, and that answers become rows."""

from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from topple.benchmarks.contrasts.features import support_features
from topple.benchmarks.paper import truth
from topple.benchmarks.paper.case import Outcome, Task, judged, solve
from topple.benchmarks.paper.columns import BOXES, ESTIMATED, LENIENT, NINE, PLAIN, SUPPORT, TOPPLE, boxes
from topple.benchmarks.paper.layouts import LAYOUTS
from topple.benchmarks.paper.stage import APART, CONTACT, FLOOR, gap, staged
from topple.benchmarks.paper.summary import report
from topple.benchmarks.paper.things import Things
from topple.robots.scenarios.scenario import Unlucky
from topple.robots.world.bodies import Body
from topple.topology.io import load_scene
from topple.topology.scene.scene import Scene
from topple.topology.sixim.table import Relation

TRIED = 3_000  # a family of variants of the tests' own


def _box(lower: tuple[float, ...], upper: tuple[float, ...], count: int = 3000) -> np.ndarray:
    """Points on the surface of a box."""
    rng = np.random.default_rng(0)
    points = rng.uniform(lower, upper, (count, 3))
    axis, side = rng.integers(0, 3, count), rng.integers(0, 2, count)
    points[np.arange(count), axis] = np.where(side == 1, np.array(upper)[axis], np.array(lower)[axis])
    return points


@pytest.fixture(scope="module")
def outcomes(tmp_path_factory: pytest.TempPathFactory) -> tuple[list[Outcome], Path]:
    folder = tmp_path_factory.mktemp("scenes")
    return solve(Task(1, 0, TRIED, Things(), folder=folder)), folder


def test_the_scenes_have_the_papers_pairs():
    pairs = {number: len(scene.pairs) for number, scene in truth.SCENES.items()}
    assert list(pairs.values()) == [6, 6, 6, 6, 6, 15, 10, 10, 10, 15, 10, 10, 10, 10]
    assert sum(pairs[n] for n in truth.RGBD) == 55 and sum(pairs[n] for n in truth.YCB) == 75
    assert sum(len(truth.SCENES[n].listed) for n in truth.YCB) == 31
    for scene in truth.SCENES.values():
        assert all({a, b} <= set(scene.objects) for a, _, b in scene.listed)
        assert {frozenset((a, b)) for a, _, b in scene.pairs} == {
            frozenset(pair) for pair in combinations(scene.objects, 2)
        }


@pytest.mark.parametrize(
    ("method", "rgbd", "ycb"),
    [(truth.PAPER_6IM, 53, 71), (truth.FEATURES, 41, 64), (truth.LEARNING, 40, 59), (truth.AABB, 36, 57)],
)
def test_the_papers_percentages_add_up_to_its_sums(method, rgbd, ycb):
    assert truth.published_right(method, truth.RGBD) == rgbd
    assert truth.published_right(method, truth.YCB) == ycb


@pytest.mark.parametrize("number", [3, 4, 5, 7, 9, 10])
def test_bodies_settle_to_the_listed_contacts(number):
    scene = truth.SCENES[number]
    with staged(number, 0, TRIED, Things(), LAYOUTS) as world:
        assert set(scene.objects) <= set(world.names)
        for a, relation, b in scene.pairs:
            if relation is Relation.DISJOINT:
                assert gap(world, a, b) >= (FLOOR if scene.ground in (a, b) else APART)
            else:
                assert gap(world, a, b) <= CONTACT


def test_a_variant_is_the_same_every_time_and_another_is_not():
    def poses(variant: int) -> np.ndarray:
        with staged(7, variant, TRIED, Things(), LAYOUTS) as world:
            return np.array(list(world.poses().values()))

    np.testing.assert_array_equal(poses(0), poses(0))
    assert np.abs(poses(0) - poses(1)).max() > 1e-3


def test_a_layout_without_the_listed_contacts_is_not_taken():
    from topple.benchmarks.paper.stage import check
    from topple.robots.shapes import box
    from topple.robots.world.world import World

    with World() as world:
        world.add_table("ground")
        for place, name in enumerate(truth.SCENES[1].objects[1:]):
            pose = np.eye(4)
            pose[0, 3] = 0.3 * place
            world.add(box(name), pose)
        with pytest.raises(Unlucky, match=r"do not touch|mm apart"):
            check(world, truth.SCENES[1])


def test_things_have_the_published_masses_and_stand_on_the_table():
    things = Things()
    for kind, mass in (("banana", 0.066), ("sugar_box", 0.514), ("plate", 0.279)):
        body: Body = things.make(kind)
        assert body.mass == pytest.approx(mass) and body.name == kind
        assert body.lower[2] == pytest.approx(0, abs=1e-9)


def test_what_is_not_in_the_folder_of_models_is_procedural(tmp_path):
    things = Things(tmp_path)
    assert "banana" in things.absent
    assert things.make("banana").kind == "banana"


def test_every_column_answers_every_pair(outcomes):
    found, _ = outcomes
    assert {one.column for one in found} == {TOPPLE, PLAIN, ESTIMATED, NINE, BOXES, SUPPORT}
    for one in found:
        assert len(one.pairs) == 6
        assert all(pair.said is not None for pair in one.pairs)
        assert one.seconds > 0


def test_a_written_scene_is_read_by_the_commands(outcomes):
    scene = load_scene(outcomes[1] / "scene_01.npz")
    assert set(scene.names) == set(truth.SCENES[1].objects)
    assert scene.fixed == {"ground"}
    assert scene.viewpoints.shape == (2, 3)


def test_outcomes_become_rows(outcomes):
    rows = [row.to_json() for row in report(outcomes[0], "not installed")]
    assert {"what", "value", "unit", "baseline", "baseline_value", "ratio", "bar", "ok"} <= set(rows[0])
    assert any(row["bar"] == ">= 54" for row in rows)
    assert any("not installed" in row["what"] for row in rows)
    scene = [row for row in rows if row["what"] == "scene 1: right of 6"]
    assert [row["column"] for row in scene] == [TOPPLE, PLAIN, ESTIMATED, NINE, BOXES, SUPPORT]
    assert scene[0]["baseline_value"] == 6


def test_an_answer_counts_from_either_side_and_the_unseen_is_wrong():
    listed = ("lemon", Relation.PARTIAL_WITHIN, "bowl")
    assert judged(listed, {("bowl", "lemon"): Relation.PARTIAL_CONTAIN}).right
    assert not judged(listed, {("bowl", "lemon"): Relation.CONTAIN}).right
    assert judged(listed, {("bowl", "lemon"): Relation.CONTAIN}, lenient=True).right
    unseen = judged(listed, {})
    assert not unseen.right and not unseen.claimed and unseen.is_contact
    assert SUPPORT in LENIENT


def test_boxes_and_features_know_a_box_on_a_box():
    clouds = {
        "low": _box((0, 0, 0), (0.1, 0.1, 0.1)),
        "top": _box((0.02, 0.02, 0.1), (0.08, 0.08, 0.15)),
        "apart": _box((0.3, 0, 0), (0.4, 0.1, 0.1)),
    }
    scene = Scene({**clouds, "table": _box((-0.1, -0.1, -0.02), (0.5, 0.2, 0.0), 8000)}, ["table"], (0, 0, 1))
    for answer in (boxes(scene), support_features(scene)):
        assert answer["low", "top"] is Relation.TOUCH
        assert answer["low", "apart"] is Relation.DISJOINT
        assert answer["top", "table"] is Relation.DISJOINT


@pytest.mark.slow
def test_contact_points_tell_touching_from_apart():
    pytest.importorskip("sklearn", reason="scikit-learn belongs to the bench extra")
    from topple.benchmarks.paper.learning import features, train

    up, low = np.array([0.0, 0.0, 1.0]), _box((0, 0, 0), (0.1, 0.1, 0.1), 600)
    examples = [
        (features(low, _box((0.01, 0.01, 0.1 + gap), (0.09, 0.09, 0.15 + gap), 600), up), relation)
        for gaps, relation in (((0.0, 0.0005, 0.001), "touch"), ((0.05, 0.06, 0.08), "disjoint"))
        for gap in gaps
    ]
    learned = train(examples)
    scene = Scene({"low": low, "top": _box((0.02, 0.02, 0.1), (0.08, 0.08, 0.15), 600)}, up=(0, 0, 1))
    assert learned(scene)["low", "top"] is Relation.TOUCH
