import json
import pickle
from pathlib import Path

import numpy as np
import pytest

from topple.robots.shapes import plate
from topple.topology.io import load_scene
from topple.topology.relations.relate import relate
from topple.topology.relations.surface import SurfaceCloud, closest
from topple.topology.scene.scene import Scene
from topple.topology.sixim.confidence import Evidence, confidence
from topple.topology.sixim.table import Relation
from topple.topology.views.free_space import FreeSpace

SHARED = Path(__file__).resolve().parents[3].parent / "shared"
LINE = np.linspace([0, 0, 0], [0.1, 0, 0], 9)
UP = np.array([0.0, 0, 1])


def box(size, centre, count=3000, noise=0.0005, seed=0):
    rng = np.random.default_rng(seed)
    area = np.array([size[1] * size[2], size[0] * size[2], size[0] * size[1]])
    axis = rng.choice(3, count, p=area / area.sum())
    points = rng.uniform(-1, 1, (count, 3))
    points[np.arange(count), axis] = np.sign(points[np.arange(count), axis])
    return points * np.asarray(size) / 2 + centre + rng.normal(0, noise, (count, 3))


def ball(radius, centre, count=2000, noise=0.0005, seed=1):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(count, 3))
    points *= radius / np.linalg.norm(points, axis=1, keepdims=True)
    return points + centre + rng.normal(0, noise, (count, 3))


def bowl(radius=0.08, depth=0.05, count=6000, noise=0.0005, seed=2):
    rng = np.random.default_rng(seed)
    reach, turn = radius * np.sqrt(rng.random(count)), rng.uniform(0, 2 * np.pi, count)
    height = depth * (reach / radius) ** 2 + 0.003 * rng.integers(0, 2, count)
    return np.c_[reach * np.cos(turn), reach * np.sin(turn), height] + rng.normal(0, noise, (count, 3))


def table(count=8000, noise=0.0005, seed=3):
    rng = np.random.default_rng(seed)
    return np.c_[rng.uniform(-0.4, 0.4, (count, 2)), rng.normal(0, noise, count)]


def between(a, b, **options):
    return relate(Scene({"a": a, "b": b}, up=UP), **options).between("a", "b")


@pytest.mark.parametrize("noise", [0.0, 0.0005, 0.001])
def test_a_box_on_a_noisy_table_touches_it(noise):
    pair = between(box((0.06, 0.08, 0.1), [0, 0, 0.05], noise=noise), table(noise=noise))
    assert pair.relation is Relation.TOUCH
    assert abs(pair.gap) <= max(2 * noise, 1e-3)
    assert 0.6 <= pair.confidence < 1.0


def test_a_stray_point_changes_the_plain_relation_only():
    cloud = np.concatenate(
        [box((0.06, 0.08, 0.1), [0, 0, 0.066], noise=0.0), [[0.0, 0.0, 0.012], [0.02, 0.02, 0.0]]]
    )
    ground = box((0.3, 0.3, 0.02), [0, 0, 0.0], noise=0.0)
    scene = Scene({"cloud": cloud, "ground": ground})
    assert relate(scene, plain=True).pairs[0].relation is not Relation.DISJOINT
    assert relate(scene, deviation=0.002).pairs[0].relation is Relation.DISJOINT


def test_a_ball_below_the_rim_is_within_the_bowl():
    assert between(ball(0.015, [0, 0, 0.022]), bowl()).relation is Relation.WITHIN


def test_a_ball_that_sticks_out_is_partial_within_the_bowl():
    pair = between(ball(0.03, [0, 0, 0.036]), bowl())
    assert pair.relation is Relation.PARTIAL_WITHIN
    assert pair.converse.relation is Relation.PARTIAL_CONTAIN


def test_a_ball_in_the_bend_of_a_banana_is_not_contained():
    rng = np.random.default_rng(4)
    along, around = rng.uniform(np.pi / 6, np.pi * 5 / 6, 4000), rng.uniform(0, 2 * np.pi, 4000)
    reach = 0.08 + 0.018 * np.cos(around)
    banana = np.c_[reach * np.cos(along), reach * np.sin(along), 0.018 * (1 + np.sin(around))]
    assert between(ball(0.02, [0, 0.03, 0.02]), banana).relation is Relation.DISJOINT
    assert between(ball(0.02, [0, 0.042, 0.02]), banana).relation is Relation.TOUCH
    plain = between(ball(0.02, [0, 0.042, 0.02]), banana, plain=True).relation
    assert plain is Relation.PARTIAL_WITHIN


def test_nested_bowls_are_partial_within():
    assert between(bowl() + 0.012 * UP, bowl(seed=5)).relation is Relation.PARTIAL_WITHIN


@pytest.mark.parametrize("seed", range(8))
def test_nested_plates_are_partial_within_however_their_cells_begin(seed):
    body, rng = plate(diameter=0.258, height=0.024, well=0.014), np.random.default_rng(seed)
    lower, upper = (body.surface(10_000, rng) + rng.normal(0, 0.0003, (10_000, 3)) for _ in range(2))
    assert between(upper + 0.014 * UP, lower, deviation=0.004).relation is Relation.PARTIAL_WITHIN


def test_boxes_deep_in_each_other_cross_with_a_negative_gap():
    pair = between(box((0.1, 0.1, 0.1), [0, 0, 0]), box((0.1, 0.1, 0.1), [0.05, 0.05, 0.05], seed=6))
    assert pair.relation is Relation.CROSS
    assert pair.gap < -0.005


@pytest.mark.parametrize("gap", [0.0, 0.01, 0.04, 0.07])
def test_the_gap_is_the_distance_of_the_surfaces(gap):
    first, second = box((0.05, 0.05, 0.05), [0, 0, 0]), box((0.05, 0.05, 0.05), [0.05 + gap, 0, 0], seed=7)
    pair = between(first, second, deviation=0.003)
    assert pair.gap == pytest.approx(gap, abs=0.0025)
    assert pair.gap_exact


def test_a_gap_is_measured_only_where_its_bound_does_not_tell():
    first, second = box((0.05, 0.05, 0.05), [0, 0, 0]), box((0.05, 0.05, 0.05), [0.11, 0, 0], seed=7)
    pair = relate(Scene({"a": first, "b": second}), deviation=0.003).between("a", "b")
    assert pair.relation is Relation.DISJOINT
    assert not pair.within(0.05)
    assert "gap" not in vars(pair)
    assert pair.within(0.07)
    assert pair.least_gap <= pair.gap == pair.converse.gap == pickle.loads(pickle.dumps(pair)).gap
    assert pair.gap == pytest.approx(0.06, abs=0.0025)


def test_sparse_samples_of_a_plane_are_a_plane():
    grid = np.stack(np.meshgrid(np.linspace(-0.3, 0.3, 13), np.linspace(-0.3, 0.3, 13), [0.0]), -1).reshape(
        -1, 3
    )
    above = box((0.04, 0.04, 0.04), [0.013, 0.021, 0.031], noise=0.0)
    near = closest(SurfaceCloud.of("a", above), SurfaceCloud.of("b", grid))
    assert near.gap == pytest.approx(0.011, abs=1e-3)


def test_a_gap_no_camera_could_see_is_not_observed():
    overhead = np.array([[0.0, 0, 1.0]])
    lid = np.c_[np.random.default_rng(8).uniform(-0.1, 0.1, (4000, 2)), np.full(4000, 0.06)]
    ground = table()
    hidden = ground[(np.abs(ground[:, :2]) < 0.1).all(axis=1)]
    beside = np.array([[0.9, 0, 0.05]])
    for viewpoints, observed in ((overhead, False), (beside, True)):
        scene = Scene({"lid": lid, "ground": hidden}, up=UP, viewpoints=viewpoints)
        pair = relate(scene).between("lid", "ground")
        assert pair.relation is Relation.DISJOINT
        assert pair.observed is observed


def test_sight_ends_at_the_first_surface():
    wall = np.stack(np.meshgrid([0.5], np.linspace(-0.2, 0.2, 90), np.linspace(-0.2, 0.2, 90)), -1).reshape(
        -1, 3
    )
    sight = FreeSpace({"wall": wall}, np.zeros((1, 3)))
    assert sight.known
    assert sight.empty(np.array([[0.3, 0, 0], [0.7, 0, 0]])).tolist() == [True, False]


@pytest.mark.parametrize(
    "cloud", [np.zeros((1, 3)), np.zeros((40, 3)), np.linspace([0, 0, 0], [0.1, 0, 0], 9)]
)
def test_degenerate_clouds_relate_by_both_rules(cloud):
    for plain in (True, False):
        assert between(cloud, box((0.05, 0.05, 0.05), [0, 0, -0.025]), plain=plain).relation is Relation.TOUCH
        assert between(cloud, cloud + 0.5 * UP, plain=plain).relation is Relation.DISJOINT


@pytest.mark.skipif(not (SHARED / "data/rgbd").is_dir(), reason="the RGB-D scenes are not beside the project")
@pytest.mark.parametrize("name", ["osd_test46", "ycbvideo_0000"])
def test_contacts_a_camera_shows_are_found_and_no_others(name):
    truth = json.loads((SHARED / f"data/rgbd/{name}.gt.json").read_text())
    scene = load_scene(SHARED / f"data/rgbd/{name}.npz", fixed=["1"] if "1" in truth["objects"] else [])
    relations = relate(scene)
    wanted = {frozenset((str(a), str(b))) for a, b, _ in truth["relations"]}
    doubtful = {frozenset((str(pair[0]), str(pair[1]))) for pair in truth["uncertain_pairs"]}
    touching = [p for p in relations.pairs if p.relation is not Relation.DISJOINT]
    known = set(map(str, truth["objects"]))  # a table that is found where none has a label is not annotated
    found = {frozenset((p.a, p.b)) for p in touching if {p.a, p.b} <= known}
    assert found - wanted - doubtful == set()
    assert len(found & wanted) >= 0.8 * len(wanted)


def test_what_lies_under_an_arch_is_not_in_it():
    rng = np.random.default_rng(4)
    angle, across = rng.uniform(0, np.pi, 6000), rng.uniform(-0.02, 0.02, 6000)
    arch = np.c_[0.1 * np.cos(angle), across, 0.1 * np.sin(angle)]
    under = rng.uniform([-0.05, -0.015, 0.02], [0.05, 0.015, 0.06], (3000, 3))
    scene = Scene({"arch": arch, "box": under}, up=(0, 0, 1))
    assert relate(scene).between("box", "arch").relation is Relation.DISJOINT


@pytest.mark.parametrize(("top", "expected"), [(0.058, Relation.WITHIN), (0.066, Relation.PARTIAL_WITHIN)])
def test_what_stays_below_the_rim_is_within_and_what_shows_above_it_partly(top, expected):
    rng = np.random.default_rng(5)
    turn, height = rng.uniform(0, 2 * np.pi, 9000), rng.uniform(0, 0.06, 9000)
    wall = np.c_[0.08 * np.cos(turn), 0.08 * np.sin(turn), height]
    disc = rng.uniform(-0.08, 0.08, (6000, 2))
    floor = np.c_[disc, np.zeros(6000)][np.linalg.norm(disc, axis=1) < 0.08]
    content = rng.uniform([-0.02, -0.02, 0.0005], [0.02, 0.02, top], (4000, 3))
    scene = Scene({"bowl": np.concatenate([wall, floor]), "content": content}, up=(0, 0, 1))
    assert relate(scene).between("content", "bowl").relation is expected


@pytest.mark.parametrize("gap", [0.0, 0.0012, 0.0019])
def test_a_touch_is_believed_as_others_with_such_a_gap_were_true(gap):
    axis = np.linspace(-0.2, 0.2, 81)
    ground = np.stack(np.meshgrid(axis, axis, [0.0]), -1).reshape(-1, 3)
    above = box((0.06, 0.06, 0.05), [0, 0, 0.025 + gap], noise=0.0)
    pair = between(above, ground, deviation=0.002)
    assert pair.relation is Relation.TOUCH
    assert pair.gap == pytest.approx(gap, abs=1e-9)
    assert pair.confidence == confidence(Evidence.TOUCH, 0, gap / 0.002)


def test_what_is_apart_is_believed_so_more_the_wider_its_gap():
    ground, sure = table(noise=0.0), list[float]()
    for gap in (0.003, 0.006, 0.02):
        above = box((0.06, 0.06, 0.05), [0, 0, 0.025 + gap], noise=0.0)
        pair = relate(Scene({"a": above, "b": ground}), deviation=0.002).between("a", "b")
        assert pair.relation is Relation.DISJOINT
        sure.append(pair.confidence)
    assert 0.5 < sure[0] <= sure[1] <= sure[2] <= 1.0
    assert sure[0] < sure[2]
