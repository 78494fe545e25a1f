"""Build orders of real arrangements: what is under first, what falls held."""

import numpy as np
import pytest
from on_table import balance, cards, on_table

from topple.planner import build_order
from topple.planner.building.build import Footing
from topple.robots.shapes import box
from topple.topology import InvalidInput


def test_what_carries_is_put_down_before_what_it_carries():
    found = build_order(
        on_table((box("lamp", (0.06, 0.06, 0.1)), (0, 0, 0.04)), (box("book", (0.12, 0.1, 0.04)), (0, 0, 0)))
    )
    assert found.order == ("book", "lamp")
    assert not found.holds
    (edge,) = found.graph.dependencies
    assert isinstance(edge, Footing)
    assert (edge.first, edge.then, edge.reason) == ("book", "lamp", "supported")
    assert edge.sentence().startswith("book before lamp: lamp rests on book")
    assert {frozenset((each.a, each.b)) for each in edge.evidence} == {frozenset(("book", "lamp"))}


def test_a_counterweight_comes_after_its_plank_which_is_held_until_then():
    found = build_order(balance())
    assert found.order == ("pier", "plank", "weight")
    (hold,) = found.holds
    assert (hold.object, hold.since, hold.until) == ("plank", "plank", "weight")
    assert found.proven
    assert "plank is balanced by weight" in hold.because
    assert hold.evidence


def test_a_plank_that_stands_alone_is_held_only_while_its_first_load_would_tip_it():
    found = build_order(
        on_table(
            (box("pier", (0.05, 0.1, 0.1)), (0.0, 0.0, 0.0)),
            (box("plank", (0.3, 0.06, 0.02)), (0.0, 0.0, 0.1)),
            (box("left", (0.04, 0.05, 0.1)), (-0.12, 0.0, 0.12)),
            (box("right", (0.04, 0.05, 0.1)), (0.12, 0.0, 0.12)),
        )
    )
    assert found.order[:2] == ("pier", "plank")
    (hold,) = found.holds
    assert hold.object in {"plank", found.order[2]}
    assert (hold.since, hold.until) == found.order[2:]


def test_two_boards_that_lean_on_each_other_take_one_hold():
    found = build_order(cards())
    (hold,) = found.holds
    assert (hold.object, hold.until) == found.order


def test_the_command_prints_what_python_gives(tmp_path, typed):
    scene = balance()
    path = tmp_path / "goal.npz"
    clouds = dict(scene.clouds)
    np.savez(path, up=[0, 0, 1], fixed=["table"], **clouds)  # type: ignore[arg-type]
    document = typed("order", path, "--build", "--json", code=1).document
    assert document["build"] is True
    assert document["order"] == ["pier", "plank", "weight"]
    assert [(hold["object"], hold["until"]) for hold in document["holds"]] == [("plank", "weight")]
    assert document["format"] == "topple.order"
    assert all(each["evidence"] for each in document["dependencies"])
    printed = typed("order", path, "--build", code=1)
    assert "Hold plank until weight is down" in printed.out
    assert "one hand cannot do it: plank has to be held until weight is there" in printed.err


def test_a_build_order_is_of_everything(typed):
    assert "leave --target" in typed("order", "x.npz", "--build", "--target", "plank", code=2).err


def test_nothing_to_build_is_refused():
    with pytest.raises(InvalidInput, match="nothing in the scene can move"):
        build_order(on_table())


def test_what_would_tip_though_all_of_it_is_given_is_said_to_need_something_more():
    tipping = on_table(
        (box("a", (0.05, 0.05, 0.05)), (0.0, 0.0, 0.0)), (box("b", (0.2, 0.05, 0.02)), (0.08, 0.0, 0.05))
    )
    said = [line for line in build_order(tipping).assumptions if "would not stand on what it touches" in line]
    assert [line.split()[0] for line in said] == ["b"]
    steady = on_table(
        (box("a", (0.05, 0.05, 0.05)), (0.0, 0.0, 0.0)), (box("b", (0.2, 0.05, 0.02)), (0.0, 0.0, 0.05))
    )
    assert not any("would not stand" in line for line in build_order(steady).assumptions)
