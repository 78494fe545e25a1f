"""Things of two scenes matched by shape."""

import numpy as np
import pytest
from on_table import on_table

from topple.planner import rearrange
from topple.planner.rearranging.matching import match_objects
from topple.robots.shapes import bowl, box, can, mug, spoon
from topple.topology import InvalidInput

UP = np.array([0.0, 0.0, 1.0])
KINDS = {"bowl": bowl, "can": can, "mug": mug, "spoon": spoon}
START = on_table(*((make(name), (0.2 * k - 0.3, 0.0, 0.0)) for k, (name, make) in enumerate(KINDS.items())))
GOAL = on_table(
    *((make(f"thing_{k}"), (0.1, 0.2 * k - 0.3, 0.0)) for k, make in enumerate(reversed(KINDS.values())))
)


def test_things_are_found_by_shape_whatever_they_are_called():
    goal, matches = match_objects(START, GOAL, UP)
    assert {each.object: each.goal for each in matches} == {
        "spoon": "thing_0", "mug": "thing_1", "can": "thing_2", "bowl": "thing_3",
    }  # fmt: skip
    assert all(0.0 < each.residual < 0.005 for each in matches)
    assert set(goal.movable) == set(KINDS) and goal.fixed == GOAL.fixed
    assert goal.clouds["mug"] is not None and np.array_equal(goal.clouds["mug"], GOAL.clouds["thing_1"])


@pytest.mark.slow
def test_the_moves_say_what_was_taken_for_what():
    with pytest.raises(InvalidInput, match="things match by name"):
        rearrange(START, GOAL)
    found = rearrange(START, GOAL, match="shape")
    assert {move.object for move in found.moves} == set(KINDS)
    assert any("mug is taken to be thing_1 of the goal" in said for said in found.assumptions)


@pytest.mark.slow
def test_things_of_one_shape_go_the_shorter_way():
    a, b = (box(name, (0.05, 0.05, 0.05)) for name in "ab")
    start = on_table((a, (0.0, 0.0, 0.0)), (b, (0.2, 0.0, 0.0)))
    goal = on_table((a, (0.2, 0.1, 0.0)), (b, (0.0, 0.1, 0.0)), points=2500)
    assert {each.object: each.goal for each in match_objects(start, goal, UP)[1]} == {"a": "b", "b": "a"}


def test_what_has_no_match_is_refused():
    one = on_table((bowl("bowl"), (0.0, 0.0, 0.0)))
    with pytest.raises(InvalidInput, match="shape of bowl"):
        match_objects(one, on_table((spoon("spoon"), (0.0, 0.0, 0.0))), UP)
    with pytest.raises(InvalidInput, match="1 things move at the start and 4"):
        match_objects(one, GOAL, UP)
    with pytest.raises(InvalidInput, match="match is 'colour'"):
        rearrange(START, GOAL, match="colour")
