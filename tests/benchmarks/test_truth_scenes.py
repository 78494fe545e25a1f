"""The scenes of the gate of truth: labels that physics gives, the pool, what cameras see, and jitter."""

import numpy as np
import pytest
from at_rest import at_rest, labelled

from topple.benchmarks.truth import gate, pool
from topple.benchmarks.truth.asked import FAR, LEFT, jittered
from topple.benchmarks.truth.cases import FEW, GATED, MANY, drawn, few
from topple.benchmarks.truth.oracle import labels_of
from topple.benchmarks.truth.views import VIEWS, seen
from topple.robots import shapes
from topple.robots.scenarios.scenario import pose_at
from topple.topology.base.errors import InvalidInput


def test_what_stands_on_what_is_lifted_has_to_go_first(stack):
    labels, relations = labelled(stack)
    assert labels["low"] == {"high": 1, "apart": 0}
    assert labels["high"] == {"low": 0, "apart": 0}
    assert relations["low", "high"] == "touch"
    assert relations["high", "table"] == relations["low", "apart"] == "disjoint"


def test_a_light_thing_under_a_heavy_bowl_lifts_it(stack):
    upside_down = np.diag([1.0, -1.0, -1.0, 1.0])
    upside_down[2, 3] = 0.0605
    over = at_rest(
        (shapes.box("cookie", (0.03, 0.03, 0.02)), pose_at(0, 0, 0)),
        (shapes.bowl("bowl", diameter=0.15), upside_down),
    )
    labels, _ = labelled(over)
    assert labels == {"cookie": {"bowl": 1}, "bowl": {"cookie": 0}}, "it falls back to where it stood"


def test_what_lies_in_a_bowl_is_in_it():
    full = at_rest(
        (shapes.bowl("bowl", diameter=0.18, height=0.07), pose_at(0, 0, 0)),
        (shapes.ball("ball", diameter=0.04), pose_at(0, 0, 0.02)),
    )
    labels, relations = labelled(full)
    assert relations["bowl", "ball"] == "contain"
    assert labels == {"bowl": {"ball": 1}, "ball": {"bowl": 0}}


def test_the_pool_has_every_kind_and_each_commit_draws_its_own():
    every = pool.pool()
    assert {scene.set for scene in every} == set(pool.SETS)
    assert len({scene.kind for scene in every if scene.set == "designed"}) == 8
    assert len({scene.kind for scene in every if scene.set == "built"}) == 3
    signs = [sign for scene in every for firsts in scene.labels.values() for sign in firsts.values()]
    assert 0.05 < signs.count(1) / len(signs) < 0.4
    assert signs.count(None) / len(signs) < 0.1
    one, other = ([scene.name for scene in drawn(commit)] for commit in ("a2ac90c", "abffd34"))
    assert one == [scene.name for scene in drawn("a2ac90c")]
    assert len(set(one)) == len(one) and abs(len(one) - min(MANY, len(every))) <= len(pool.SETS)
    assert len(every) <= MANY or one != other
    assert len(few()) == FEW * len(GATED)


def test_a_made_scene_is_packed_and_read_back(tmp_path):
    entries = [pool.made("designed", seed) for seed in (pool.FIRST_SEED + 5, pool.FIRST_SEED + 22)]
    path = tmp_path / "pool.npz"
    pool.pack([*entries, {"set": "built", "seed": 3, "failed": "nothing stands"}], path)
    scenes = pool.pool(path)
    assert [scene.seed for scene in scenes] == [entry["seed"] for entry in entries]
    for scene, entry in zip(scenes, entries, strict=True):
        assert [*scene.resting.poses] == entry["names"]
        assert {(a, b): word for a, b, word in entry["relations"]} == scene.relations
        with scene.resting.world() as world:
            assert labels_of(world, list(scene.labels)) == scene.labels, (
                "the same shapes give the same labels"
            )
    again = tmp_path / "again.npz"
    pool.pack(pool.entries_in(path), again)
    assert again.read_bytes() == path.read_bytes(), "what was packed grows by what is made later"
    with pytest.raises(InvalidInput, match="comes with a checkout"):
        pool.pool(tmp_path / "none.npz")


def test_cameras_see_what_whole_surfaces_have(stack):
    whole, one, three = (seen(stack, cameras, 0) for cameras in VIEWS.values())
    names = list(whole["names"])
    assert names == list(one["names"]) == [*stack.poses, "table"]
    high = whole[f"cloud_{names.index('high')}"]
    assert high[:, 2].min() == pytest.approx(0.05, abs=1e-3)
    assert high[:, 2].max() == pytest.approx(0.1, abs=1e-3)
    assert set(np.unique(one["label_0"])) == {0, 1, 2, 3, 4}
    assert sum(key.startswith("depth_") for key in three) == 3
    again, other = seen(stack, 1, 0), seen(stack, 1, 1)
    assert (again["depth_0"] == one["depth_0"]).all()
    assert (other["depth_0"] != one["depth_0"]).any()


@pytest.mark.parametrize("variant", gate.VARIANTS)
def test_jitter_changes_what_it_says_alone(variant, stack):
    whole, image = dict(seen(stack, 0, 0)), dict(seen(stack, 1, 0))
    clouds, frame = jittered(whole, variant), jittered(image, variant)
    before, after = whole["cloud_0"], clouds["cloud_0"]
    assert (frame["label_0"] == image["label_0"]).all()
    if variant == "half":
        assert 0.4 < len(after) / len(before) < 0.6
        assert 0.4 < (frame["depth_0"] > 0).sum() / (image["depth_0"] > 0).sum() < 0.6
    elif variant.startswith("noise"):
        assert np.std(after - before) == pytest.approx(2e-4, rel=0.1)
        assert ((frame["depth_0"] > 0) == (image["depth_0"] > 0)).all()
    elif variant == "offset":
        assert np.allclose(after - before, FAR)
        assert np.allclose(frame["pose_0"][:3, 3] - image["pose_0"][:3, 3], FAR)
    else:
        assert np.allclose(after[:, 2], before[:, 2])
        assert np.allclose(np.linalg.norm(after, axis=1), np.linalg.norm(before, axis=1))
        assert np.abs(after - before).max() > 0.005
        table = f"cloud_{len(whole['names']) - 1}"
        assert np.abs(clouds[table][:, :2]).max() < LEFT < np.abs(whole[table][:, :2]).max()
        lost = (image["depth_0"] > 0) & (frame["depth_0"] == 0)
        assert lost.any() and (image["label_0"][lost] == len(image["names"])).all()
        turn = frame["pose_0"][:3, :3] @ image["pose_0"][:3, :3].T
        assert turn @ before[0] == pytest.approx(after[0])
