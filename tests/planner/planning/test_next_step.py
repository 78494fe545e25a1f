"""The next step in scenes of a few clouds: what goes next, why, and what follows once it is done."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from topple.planner.decide.arrange import Order, arrange
from topple.planner.decide.beliefs import Beliefs
from topple.planner.decide.dependency import Dependency, DependencyGraph
from topple.planner.decide.goal import Action, parse_goal
from topple.planner.errors import NoSafePlan
from topple.planner.fallbacks import Relaxation
from topple.planner.planning.follow import follow
from topple.planner.planning.next_step import StepChooser
from topple.planner.planning.order import cautious
from topple.planner.planning.step import Context, NextStep
from topple.robots.arm.arm import Station
from topple.robots.catalog import robot
from topple.robots.scenarios.scenario import pose_at
from topple.robots.shapes.boxes import box
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import UnknownObject
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation

PANDA = robot("panda")
STATION = Station(PANDA, pose_at(-0.5, 0.0, 0.0), np.asarray(PANDA.home))
SIDE = 0.05  # [m] of every block


def blocks(**places: tuple[float, float, float]) -> Scene:
    """Blocks on a table, each by the middle of its underside [m]."""
    axis = np.arange(-0.4, 0.4, 0.008)
    x, y = np.meshgrid(axis, axis)
    clouds: dict[str, FloatArray] = {"table": np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])}
    surface = box("block", (SIDE, SIDE, SIDE)).surface(2500, np.random.default_rng(0))
    clouds |= {name: surface + np.array(place) for name, place in places.items()}
    return Scene(clouds, fixed=["table"], up=(0, 0, 1))


ON = SIDE + 0.0005  # [m] height of what stands on a block
STACK = blocks(low=(0.0, 0.0, 0.0), top=(0.0, 0.0, ON), aside=(0.0, 0.2, 0.0))
APART = blocks(red=(0.0, 0.0, 0.0), green=(0.0, 0.2, 0.0), blue=(0.0, -0.2, 0.0))


def chooser(scene: Scene, goal: str, **known: Any) -> StepChooser:
    context = Context(STATION, **{"observed": True, **known})
    return StepChooser(Situation(scene), parse_goal(goal, scene), context)


def taken(step: NextStep | None) -> tuple[str, str]:
    """What the step takes, and what for."""
    return step.transfer.grasp.object, step.action


def test_what_stands_on_a_target_goes_first_and_says_why():
    step = chooser(STACK, "free low").choose()
    assert taken(step) == ("top", Action.REMOVE)
    assert step.reason.startswith("it has to go before low")
    assert step.order.order == ("top", "low")
    assert step.all_fallbacks == ()


def test_once_that_is_gone_the_target_is_freed_and_then_nothing_is_left():
    gone = blocks(low=(0.0, 0.0, 0.0), top=(-0.1, -0.25, 0.0), aside=(0.0, 0.2, 0.0))
    now = chooser(gone, "free low", done=[("top", Action.REMOVE)])
    assert now.unmet() == ("low is not free",)
    step = now.choose()
    assert taken(step) == ("low", Action.FREE)
    assert step is not None and step.reason == "nothing has to go before it"
    after = chooser(gone, "free low", done=[("top", Action.REMOVE), ("low", Action.FREE)])
    assert after.unmet() == ()
    assert after.choose() is None


def test_steps_are_done_until_nothing_is_left_or_there_would_be_too_many():
    step, done = chooser(APART, "free red").choose(), list[NextStep]()
    left = iter([step, step, step, None])
    assert not follow(left.__next__, done.append, 1) and done == [step]
    assert follow(left.__next__, done.append, 1) and done == [step, step]


def test_a_target_that_stands_on_another_one_is_freed_and_not_just_removed():
    assert taken(chooser(STACK, "free low and free top").choose()) == ("top", Action.FREE)


def test_what_is_wanted_and_seen_nowhere_is_said_at_once():
    goal = parse_goal("free top", STACK)
    with pytest.raises(NoSafePlan, match="top: seen nowhere any more"):
        StepChooser(Situation(STACK.without("top")), goal, Context(STATION)).choose()
    found = StepChooser(Situation(STACK.without("top")), goal, Context(STATION, [("top", Action.FREE)]))
    assert found.choose() is None, "it was freed: wherever it is now, nothing is missing"


def test_what_was_given_up_is_not_tried_and_the_reason_is_in_the_certificate():
    with pytest.raises(NoSafePlan) as caught:
        chooser(APART, "free red", given_up={"red": "it slipped twice"}).choose()
    assert any("red" in words and "it slipped twice" in words for words in caught.value.certificate)


def test_what_is_to_go_onto_another_thing_is_placed_there():
    step = chooser(APART, "red on blue").choose()
    assert taken(step) == ("red", Action.PLACE)
    assert step is not None and step.reason == "it goes on blue"
    moved = step.transfer.placement.pose_before_to_after @ np.append(APART.clouds["red"].mean(axis=0), 1.0)
    assert moved[:2] == pytest.approx(APART.clouds["blue"].mean(axis=0)[:2], abs=0.015)
    assert moved[2] == pytest.approx(1.5 * SIDE, abs=0.01)


@pytest.mark.slow
def test_a_tower_begins_below_and_goes_on_with_what_is_next():
    assert taken(chooser(APART, "red on green on blue").choose()) == ("green", Action.PLACE)
    begun = blocks(red=(0.0, 0.0, 0.0), green=(0.0, -0.2, ON), blue=(0.0, -0.2, 0.0))
    step = chooser(begun, "red on green on blue", done=[("green", Action.PLACE)]).choose()
    assert taken(step) == ("red", Action.PLACE)
    built = blocks(red=(0.0, -0.2, 2 * ON), green=(0.0, -0.2, ON), blue=(0.0, -0.2, 0.0))
    assert chooser(built, "red on green on blue").choose() is None


def test_what_stands_where_a_thing_shall_be_is_taken_away_first():
    scene = blocks(red=(0.0, 0.2, 0.0), blue=(0.0, 0.0, 0.0), other=(0.0, 0.0, ON))
    step = chooser(scene, "red on blue").choose()
    assert taken(step) == ("other", Action.REMOVE)


def test_what_stands_on_the_thing_to_be_placed_goes_first():
    scene = blocks(red=(0.0, 0.0, 0.0), other=(0.0, 0.0, ON), blue=(0.0, 0.2, 0.0))
    assert taken(chooser(scene, "red on blue").choose()) == ("other", Action.REMOVE)


def test_a_placement_is_made_again_only_where_a_look_shows_that_it_does_not_hold():
    done = [("red", Action.PLACE)]
    assert chooser(APART, "red on blue", done=done, observed=False).choose() is None
    assert chooser(APART, "red on blue", done=done).unmet() == ("red is not on blue",)
    assert taken(chooser(APART, "red on blue", done=done).choose()) == ("red", Action.PLACE)


def of_edges(*edges: tuple[str, str]) -> Any:
    """An orderer that knows the dependencies given, and takes all that is named in them."""

    def orderer(scene: Scene, targets: Sequence[str], **_: object) -> Order:
        graph = DependencyGraph(scene.movable, tuple(Dependency(a, b, "supported", 1.0) for a, b in edges))
        return arrange(graph, targets, {name: np.zeros(3) for name in scene.movable})

    return orderer


def test_a_cycle_that_an_orderer_leaves_open_ends_the_plan():
    def orderer(scene: Scene, targets: Sequence[str], **_: object) -> Order:
        return replace(of_edges(("green", "red"))(scene, targets), unresolved=(("red", "green"),))

    with pytest.raises(NoSafePlan, match="no safe order frees red") as caught:
        chooser(APART, "free red", orderer=orderer).choose()
    assert caught.value.certificate == ("cycle: red before green before red",)


def test_an_order_of_what_is_not_there_is_refused_by_name():
    def orderer(scene: Scene, targets: Sequence[str], **_: object) -> Order:
        names = (*scene.movable, "ghost")
        graph = DependencyGraph(names, (Dependency("ghost", targets[0], "supported", 1.0),))
        return arrange(graph, targets, {name: np.zeros(3) for name in names})

    with pytest.raises(UnknownObject, match="ghost"):
        chooser(APART, "free red", orderer=orderer).choose()


def test_an_orderers_first_that_waits_for_nobody_is_what_is_taken():
    step = chooser(APART, "free red", orderer=of_edges(("green", "red"), ("blue", "green"))).choose()
    assert taken(step) == ("blue", Action.REMOVE)
    assert step is not None and step.reason == "it has to go before green (rests on it)"


@pytest.mark.slow
def test_what_bars_the_hand_is_taken_away_once_and_only_once():
    scene = blocks(red=(0.0, 0.0, 0.0))
    wall = box("wall", (0.2, 0.03, 0.15)).surface(4000, np.random.default_rng(1))
    for name, side in (("left", 1), ("right", -1)):
        scene = scene.with_cloud(name, wall + np.array([0.0, 0.045 * side, 0.0]))
    step = chooser(scene, "free red").choose()
    gone = [("left", Action.REMOVE), ("right", Action.REMOVE)]
    assert taken(step) in gone
    assert step.all_fallbacks[0] is Relaxation.MAKE_ROOM
    assert step.reason.startswith("it is in the way to red (cannot move red")
    for known in ({"relaxations": ("look longer",)}, {"done": gone}):
        with pytest.raises(NoSafePlan, match="cannot move red"):
            chooser(scene, "free red", **known).choose()


@pytest.mark.slow
def test_a_box_seen_from_one_side_is_not_put_onto_its_open_side():
    rng = np.random.default_rng(0)
    side = np.array([0.05, 0.06, 0.1])
    faces = rng.uniform(0.0, 1.0, (2, 1500, 3))
    faces[0, :, 2] = 1.0  # the top
    faces[1, :, 0] = 0.0  # the side towards the camera
    seen = (faces.reshape(-1, 3) - [0.5, 0.5, 0.0]) * side
    grid = np.stack(np.meshgrid(np.arange(-0.6, 0.6, 0.008), np.arange(-0.6, 0.6, 0.008)), -1).reshape(-1, 2)
    behind = (grid[:, 0] > -0.03) & (grid[:, 0] < 0.1) & (np.abs(grid[:, 1]) < 0.03)
    table = np.column_stack([grid[~behind], np.zeros((~behind).sum())])
    scene = Scene({"box": seen, "table": table}, fixed=["table"], up=(0, 0, 1), viewpoints=[[-0.6, 0.0, 0.6]])
    station = Station(PANDA, pose_at(-0.5, 0.0, 0.0), np.asarray(PANDA.home))
    step = StepChooser(Situation(scene), parse_goal("free box", scene), Context(station)).choose()
    assert np.degrees(step.transfer.placement.tilt(np.array([0.0, 0.0, 1.0]))) < 10.0


def test_what_moved_as_a_target_was_lifted_goes_first():
    step = chooser(APART, "free red", beliefs=Beliefs(measured=frozenset([("green", "red")]))).choose()
    assert taken(step) == ("green", Action.REMOVE)
    assert step is not None and step.order.order == ("green", "red")
    assert step.reason == "it has to go before red (moved with it)"
    document = step.order.to_json()["dependencies"][0]
    assert document["measured"] is True and document["evidence"][0]["swept"] is True


def test_what_moved_goes_first_only_where_geometry_lets_it():
    against = Beliefs(measured=frozenset([("low", "top")]))
    step = chooser(STACK, "free low", beliefs=against, orderer=cautious).choose()
    assert taken(step) == ("top", Action.REMOVE)
    assert step is not None and step.order.order == ("top", "low") and not step.order.groups
