"""Relations are the one reading of the clouds: contacts, supports and dependencies follow them."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from topple.planner import order
from topple.planner.decide.dependency import dependencies
from topple.robots import scenario
from topple.robots.shapes import bowl, box, plate, spoon
from topple.topology import InvalidInput, Relation, Relations, Scene, UnknownObject, relate
from topple.topology.situation.situation import Situation
from topple.topology.statics.sweep import overlap

sys.path.insert(0, str(Path(__file__).parents[1]))
from made import pile, seen

PILES = Path(__file__).resolve().parents[3].parent / "shared" / "piles"


def _at(cloud: np.ndarray, x: float, y: float, z: float) -> np.ndarray:
    return cloud + np.array([x, y, z])


@pytest.fixture(scope="module")
def laid() -> Scene:
    """A spoon on a plate, a small box in a bowl, two boxes one on the other, 4 cm beside them a third one."""
    rng = np.random.default_rng(3)
    grid = np.stack(np.meshgrid(*[np.linspace(-0.5, 0.5, 126)] * 2, [0.0]), axis=-1).reshape(-1, 3)
    cube = box("cube", (0.06, 0.06, 0.06))
    return Scene(
        {
            "table": grid,
            "plate": plate().surface(6000, rng),
            "spoon": _at(spoon().surface(2500, rng), 0.0, 0.0, 0.012),
            "bowl": _at(bowl().surface(6000, rng), 0.3, 0.0, 0.0),
            "ball": _at(box("ball", (0.03, 0.03, 0.03)).surface(1500, rng), 0.3, 0.0, 0.022),
            "low": _at(cube.surface(4000, rng), 0.0, 0.3, 0.03),
            "top": _at(cube.surface(4000, rng), 0.0, 0.3, 0.09),
            "beside": _at(cube.surface(4000, rng), 0.1, 0.3, 0.03),
        },
        fixed=["table"],
        up=(0, 0, 1),
    )


def _agree(scene: Scene) -> int:
    """Hold every edge and support of a scene against its relations; the number that rest on a contact."""
    relations = relate(scene)
    situation = Situation(scene, relations)
    graph = dependencies(situation, direct=False)
    for contact in situation.contacts:
        assert relations.between(contact.a, contact.b).relation is not Relation.DISJOINT
    for support in situation.supports:
        pair = relations.between(support.supported, support.supporter)
        assert pair.relation is not Relation.DISJOINT
        inside = pair.relation in (Relation.WITHIN, Relation.PARTIAL_WITHIN)
        assert (support.kind == "contained") == inside
    lying = 0
    for edge in graph.dependencies:
        assert edge.evidence
        assert (edge.reason == "blocking") <= any(each.swept for each in edge.evidence)
        for each in edge.evidence:
            if not each.swept:
                lying += 1
                assert each.relation is relations.between(each.a, each.b).relation is not Relation.DISJOINT
            else:
                assert {each.a, each.b} == {edge.first, edge.then}
    return lying


def test_nothing_contradicts_the_relations(laid):
    assert _agree(laid) >= 3


@pytest.mark.slow
@pytest.mark.skipif(not PILES.is_dir(), reason="recorded piles are not here")
@pytest.mark.parametrize(
    "view", ["full", *(pytest.param(one, marks=pytest.mark.slow) for one in ("view1", "view3"))]
)
def test_nothing_contradicts_the_relations_of_recorded_piles(view):
    from topple.benchmarks.recorded import recorded_piles

    cameras = {"full": 0, "view1": 1, "view3": 3}[view]
    assert sum(_agree(case.scenes[cameras]) for case in recorded_piles(PILES)) > 40


def test_every_edge_says_what_it_rests_on(laid):
    found = order(laid).to_json()
    edges = {(edge["first"], edge["then"]): edge for edge in found["dependencies"]}
    assert {("spoon", "plate"), ("ball", "bowl"), ("top", "low")} <= set(edges)
    for (first, then), edge in edges.items():
        assert edge["evidence"], (first, then)
        for each in edge["evidence"]:
            assert set(each) == {"a", "b", "relation", "gap", "observed", "swept"}
    lying = [each for each in edges["top", "low"]["evidence"] if not each["swept"]]
    assert [(each["a"], each["b"], each["relation"], each["observed"]) for each in lying] == [
        ("top", "low", "touch", True)
    ]
    assert edges["ball", "bowl"]["reason"] == "contained"
    assert "within" in {each["relation"] for each in edges["ball", "bowl"]["evidence"]}
    assert any("(touch, 0." in line and "observed)" in line for line in found["explanation"])


def test_what_cameras_show_of_an_edge_is_told_by_the_pixel():
    with scenario("dishes", 0) as stage:
        images = [camera.look(stage.world, np.random.default_rng(0)) for camera in stage.cameras]
    scene = Scene.from_images(images, up=(0, 0, 1))
    edges = order(scene, "plate").to_json()["dependencies"]
    assert len(edges) >= 3
    for edge in edges:
        shown = [each for each in edge["evidence"] if "pixels" in each]
        assert shown, edge
        for each in shown:
            assert each["observed"]
            for camera, row, column in each["pixels"]:
                image = images[camera - 1]
                assert image.name_of(int(image.borders.owner[row, column])) in (each["a"], each["b"])


def test_an_overhang_that_only_a_hidden_side_has_is_inferred():
    pytest.importorskip("topple.benchmarks.chances", reason="the benches come with a checkout")
    from topple.benchmarks.chances import given
    from topple.benchmarks.truth.cases import training

    told: set[bool] = set()
    for each in training()[7:13]:
        scene = given(each, 1, True)
        situation = Situation(scene)
        swept = [e for edge in dependencies(situation).dependencies for e in edge.evidence if e.swept]
        clouds = situation.statics.upright.clouds
        assert all(e.observed == (overlap(clouds[e.b], clouds[e.a]) is not None) for e in swept)
        assert all(e.observed != str(e).endswith(", inferred") for e in swept)
        told |= {e.observed for e in swept}
    assert told == {True, False}


def test_what_a_lift_meets_is_a_relation_of_the_swept_body(laid):
    situation = Situation(laid)
    met = situation.swept("low", "top")
    assert met.swept and met.gap < -0.02
    assert met.relation in (Relation.CONTAIN, Relation.PARTIAL_CONTAIN)
    assert situation.swept("plate", "spoon").relation in (Relation.CONTAIN, Relation.PARTIAL_CONTAIN)
    assert situation.swept("low", "beside").relation is Relation.DISJOINT


def test_a_pair_called_disjoint_has_no_edge(laid):
    altered = relate(laid).with_relation("top", "low", "disjoint")
    for edge in order(laid, relations=altered).graph.dependencies:
        for each in edge.evidence:
            assert each.swept or {each.a, each.b} != {"top", "low"}
    assert not any({s.supporter, s.supported} == {"top", "low"} for s in Situation(laid, altered).supports)


def test_a_pair_called_touching_has_a_contact(laid):
    assert relate(laid).between("low", "beside").relation is Relation.DISJOINT
    altered = Situation(laid, relate(laid).with_relation("low", "beside", Relation.TOUCH))
    patches = [c for c in altered.contacts if {c.a, c.b} == {"low", "beside"}]
    assert len(patches) == 1
    assert patches[0].gaps.min() == pytest.approx(0.0, abs=1e-9)
    assert np.median(abs(patches[0].normals[:, 0])) > 0.9


@pytest.mark.slow
def test_another_programs_relations_order_a_scene(laid):
    told = {
        "format": "topple.relations",
        "relations": [
            {"a": p.a, "b": p.b, "relation": str(p.relation)} for p in relate(laid) if {p.a, p.b} != {"ball"}
        ],
    }
    read = Relations.from_json(json.loads(json.dumps(told)), laid)
    assert order(laid, relations=read).order == order(laid).order
    written = relate(laid).to_json()
    assert Relations.from_json(written, laid).to_json() == written
    for entry in told["relations"]:  # type: ignore[union-attr]
        if {entry["a"], entry["b"]} == {"top", "low"}:  # type: ignore[index]
            entry["relation"] = "disjoint"  # type: ignore[index]
    parted = Situation(laid, Relations.from_json(told, laid))
    assert not any({c.a, c.b} == {"top", "low"} for c in parted.contacts)


@pytest.mark.parametrize(
    ("change", "error", "words"),
    [
        (lambda d: d.update(format="topple.order"), InvalidInput, "no relations"),
        (lambda d: d.update(format_version=2), InvalidInput, "document of version 1"),
        (lambda d: d.update(relations={}), InvalidInput, "no relations"),
        (lambda d: d["relations"].append(dict(d["relations"][0])), InvalidInput, "told twice"),
        (lambda d: d["relations"][2].update(relation="near"), InvalidInput, "no relation: expected"),
        (lambda d: d["relations"][2].update(a="fork"), UnknownObject, "fork"),
        (lambda d: d["relations"][2].update(gap="wide"), InvalidInput, r"relations\[2\].gap"),
        (lambda d: d["relations"][2].update(matrix=[[1, 2], [3, 4]]), InvalidInput, r"relations\[2\].matrix"),
        (lambda d: d["relations"].append(7), InvalidInput, r"relations\[28\]: expected"),
    ],
)
def test_what_is_no_relations_is_refused(laid, change, error, words):
    document = relate(laid).to_json()
    change(document)
    with pytest.raises(error, match=words):
        Relations.from_json(document, laid)


def test_a_situation_works_everything_out_once(laid):
    situation = Situation.of(laid)
    assert Situation.of(situation) is situation
    assert situation.relations is situation.relations
    assert situation.statics is situation.statics
    assert situation.supports is situation.supports


def test_what_stays_is_completed_once_and_what_moves_keeps_its_body():
    rng = np.random.default_rng(3)
    before = Situation.of(seen(pile(rng), rng, 2))
    left, moving = before.movable[0], before.movable[1]
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = Rotation.from_euler("z", 0.4).as_matrix(), (0.3, 0.1, 0.0)
    whole = before.surfaces
    assert before.without(left).surfaces[moving] is whole[moving]
    after = before.moved([moving], pose)
    assert after.surfaces[left] is whole[left]
    turn, again = before.statics.upright.rotation, after.statics.upright.rotation
    there = (whole[moving] @ turn) @ pose[:3, :3].T + pose[:3, 3]
    np.testing.assert_allclose(after.surfaces[moving] @ again, there, atol=1e-9)
