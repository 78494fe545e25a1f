"""A fixture keeps things where they stand until they are taken: in graphs, orders, plans and their checks."""

import json

import numpy as np
import pytest
from on_table import balance, on_table

from topple.planner import NoSafePlan, order, plan
from topple.planner.decide.dependency import dependencies, with_fixture
from topple.planner.planning.plan_format import Plan, plan_from_json, plan_to_json
from topple.robots.shapes import box
from topple.topology import UnknownObject
from topple.topology.situation.situation import Situation


@pytest.fixture(scope="module")
def clamped() -> Plan:
    return plan(balance(), "free plank", "panda", clamped="plank")


def edges(clamps: frozenset[str]) -> set[tuple[str, str]]:
    situation = Situation(balance())
    graph = with_fixture(dependencies(situation, direct=False), situation.statics, clamps)
    return {(edge.first, edge.then) for edge in graph.dependencies}


def test_what_is_clamped_falls_no_more_and_what_a_lift_meets_still_has_to_go():
    assert {("plank", "weight"), ("weight", "plank"), ("plank", "pier")} <= edges(frozenset())
    kept = edges(frozenset({"plank"}))
    assert ("plank", "weight") not in kept
    assert {("weight", "plank"), ("plank", "pier")} <= kept, "both are under what stands on them"
    assert edges(frozenset({"weight"})) >= {("plank", "weight")}, "it lets go of what is taken itself"


def test_what_stands_on_what_is_clamped_stays_with_it():
    scene = on_table(
        (box("pier", (0.06, 0.1, 0.1)), (0.0, 0.0, 0.0)),
        (box("plank", (0.3, 0.06, 0.02)), (0.11, 0.0, 0.1)),
        (box("weight", (0.05, 0.05, 0.06)), (-0.01, 0.0, 0.12)),
        (box("cup", (0.05, 0.05, 0.05)), (0.2, 0.0, 0.12)),
    ).weighed({"plank": 0.1, "weight": 2.0, "cup": 0.05})
    situation = Situation(scene)
    full = dependencies(situation, direct=False)
    assert full.between("cup", "weight") is not None
    kept = with_fixture(full, situation.statics, {"plank"})
    assert kept.between("cup", "weight") is None
    assert kept.between("cup", "plank") is not None


def test_a_step_carries_no_risk_of_what_is_clamped():
    with_it, without = order(balance(), "plank", clamped="plank"), order(balance(), "plank")
    assert with_it.order == ("weight", "plank") and not with_it.groups
    assert with_it.risk["weight"] < 0.1 < without.risk["weight"]


def test_a_plan_with_a_fixture_needs_no_second_hand(clamped):
    with pytest.raises(NoSafePlan, match="hold the one while the other goes"):
        plan(balance(), "free plank", "panda")
    assert clamped.order == ["weight", "plank"]
    assert clamped.clamped == ["plank"]
    assert "keep plank clamped while weight is taken" in clamped.steps[0].reason
    assert clamped.steps[1].reason.endswith("the fixture lets go once the hand holds it")
    assert "a fixture keeps plank where it stands until it is taken" in clamped.assumptions


def test_it_is_verified_with_its_fixture_and_refuted_without(clamped):
    document = json.loads(plan_to_json(clamped))
    found = plan_from_json(json.dumps(document)).verify(balance())
    assert found.ok
    assert found.allowed == ("a fixture keeps plank where it stands until it is taken",)
    document["clamped"] = ["weight"]
    failed = plan_from_json(json.dumps(document)).verify(balance()).failed
    assert "dependencies of the scene broken" in {each.name for each in failed}


def test_a_fixture_at_what_is_not_there_is_refused(clamped):
    for ask in (
        lambda: order(balance(), clamped="shelf"),
        lambda: plan(balance(), "free plank", "panda", clamped="shelf"),
    ):
        with pytest.raises(UnknownObject, match="shelf"):
            ask()
    document = json.loads(plan_to_json(clamped)) | {"clamped": ["shelf"]}
    with pytest.raises(Exception, match=r"clamped. has 'shelf'"):
        plan_from_json(json.dumps(document)).verify(balance())


@pytest.mark.slow
def test_the_command_takes_it(tmp_path, typed):
    scene, place, out = balance(), tmp_path / "balance.npz", tmp_path / "plan.json"
    masses = json.dumps(dict(scene.masses))
    np.savez(place, **scene.clouds, up=[0, 0, 1], fixed=["table"], masses=masses)
    asked = ["plan", str(place), "--target", "plank", "--verify", "-o", str(out)]
    assert "Allowed: a fixture keeps plank" in typed(*asked, "--clamped", "plank").out
    assert json.loads(out.read_text())["clamped"] == ["plank"]
