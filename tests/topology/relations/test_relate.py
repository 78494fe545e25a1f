import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from topple.topology.base.errors import InvalidInput, UnknownObject
from topple.topology.geometry.broadphase import near_pairs
from topple.topology.relations.relate import relate, relate_all
from topple.topology.scene.scene import Scene
from topple.topology.sixim.table import Relation

sys.path.insert(0, str(Path(__file__).parents[1]))
from made import UP, Box, look, pile, seen, told


def box(rng, size, centre, count=300):
    points = rng.uniform(-1, 1, (count, 3))
    axis = rng.integers(0, 3, count)
    points[np.arange(count), axis] = np.sign(points[np.arange(count), axis])
    return points * np.asarray(size) / 2 + centre


def random_scene(seed, count=6):
    rng = np.random.default_rng(seed)
    clouds = {
        f"object {i}": box(rng, rng.uniform(0.02, 0.1, 3), rng.uniform(-0.1, 0.1, 3)) for i in range(count)
    }
    return Scene(clouds)


def standing_scene(rng):
    """Boxes on and above each other, of which a camera overhead sees the upper halves."""
    clouds = {"table": np.c_[rng.uniform(-0.3, 0.3, (3000, 2)), rng.normal(0, 0.0005, 3000)]}
    for number in range(5):
        size = rng.uniform(0.04, 0.08, 3)
        at = rng.uniform(-0.1, 0.1, 2)
        points = box(rng, size, [*at, size[2] / 2 + rng.choice([0.0, 0.05])], count=600)
        clouds[f"box {number}"] = points[points[:, 2] > points[:, 2].mean()]
    return Scene(clouds, fixed=["table"], up=[0, 0, 1], viewpoints=[[0.2, 0.1, 0.9]])


@given(st.integers(0, 10**6))
@settings(max_examples=8, deadline=None)
def test_the_broad_phase_changes_no_relation(seed):
    rng = np.random.default_rng(seed)
    scene = random_scene(seed)
    scene = Scene({name: cloud + rng.uniform(-0.3, 0.3, 3) for name, cloud in scene.clouds.items()})
    relations = relate(scene, deviation=0.002)
    prepared = dict(zip(relations.objects, relations.prepared, strict=True))
    assert len(relations.pairs) == 15
    for pair in relations.pairs:
        looked_at = relations.rule.relate(prepared[pair.a], prepared[pair.b])
        assert pair.relation is looked_at.relation
        assert pair.gap_exact or pair.gap <= looked_at.gap + 1e-9


@pytest.mark.parametrize("plain", [True, False])
@given(seed=st.integers(0, 10**6))
@settings(max_examples=8, deadline=None)
def test_relations_survive_a_rigid_motion_of_the_world(plain, seed):
    scene = random_scene(seed)
    turn = Rotation.random(random_state=seed).as_matrix()
    moved = Scene({name: cloud @ turn.T + [1.0, -2.0, 0.5] for name, cloud in scene.clouds.items()})
    before, after = (relate(each, deviation=0.002, plain=plain) for each in (scene, moved))
    assert [pair.relation for pair in before.pairs] == [pair.relation for pair in after.pairs]


@pytest.mark.parametrize("plain", [True, False])
@given(seed=st.integers(0, 10**6))
@settings(max_examples=8, deadline=None)
def test_relations_do_not_depend_on_the_order_of_objects_or_points(plain, seed):
    scene = random_scene(seed)
    rng = np.random.default_rng(seed)
    names = rng.permutation(scene.names).tolist()
    shuffled = Scene({name: rng.permutation(scene.clouds[name]) for name in names})
    before, after = (relate(each, deviation=0.002, plain=plain) for each in (scene, shuffled))
    assert len(before.pairs) == 15
    for pair in before.pairs:
        assert after.between(pair.a, pair.b).relation is pair.relation
        assert after.between(pair.b, pair.a).relation is pair.relation.converse


@pytest.mark.parametrize("plain", [True, False])
def test_an_update_equals_relating_the_new_scene(plain):
    scene = random_scene(7, count=10)
    moved = scene.clouds["object 3"] + [0.05, 0.02, 0.0]
    updated = relate(scene, deviation=0.002, plain=plain).updated("object 3", moved)
    fresh = relate(scene.with_cloud("object 3", moved), deviation=0.002, plain=plain)
    assert len(fresh.pairs) == 45
    for pair in fresh.pairs:
        other = updated.between(pair.a, pair.b)
        assert other.relation is pair.relation
        np.testing.assert_array_equal(other.matrix, pair.matrix)


def told_alike(seed: int) -> int:
    """How many pairs updated relations and those of the new scene were held against each other."""
    rng = np.random.default_rng(seed)
    scene = standing_scene(rng)
    relations, held = relate(scene), 0
    for _ in range(2):
        name = rng.choice(scene.movable)
        step = np.array([*rng.uniform(-0.05, 0.05, 2), rng.choice([0.0, 0.04, 0.15])])
        scene = scene.with_cloud(name, scene.clouds[name] + step)
        relations = relations.updated(name, scene.clouds[name])
        for pair in relate(scene, deviation=relations.deviation).pairs:
            other = relations.between(pair.a, pair.b)
            assert (other.relation, other.inferred) == (pair.relation, pair.inferred)
            assert (other.gap, other.gap_exact) == (pair.gap, pair.gap_exact)
            np.testing.assert_array_equal(other.matrix, pair.matrix)
            assert (other.observed, other.confidence) == (pair.observed, pair.confidence)
            held += 1
    return held


@pytest.mark.slow
@given(st.integers(0, 10**6))
@settings(max_examples=4, deadline=None, derandomize=True)
def test_an_update_infers_what_relating_the_new_scene_infers(seed):
    assert told_alike(seed) == 2 * 15


@pytest.mark.parametrize("seed", [79, 90])
def test_an_update_sees_that_an_object_hides_a_gap_between_others(seed):
    """Scenes in which one that moved comes between a camera and two that stay where they are."""
    assert told_alike(seed) == 2 * 15


def test_a_followed_frame_is_seen_by_its_own_images():
    """A hand that hides the gap between two boxes in the second frame, and is gone again in the third."""
    cube, eye = np.full(3, 0.06), np.array([0.0, -0.35, 0.7])
    boxes = {f"at {x}": Box(np.array([x, 0.0, 0.03]), cube, 0.0) for x in (-0.05, 0.05)}

    def frame(hand):
        image = look({**boxes, "hand": hand}, eye, np.random.default_rng(1))
        return Scene.from_images([image], fixed=["table"], up=UP)

    palm = np.array([0.035, 0.06, 0.02])
    aside, before = (Box(eye / 2 + [x, 0.0, 0.01], palm, 0.0) for x in (0.12, 0.0))
    frames = [frame(aside), frame(before), frame(aside)]
    relations = relate(frames[0])
    changed = 0
    for scene in frames[1:]:
        relations = relations.followed(scene)
        fresh = relate(scene, deviation=relations.deviation)
        earlier = {(p.a, p.b): p.observed for p in relate(frames[0])}
        changed += sum(earlier[pair.a, pair.b] != pair.observed for pair in fresh)
        assert told(relations) == told(fresh)
        for pair in fresh:
            assert relations.between(pair.a, pair.b).confidence == pair.confidence
    assert changed > 0


def test_a_frame_of_the_same_clouds_and_new_images_is_looked_at_again():
    rng = np.random.default_rng(7)
    boxes = pile(rng)
    scene = seen(boxes, rng, 1)
    blind = [replace(image, depth=np.zeros_like(image.depth)) for image in scene.images]
    later = Scene(scene.clouds, scene.fixed, scene.up, scene.viewpoints, blind)
    relations = relate(scene)
    assert told(relations.followed(later)) == told(relate(later, deviation=relations.deviation))
    assert told(relations.followed(later)) != told(relations)


def test_an_update_forgets_the_contact_that_held_an_object_in_its_old_place():
    scene = standing_scene(np.random.default_rng(0))
    relations = relate(scene)
    held = next(pair for pair in relations.pairs if pair.inferred)
    lifted = held.a if held.b in scene.fixed else held.b
    there = scene.clouds[lifted] + [0.0, 0.0, 0.2]
    assert not relations.updated(lifted, there).between(held.a, held.b).inferred
    again = relations.updated(lifted, there).updated(lifted, scene.clouds[lifted])
    assert again.between(held.a, held.b).inferred


def test_a_replaced_pair_is_seen_from_both_sides():
    relations = relate(random_scene(1), plain=True)
    pair = relations.between("object 2", "object 0")
    changed = relations.with_pair(
        type(pair)(pair.a, pair.b, Relation.WITHIN, pair.matrix, 0.0, inferred=True)
    )
    assert changed.between("object 2", "object 0").relation is Relation.WITHIN
    assert changed.between("object 0", "object 2").relation is Relation.CONTAIN
    assert changed.between("object 0", "object 2").inferred
    assert not relations.between("object 0", "object 2").inferred


def test_json_has_one_entry_for_each_unordered_pair():
    data = relate(random_scene(2), plain=True).to_json()
    assert data["format"] == "topple.relations"
    assert data["format_version"] == 1
    assert data["deviation"] == 0.002
    assert len(data["relations"]) == 15
    assert {"a", "b", "relation", "matrix", "gap", "gap_exact", "confidence", "observed"} <= set(
        data["relations"][0]
    )


def test_many_scenes_relate_like_one_by_one():
    scenes = [random_scene(seed) for seed in range(3)]
    together = relate_all(scenes, plain=True)
    for scene, relations in zip(scenes, together, strict=True):
        assert relations.to_json() == relate(scene, plain=True).to_json()


def test_unknown_names_are_refused_with_the_known_ones():
    relations = relate(random_scene(3), plain=True)
    with pytest.raises(UnknownObject, match="unknown object 'lemon': the scene has object 0"):
        relations.between("lemon", "object 0")
    with pytest.raises(InvalidInput, match="no relation to itself"):
        relations.between("object 0", "object 0")


@pytest.mark.parametrize("deviation", [0.0, -0.001, float("nan"), 5.0])
@pytest.mark.parametrize("plain", [True, False])
def test_a_deviation_that_is_no_sensible_length_is_refused(deviation, plain):
    with pytest.raises(InvalidInput, match="deviation"):
        relate(random_scene(4), deviation=deviation, plain=plain)


@given(st.integers(0, 10**6), st.integers(0, 40))
def test_sort_and_sweep_finds_the_pairs_that_all_pairs_would(seed, count):
    rng = np.random.default_rng(seed)
    lower = rng.uniform(0, 1, (count, 3))
    upper = lower + rng.uniform(0, 0.3, (count, 3))
    expected = [
        [i, j]
        for i in range(count)
        for j in range(i + 1, count)
        if (lower[i] <= upper[j] + 0.05).all() and (lower[j] <= upper[i] + 0.05).all()
    ]
    assert near_pairs(lower, upper, 0.05).tolist() == expected
