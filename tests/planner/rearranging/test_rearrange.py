"""From one scene to another: what goes first, what makes room, and why."""

import pytest
from on_table import on_table

from topple.planner import rearrange
from topple.planner.cli.main import main
from topple.planner.rearranging.problem import Move, To
from topple.planner.rearranging.rearrange import Rearrangement
from topple.robots.shapes import bowl, box, plate
from topple.topology import InvalidInput, Scene


def blocks(**places: tuple[float, float, float]) -> Scene:
    return on_table(*((box(name, (0.05, 0.05, 0.05)), place) for name, place in places.items()), points=1500)


def told(found: Rearrangement) -> list[tuple[str, bool]]:
    return [(move.object, move.to is To.BUFFER) for move in found.moves]


def test_two_things_change_places_by_way_of_one_buffer():
    found = rearrange(blocks(a=(0, 0, 0), b=(0.2, 0, 0)), blocks(a=(0.2, 0, 0), b=(0, 0, 0)))
    assert told(found) in (
        [("a", True), ("b", False), ("a", False)],
        [("b", True), ("a", False), ("b", False)],
    )
    assert found.optimal
    assert {(place.first, place.then) for place in found.places} == {("a", "b"), ("b", "a")}
    assert all(
        each.swept and each.relation != "disjoint" for place in found.places for each in place.evidence
    )


def test_a_tower_comes_to_stand_elsewhere_in_another_order():
    start = blocks(red=(0, 0, 0), green=(0, 0, 0.05), blue=(0, 0, 0.1))
    goal = blocks(red=(0.2, 0, 0), green=(0.2, 0, 0.1), blue=(0.2, 0, 0.05))
    found = rearrange(start, goal)
    assert told(found) == [("blue", True), ("green", True), ("red", False), ("blue", False), ("green", False)]
    assert found.optimal
    assert "blue rests on green" in found.explanation[0]
    assert "red before blue: blue rests on red" in found.explanation[2]


def test_a_tower_upside_down_needs_no_buffer_beside():
    start = blocks(red=(0, 0, 0), green=(0, 0, 0.05), blue=(0, 0, 0.1))
    goal = blocks(blue=(0.2, 0, 0), green=(0.2, 0, 0.05), red=(0.2, 0, 0.1))
    assert told(rearrange(start, goal)) == [("blue", False), ("green", False), ("red", False)]


def test_what_is_where_it_shall_be_stays_and_carries_what_comes():
    dishes = plate("plate", diameter=0.22), bowl("bowl", diameter=0.12)
    start = on_table((dishes[0], (0, 0, 0)), (dishes[1], (0.25, 0, 0)))
    goal = on_table((dishes[0], (0, 0, 0)), (dishes[1], (0, 0, 0.008)))
    assert rearrange(start, goal).moves == (Move("bowl", To.GOAL),)
    assert rearrange(goal, start).moves == (Move("bowl", To.GOAL),)


def test_what_stays_makes_way_where_something_goes_under_it():
    start = blocks(top=(0, 0, 0.05), low=(0, 0, 0), new=(0.2, 0, 0))
    goal = blocks(top=(0, 0, 0.05), low=(0.2, 0, 0), new=(0, 0, 0))
    found = rearrange(start, goal)
    assert len(found.moves) == found.bound == 5
    assert ("top", True) in told(found)
    assert told(found)[-1] == ("top", False)


def test_other_things_are_refused():
    with pytest.raises(InvalidInput, match="b: not among what moves in the goal"):
        rearrange(blocks(a=(0, 0, 0), b=(0.2, 0, 0)), blocks(a=(0.2, 0, 0)))


def test_the_command_says_how_many_moves_and_why(tmp_path, typed):
    paths = [str(tmp_path / f"{name}.npz") for name in ("start", "goal")]
    for path, (a, b) in zip(paths, ((0.0, 0.2), (0.2, 0.0)), strict=True):
        blocks(a=(a, 0, 0), b=(b, 0, 0)).save(path)
    document = typed("order", paths[0], "--to", paths[1], "--json").document
    assert [move["buffer"] for move in document["moves"]] == [True, False, False]
    assert document["bound"] == 3 and document["optimal"]
    out = typed("order", paths[0], "--to", paths[1]).out
    assert "3 moves, 1 of them to make room; no sequence has fewer" in out
    assert main(["order", paths[0], "--to", paths[1], "--build"]) == 2
