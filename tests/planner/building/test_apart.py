"""What holds each other is taken apart with a second hand, and one hand is told what to hold."""

import json

import numpy as np
import pytest
from on_table import balance, cards, on_table

from topple.planner import NoSafePlan, order, plan
from topple.planner.cli.main import main
from topple.robots import scenario, scene_from_world
from topple.robots.shapes import box
from topple.topology import InvalidInput


def test_of_two_cards_one_is_held_while_the_other_is_taken():
    found = order(cards())
    assert found.groups == (found.order,)
    (hold,) = found.holds
    first, second = found.order
    assert (hold.object, hold.since, hold.until) == (second, first, second)
    assert found.proven
    assert hold.evidence
    assert f"hold {second} while {first} is taken: {second} leans on {first}" in found.explanation[0]


def test_a_plank_is_held_while_its_counterweight_is_taken():
    found = order(balance(), "plank", hands=2)
    assert found.order == ("weight", "plank")
    assert [(hold.object, hold.since, hold.until) for hold in found.holds] == [("plank", "weight", "plank")]
    assert found.unresolved == ()
    assert found.risk["weight"] < order(balance(), "plank").risk["weight"], "the plank is held"


def test_what_is_held_is_let_go_where_it_stands_by_itself():
    found = order(
        on_table(
            (box("pier", (0.05, 0.1, 0.1)), (0.0, 0.0, 0.0)),
            (box("plank", (0.3, 0.06, 0.02)), (0.0, 0.0, 0.1)),
            (box("left", (0.04, 0.05, 0.1)), (-0.12, 0.0, 0.12)),
            (box("right", (0.04, 0.05, 0.1)), (0.12, 0.0, 0.12)),
        )
    )
    (hold,) = found.holds
    assert set(found.order[:2]) == {"left", "right"}
    assert hold.object in {"plank", found.order[1]}
    assert (hold.since, hold.until) == found.order[:2]


def test_with_a_number_of_hands_each_step_is_asked_about_as_things_are_by_then():
    scene = on_table(
        (box("pier", (0.06, 0.12, 0.1)), (0.0, 0.0, 0.0)),
        (box("plank", (0.3, 0.12, 0.02)), (0.08, 0.0, 0.1)),
        (box("one", (0.05, 0.05, 0.06)), (-0.04, -0.03, 0.12)),
        (box("two", (0.05, 0.05, 0.06)), (-0.04, 0.03, 0.12)),
    ).weighed({"plank": 0.2, "one": 0.8, "two": 0.8})
    assert order(scene).groups == (), "either of the two weights is enough"
    found = order(scene, hands=1)
    (hold,) = found.holds
    assert (hold.object, hold.since, hold.until) == ("plank", found.order[1], "plank")
    assert {*found.order[:2]} == {"one", "two"}
    assert found.unresolved == ((found.order[1], "plank"),)


def test_one_hand_does_not_part_them_and_is_told_what_to_hold():
    found = order(cards(), hands=1)
    assert found.unresolved == found.groups
    (words,) = found.certificate
    assert "with more hands, hold " in words
    assert order(cards(), hands=2).certificate == ()
    with pytest.raises(NoSafePlan) as caught:
        plan(cards(), ["left"], "panda")
    assert any("with a second hand, hold " in line for line in caught.value.certificate)


def test_the_number_of_hands_is_checked():
    with pytest.raises(InvalidInput, match="hands is 0: expected"):
        order(cards(), hands=0)


def test_the_command_heeds_how_many_hands_there_are(tmp_path, capsys, typed):
    path = str(tmp_path / "cards.npz")
    np.savez(path, up=[0, 0, 1], fixed=["table"], **cards().clouds)  # type: ignore[arg-type]
    for more, code in (([], 1), (["--hands", "2"], 0), (["--hands", "1"], 1)):
        assert main(["order", path, "--json", *more]) == code
        printed = capsys.readouterr()
        document = json.loads(printed.out)
        (hold,) = document["holds"]
        assert [hold["since"], hold["object"]] == document["order"]
        assert bool(document["unresolved"]) == (more == ["--hands", "1"])
        assert ("with more hands, hold" in printed.err) == bool(document["unresolved"])
        assert ("one hand cannot do it (--hands N): " in printed.err) == (not more)
    assert main(["order", path]) == main(["order", path, "-o", str(tmp_path / "kept.jsonl")]) == 1
    assert "With a second hand, hold " in typed("order", path, "-o", tmp_path / "kept.jsonl", code=1).out
    assert "--hands" in typed("order", path, "--build", "--hands", "2", code=2).err


def test_a_bowl_that_a_can_leans_over_is_held_while_the_can_is_taken():
    with scenario("hold", 9) as stage:
        names = {number: name for name, number in stage.world.ids.items()}
        scene = scene_from_world(stage.world.client, names=names)
    found = order(scene, "bowl", hands=2)
    assert found.order == ("can", "bowl")
    assert [(hold.object, hold.since, hold.until) for hold in found.holds] == [("bowl", "can", "bowl")]
    assert order(scene, "bowl", hands=1).certificate


def test_what_a_fixture_keeps_still_takes_one_hand(tmp_path, capsys, typed):
    found = order(balance(), "plank", clamped="plank")
    assert found.order == ("weight", "plank") and not found.unresolved
    assert [(hold.object, hold.fixture) for hold in found.holds] == [("plank", True)]
    assert found.to_json()["holds"][0]["fixture"] is True
    scene = balance()
    place = tmp_path / "balance.npz"
    masses = json.dumps(dict(scene.masses))
    np.savez(place, **scene.clouds, up=[0, 0, 1], fixed=["table"], masses=masses)
    assert main(["order", str(place), "--target", "plank", "--hands", "1"]) == 1
    capsys.readouterr()
    out = typed("order", "--target", "plank", "--clamped", "plank", place).out
    assert "With the fixture, keep plank clamped while weight is taken" in out
    assert "unknown object 'shelf'" in typed("order", place, "--clamped", "shelf", code=2).err


def test_a_fixture_at_the_wrong_thing_helps_nothing_and_is_not_named():
    found = order(balance(), "plank", clamped=["weight", "table"])
    assert found.unresolved and [(hold.object, hold.fixture) for hold in found.holds] == [("plank", False)]
    clear = order(on_table((box("a", (0.05, 0.05, 0.05)), (0.0, 0.0, 0.0))), clamped="a")
    assert clear.order == ("a",) and not clear.holds
