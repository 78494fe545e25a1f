"""Names of masks that were swapped and masks in pieces are told from things that moved or came to light."""

import numpy as np
from on_table import on_table

from topple.planner.execution.masks import name_faults, rename
from topple.robots.shapes import box
from topple.robots.shapes.fruit import lemon
from topple.robots.shapes.tableware import bowl, plate
from topple.topology.scene.scene import Scene
from topple.topology.views.image import DepthImage

TALL, FLAT = box("tall", (0.05, 0.06, 0.12)), box("flat", (0.12, 0.10, 0.04))
BEFORE = on_table((TALL, (0.0, 0.0, 0.0)), (FLAT, (0.0, 0.2, 0.0)))


def test_two_that_have_each_others_names_get_their_own_back():
    tall, flat = BEFORE.clouds["tall"], BEFORE.clouds["flat"]
    names, said = name_faults(BEFORE.with_cloud("tall", flat).with_cloud("flat", tall), BEFORE)
    assert names == {"tall": "flat", "flat": "tall"}
    assert said["flat"] == "the mask of flat was named tall: names are swapped"


def test_things_that_moved_keep_their_names():
    for way in ([0.0, 0.2, 0.0], [0.05, 0.03, 0.0]):
        after = BEFORE
        for name in BEFORE.movable:
            after = after.with_cloud(name, after.clouds[name] + np.array(way))
        assert name_faults(after, BEFORE) == ({}, {})


def test_a_piece_of_a_mask_belongs_to_the_whole():
    cloud = BEFORE.clouds["flat"]
    right = cloud[:, 0] > 0.01
    after = BEFORE.with_cloud("flat", cloud[~right]).with_cloud("flat_piece", cloud[right])
    names, said = name_faults(after, BEFORE)
    assert names == {"flat_piece": "flat"}
    assert said == {"flat": "the mask of flat is split: flat_piece is a piece of it"}


def test_a_piece_with_a_top_that_was_hidden_belongs_to_the_whole():
    cloud = BEFORE.clouds["flat"][BEFORE.clouds["flat"][:, 2] > 0.002]  # nobody sees what it stands on
    under = (np.abs(cloud[:, :2] - [0.0, 0.2]) < [0.058, 0.048]).all(axis=1) & (cloud[:, 2] > 0.039)
    before = BEFORE.with_cloud("flat", cloud[~under])  # something stood there
    right = cloud[:, 0] > 0.01
    after = BEFORE.with_cloud("flat", cloud[~right]).with_cloud("flat_piece", cloud[right])
    assert name_faults(after, before)[0] == {"flat_piece": "flat"}


def test_what_comes_to_light_in_a_bowl_or_flat_under_what_was_taken_is_no_piece():
    vessel = bowl("bowl").surface(4000, np.random.default_rng(1))
    fruit = lemon("lemon").surface(2000, np.random.default_rng(2)) + np.array([0.0, 0.0, 0.012])
    before = Scene({"bowl": vessel, "table": BEFORE.clouds["table"]}, fixed=["table"], up=[0, 0, 1])
    assert name_faults(before.with_cloud("lemon", fruit), before) == ({}, {})
    dish = plate("plate").surface(4000, np.random.default_rng(1))
    lid = box("lid", (0.245, 0.245, 0.003)).surface(2000, np.random.default_rng(2))
    before = Scene({"plate": dish, "table": BEFORE.clouds["table"]}, fixed=["table"], up=[0, 0, 1])
    lying = before.with_cloud("lid", lid + np.array([0.0, 0.0, dish[:, 2].max()]))
    assert name_faults(lying, before) == ({}, {})
    card = box("card", (0.10, 0.08, 0.002)).surface(2000, np.random.default_rng(5))
    card = card + np.array([0.0, 0.2, 0.04])
    cloud = BEFORE.clouds["flat"]
    under = (np.abs(cloud[:, :2] - [0.0, 0.2]) < [0.05, 0.04]).all(axis=1) & (cloud[:, 2] > 0.039)
    before = BEFORE.with_cloud("flat", cloud[~under])
    assert name_faults(before.with_cloud("card", card), before) == ({}, {})


def test_a_thing_that_comes_to_light_is_no_piece():
    late = box("late", (0.08, 0.06, 0.01)).surface(2000, np.random.default_rng(5))
    beside, on_top = np.array([0.15, 0.0, 0.0]), np.array([0.0, 0.2, 0.04])
    for place in (beside, on_top):
        after = BEFORE.with_cloud("late", late + place)
        if place is on_top:  # where it lies nothing of the other was ever seen
            below = BEFORE.clouds["flat"]
            under = (np.abs(below[:, :2] - place[:2]) < [0.04, 0.03]).all(axis=1) & (below[:, 2] > 0.039)
            before = BEFORE.with_cloud("flat", below[~under])
            assert name_faults(after.with_cloud("flat", below[~under]), before) == ({}, {})
        else:
            assert name_faults(after, BEFORE) == ({}, {})


def test_masks_that_come_to_share_a_name_are_one():
    label, K = np.array([[1, 1, 2, 3]]), np.array([[4.0, 0.0, 1.5], [0.0, 4.0, 0.0], [0.0, 0.0, 1.0]])
    image = DepthImage(np.ones((1, 4)), K, label, names={1: "a", 2: "b", 3: "c"})
    joined = rename(image, {"b": "a", "c": "b"})
    assert joined.names == {1: "a", 3: "b"}
    assert joined.label.tolist() == [[1, 1, 1, 3]]


def test_the_same_scene_is_named_as_it_was():
    scene: Scene = BEFORE
    assert name_faults(scene, scene) == ({}, {})
