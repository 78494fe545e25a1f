"""Relations as a goal: things come to have them, and what cannot be is named."""

import json
from typing import Any

import numpy as np
import pytest
from on_table import on_table

from topple.planner import NoSafePlan, rearrange
from topple.planner.rearranging.related import arrange_by_relations
from topple.robots.shapes import bowl, box, lemon
from topple.topology import InvalidInput, Scene, UnknownObject, relate
from topple.topology.situation.situation import Situation


def blocks(**places: tuple[float, float, float]) -> Scene:
    return on_table(*((box(name, (0.05, 0.05, 0.05)), place) for name, place in places.items()), points=1500)


APART, STACKED = blocks(a=(0, 0, 0), b=(0.15, 0, 0)), blocks(a=(0, 0, 0), b=(0, 0, 0.05))


def document(*pairs: tuple[str, str, str]) -> dict[str, Any]:
    return {"relations": [{"a": a, "relation": relation, "b": b} for a, relation, b in pairs]}


def test_what_relate_wrote_of_a_tower_stacks_what_lies_apart_and_back():
    told, now = relate(STACKED).to_json(), Situation(APART)
    found = rearrange(APART, json.loads(json.dumps(told)))
    assert [move.object for move in found.moves] == ["b"]
    clouds = arrange_by_relations(told, now).situation.scene.clouds
    heights = {name: cloud[:, 2].min() for name, cloud in clouds.items()}
    assert heights["a"] == pytest.approx(0.0, abs=0.002) and heights["b"] == pytest.approx(0.05, abs=0.005)
    assert [move.object for move in rearrange(STACKED, relate(APART).to_json()).moves] == ["b"]
    assert rearrange(STACKED, told).moves == ()


@pytest.mark.slow
def test_what_shall_be_in_a_bowl_goes_there_from_either_side_of_the_pair():
    scene = on_table((bowl("bowl"), (0.0, 0.0, 0.0)), (lemon("lemon"), (0.2, 0.1, 0.0)))
    for pair in (("lemon", "within", "bowl"), ("bowl", "contain", "lemon")):
        told = document(pair, ("bowl", "touch", "table"))
        after = arrange_by_relations(told, Situation(scene)).situation.scene
        assert np.linalg.norm(after.clouds["lemon"].mean(axis=0)[:2]) < 0.06
        assert after.clouds["bowl"] is scene.clouds["bowl"]


@pytest.mark.parametrize(
    ("told", "error", "words"),
    [
        (document(("a", "touch", "cup")), UnknownObject, "cup"),
        (document(("a", "touch", "b")), InvalidInput, "a would rest on nothing"),
        (
            document(("a", "disjoint", "table"), ("a", "disjoint", "b")),
            InvalidInput,
            "a would rest on nothing",
        ),
        (document(), InvalidInput, "nothing that moves"),
        ({}, InvalidInput, "expected a 'topple.relations' document"),
        (
            document(("a", "touch", "table"), ("b", "touch", "table"), ("a", "touch", "b")),
            NoSafePlan,
            "a and b would be disjoint, not touch",
        ),
    ],
)
def test_relations_that_nothing_can_have_are_refused(told, error, words):
    with pytest.raises(error, match=words):
        rearrange(APART, told)


def test_words_are_a_goal_in_python_too():
    assert [move.object for move in rearrange(APART, "b on a").moves] == ["b"]
    with pytest.raises(InvalidInput, match="empty"):
        rearrange(APART, " ")


def test_the_command_takes_a_document_and_names_what_is_none(tmp_path, typed):
    start = tmp_path / "start.npz"
    np.savez(start, **APART.clouds, up=[0, 0, 1], fixed=["table"])
    goal = tmp_path / "goal.json"
    goal.write_text(json.dumps(relate(STACKED).to_json()), encoding="utf-8")
    assert "1 move" in typed("order", start, "--to", goal).out
    goal.write_text('{"order": []}', encoding="utf-8")
    for command in (["order"], ["plan", "--robot", "panda"]):
        for wrong, told in ((str(goal), "topple relate --json"), ("", "--to is empty")):
            assert told in typed(command[0], start, *command[1:], "--to", wrong, code=2).err
