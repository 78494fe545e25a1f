"""Names for what a label's number alone names: colour and kind, said wherever people read."""

import numpy as np
import pytest

from topple.planner.decide.names import colour_word, spoken, spoken_names
from topple.planner.planning.plan import plan
from topple.planner.report.show import show_page


@pytest.mark.parametrize(
    ("colour", "word"),
    [
        ((250, 250, 245), "white"),
        ((20, 22, 21), "black"),
        ((120, 121, 119), "grey"),
        ((230, 210, 30), "yellow"),
        ((120, 90, 85), "brown"),
        ((200, 30, 30), "red"),
    ],
)
def test_colours_are_called_as_people_call_them(colour, word):
    assert colour_word(colour) == word


def test_a_number_gets_colour_and_kind_and_stays_beside_them(photographed):
    scene, _, order = photographed
    names = spoken_names(scene)
    assert set(names) == {"1", "2", "9"}
    assert names["1"].endswith(" box (1)") and names["9"] == "support (9)"
    page = show_page(scene, photographed[1], order)
    assert names["1"] in page and names["2"] in page
    assert names["1"] in str(order) and names["2"] in str(order)
    assert order.to_json()["order"] == sorted(order.order, key=order.order.index)
    assert not {*order.order} & {*names.values()}  # JSON keeps what the mask says


def test_scene_relations_and_plan_are_printed_with_names_and_written_with_numbers(photographed):
    scene, relations, _ = photographed
    one, two, support = (spoken_names(scene)[name] for name in "129")
    assert str(scene).startswith(f"2 objects: {one}, {two}\nfixed: {support}\n")
    assert f"\n{one}  touch  {support}  " in str(relations.with_relation("1", "9", "touch"))
    made = plan(scene, "free 1", "panda-suction", verify=False)
    heading, _, step = str(made).splitlines()
    assert heading.startswith(f"free {one}, 1 step, ") and step.startswith(f"1  free  {one}  nothing ")
    again = type(made).from_json(made.to_json())
    assert again == made and again.order == ["1"] and one not in str(again)


def test_sentences_name_objects_and_leave_counts_and_measures(photographed):
    scene = photographed[0]
    one, two = (spoken_names(scene)[name] for name in "12")
    said = spoken(scene, ["1 rests on 2", "taking 2 might move it (0.12)", "2 of 2 boxes, 1 mm and 2.5 N"])
    assert said == [
        f"{one} rests on {two}",
        f"taking {two} might move it (0.12)",
        "2 of 2 boxes, 1 mm and 2.5 N",
    ]
    assert spoken(scene, {"1": ("2", 1)}) == {one: (two, 1)}


def test_a_scene_is_renamed_whole(photographed):
    scene = photographed[0]
    said, names = spoken(scene, scene), spoken_names(scene)
    assert said.names == tuple(names[name] for name in scene.names) and said.fixed == {names["9"]}
    assert all(np.array_equal(said.clouds[names[name]], cloud) for name, cloud in scene.clouds.items())
    assert said.images[0].name_of(1) == names["1"]
