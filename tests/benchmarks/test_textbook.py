"""Textbook scenes stand as they are drawn, and cups seal on what is flat."""

import pytest

import topple
from topple.benchmarks.textbook import FLAT, SCENES, box, scene_of, seals, trial
from topple.planner.grasp.suction import cup_shape
from topple.planner.stability.check import check
from topple.robots.catalog import robot
from topple.robots.collision.convex import hull_of
from topple.topology.scene.mesh import Mesh
from topple.topology.scene.scene import Scene


@pytest.mark.parametrize("name", SCENES)
def test_a_scene_stands_as_it_is_drawn_and_its_target_has_to_wait(name):
    parts, target = SCENES[name]
    drawn = {"table": box((120, 120, 2), 0, 0, -2), **parts}
    meshes = {key: Mesh(part / 100, hull_of(part)[1]) for key, part in drawn.items()}
    clouds = {key: mesh.vertices for key, mesh in meshes.items()}
    found = check(Scene(clouds, ["table"], (0, 0, 1), meshes=meshes), margins=False)
    assert found.stands, found.sentence()
    first, *_, last = topple.order(scene_of(parts, 0), [target]).order
    assert (first != target, last) == (True, target)


@pytest.mark.parametrize("name", FLAT)
def test_a_cup_seals_on_a_flat_thing_whatever_the_noise(name):
    cup = cup_shape(robot("panda-suction"))
    assert all([seals(name, seed, cup) for seed in range(8)])


@pytest.mark.slow
def test_a_cup_frees_the_lowest_disc_by_a_plan_that_verifies():
    assert trial("discs", "panda-suction", 0) == ""
