"""Goals that no bodies can have are refused, with what is wrong where."""

import numpy as np
import pytest
from on_table import on_table

from topple.planner import rearrange
from topple.planner.placement.resting import about
from topple.robots.shapes import bowl, box, can, lemon
from topple.topology import InvalidInput, Scene
from topple.topology.geometry.samples import sample

CUBE = (0.05, 0.05, 0.05)


def cubes(a: tuple[float, float, float], b: tuple[float, float, float]) -> Scene:
    return on_table((box("a", CUBE), a), (box("b", CUBE), b), points=1500)


START = cubes((0, 0, 0), (0.15, 0, 0))


def test_what_hangs_in_the_air_is_named_with_its_height():
    with pytest.raises(InvalidInput, match=r"a hangs in the air in the goal, its lowest point at 0\.200 m"):
        rearrange(START, cubes((0, 0, 0.2), (0.15, 0, 0)))


def test_what_is_in_each_other_is_named_and_what_lies_in_a_bowl_is_not():
    with pytest.raises(InvalidInput, match="a and b are in each other in the goal"):
        rearrange(START, cubes((0, 0, 0), (0.02, 0, 0)))
    fruit = (bowl("bowl"), (0.0, 0.0, 0.0)), (lemon("lemon"), (0.0, 0.0, 0.012))
    start = on_table(fruit[0], (fruit[1][0], (0.2, 0.1, 0.0)))
    assert [move.object for move in rearrange(start, on_table(*fruit)).moves] == ["lemon"]


def test_a_thing_of_the_same_name_and_another_shape_is_refused():
    other = on_table((box("a", CUBE), (0.0, 0.2, 0.0)), (can("b", diameter=0.03, height=0.15), (0.15, 0, 0)))
    with pytest.raises(InvalidInput, match=r"b has another shape in the goal: \d+ x \d+ x \d+ mm"):
        rearrange(START, other)


def test_a_square_turned_by_an_eighth_keeps_its_shape() -> None:
    plate = np.array([[x, y, z] for x in (-0.05, 0.05) for y in (-0.05, 0.05) for z in (0.0, 0.02)])
    start = on_table((box("a", CUBE), (0.2, 0.0, 0.0))).with_cloud("b", sample([plate], 0.004))
    turned = start.with_cloud("b", start.clouds["b"] @ about(np.array([0, 0, 1]), np.pi / 4).T)
    assert {rearrange(start, turned, match=how).moves[0].object for how in ("name", "shape")} == {"b"}


@pytest.mark.slow
def test_many_reasons_are_told_in_short():
    names = [f"block {k:02d}" for k in range(8)]
    flat = (0.06, 0.06, 0.03)

    def tower(order: list[str]) -> Scene:
        things = ((box(name, flat), (0.0, 0.0, 0.03 * k)) for k, name in enumerate(order))
        return on_table(*things, points=800)

    found = rearrange(tower(names), tower(names[::-1]))
    assert len(found.moves) == 16 and found.optimal
    assert "and 5 others go" in found.explanation[0]
    assert all(len(line) < 200 for line in found.explanation)
