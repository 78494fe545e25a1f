"""Arrangements in words are worked out, with as little moved as they ask for."""

import numpy as np
import pytest
from on_table import on_table, table
from scipy.spatial.transform import Rotation

from topple.planner import NoSafePlan, rearrange
from topple.planner.budget import OutOfBudget
from topple.planner.rearranging.words import arrange_by_words, is_words
from topple.robots.scenarios.scenario import pose_at
from topple.robots.shapes import bowl, box, can, lemon, plate, spoon
from topple.robots.world.world import World
from topple.topology import InvalidInput, Scene, UnknownObject
from topple.topology.base.arrays import FloatArray
from topple.topology.geometry.rigid import move_points
from topple.topology.situation.situation import Situation

SCENE = on_table(
    (bowl("bowl"), (0.0, 0.0, 0.0)),
    (lemon("lemon"), (0.2, 0.1, 0.0)),
    (spoon("spoon"), (-0.1, -0.25, 0.0)),
    (can("can"), (0.0, 0.14, 0.0)),
)


def goal(words: str, scene: Scene = SCENE) -> Scene:
    return arrange_by_words(words, Situation(scene)).situation.scene


def shift(name: str, after: Scene) -> FloatArray:
    return after.clouds[name].mean(axis=0) - SCENE.clouds[name].mean(axis=0)


def test_what_is_told_is_laid_and_nothing_else_moves():
    after = goal("lemon within bowl")
    assert np.linalg.norm(after.clouds["lemon"].mean(axis=0)[:2]) < 0.06
    for name in ("bowl", "spoon", "can"):
        assert after.clouds[name] is SCENE.clouds[name]


def test_a_budget_that_runs_out_leaves_no_moves():
    with pytest.raises(OutOfBudget, match=r"the budget of 0\.001 s ran out"):
        rearrange(SCENE, "lemon within bowl", budget=0.001)


@pytest.mark.parametrize(
    ("side", "axis", "sign"),
    [("left of", 1, 1), ("right of", 1, -1), ("behind", 0, 1), ("in front of", 0, -1)],
)
def test_sides_are_those_of_who_looks_along_x(side, axis, sign):
    after = goal(f"spoon {side} bowl")
    inner = sign * after.clouds["spoon"][:, axis]
    outer = sign * after.clouds["bowl"][:, axis]
    assert inner.min() == pytest.approx(outer.max() + 0.04, abs=0.005)
    lengths = np.ptp(after.clouds["spoon"], axis=0)
    assert lengths[1 - axis] > 2 * lengths[axis]  # it lies along the bowl's side


def test_what_is_in_the_way_makes_room():
    after = goal("spoon left of bowl")
    assert np.linalg.norm(shift("can", after)) > 0.03
    assert after.clouds["lemon"] is SCENE.clouds["lemon"]


def test_a_tower_in_words_stands_on_what_stays():
    boxes = [(box(name, (0.05, 0.05, 0.05)), (0.15 * k, 0.0, 0.0)) for k, name in enumerate("abc")]
    scene = on_table(*boxes)
    after = goal("c on b on a", scene)
    heights = [after.clouds[name][:, 2].min() for name in "abc"]
    assert heights == pytest.approx([0.0, 0.05, 0.1], abs=0.005)
    assert after.clouds["a"] is scene.clouds["a"]


@pytest.mark.parametrize(
    ("words", "error", "told"),
    [
        ("cup left of bowl", UnknownObject, "cup"),
        ("lemon left of bowl, lemon within bowl", InvalidInput, "two places for lemon"),
        ("table left of bowl", InvalidInput, "table"),
        ("free bowl", InvalidInput, "free"),
        ("spoon left of can, can behind spoon", NoSafePlan, "circle"),
    ],
)
def test_words_that_describe_nothing_are_refused(words, error, told):
    with pytest.raises(error, match=told):
        goal(words)


def test_of_what_shall_be_within_it_counts_that_it_is_there():
    arrangement = arrange_by_words("lemon within bowl, spoon left of bowl", Situation(SCENE))
    assert set(arrangement.pose_free) == {"lemon"}
    told = arrangement.goal(SCENE)
    assert "lemon" not in told.poses and "spoon" in told.poses
    assert "lemon within bowl" in told.text
    turned = arrangement.in_frame(np.diag([-1.0, -1.0, 1.0, 1.0]), np.array([0.0, 0.0, 1.0]))
    assert turned.pose_free == arrangement.pose_free


@pytest.mark.slow
def test_a_hand_that_does_not_fit_around_it_puts_it_elsewhere_in_the_bowl():
    table = (
        (plate("plate"), (0.2, -0.15, 0.0)),
        (bowl("bowl"), (0.0, 0.0, 0.0)),
        (lemon("lemon"), (0.2, 0.12, 0.0)),
        (spoon("spoon"), (-0.1, -0.25, 0.0)),
    )
    scene = on_table(*table)
    words = "plate on table, bowl on plate, lemon within bowl, spoon left of plate"
    plan = rearrange(scene, words, "panda-suction")
    assert [(step.action, step.object) for step in plan.steps] == [
        ("place", "bowl"),
        ("place", "lemon"),
        ("place", "spoon"),
    ]
    assert plan.verify(scene).ok


def test_what_leans_on_the_rim_of_a_plate_is_not_on_it():
    dish, tin = plate("plate"), can("can")
    with World() as world:
        world.add_table()
        world.add(dish, pose_at(0.0, 0.0, 0.0))
        lying = pose_at(0.18, 0.0, 0.04)
        lying[:3, :3] = Rotation.from_euler("y", -1.2).as_matrix()
        world.add(tin, lying)
        world.settle(3.0)
        poses = world.poses()
    rng, clouds = np.random.default_rng(0), {"table": table(0.4)}
    clouds |= {body.name: move_points(body.surface(4000, rng), poses[body.name]) for body in (dish, tin)}
    leaning = Scene(clouds, fixed=["table"], up=[0, 0, 1])
    carriers = {each.supporter for each in Situation(leaning).supports if each.supported == "can"}
    assert carriers == {"table", "plate"} and 0.2 < poses["can"][2, 2] < 0.8
    (move,) = rearrange(leaning, "can on plate").moves
    assert (move.object, move.to) == ("can", "goal")
    laid = goal("can on plate", leaning)
    assert rearrange(laid, "can on plate").moves == ()


def test_a_path_is_no_words():
    assert is_words("cup left of plate") and is_words("lemon in bowl")
    assert not is_words("goal.npz") and not is_words("scenes/left")
    assert is_words(" and ".join(f"cup {k} left of plate {k}" for k in range(40)))  # too long for a path
