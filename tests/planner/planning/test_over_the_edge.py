"""A plan pushes a book over the table's edge and pinches it there; spoilt pushes are refuted."""

from dataclasses import replace

import numpy as np
import pytest
from by_the_edge import by_the_edge
from on_table import BASE

from topple.planner.decide.goal import Action, parse_goal
from topple.planner.errors import NoSafePlan
from topple.planner.execution.demo import loop_in
from topple.planner.fallbacks import Fallback
from topple.planner.formats.plan_format import Plan, plan_from_json, plan_to_json
from topple.planner.grasp.hand import hand_shape
from topple.planner.placement.slides import Slide, slides
from topple.planner.planning.order import order
from topple.planner.planning.plan import plan, plan_as_done
from topple.planner.planning.step import NextStep, Station
from topple.planner.transfer.handling import Handling
from topple.planner.transfer.push import plan_push
from topple.planner.transfer.transfer import Transfer
from topple.planner.verify import verify
from topple.robots.catalog import robot
from topple.robots.scenarios import scenario_called
from topple.topology.arrays import FloatArray
from topple.topology.scene import Scene
from topple.topology.situation import Situation

PANDA = robot("panda")
ROUGH = 0.02  # [rad]
GOAL = "book on carton"


def pushed(scene: Scene, by: FloatArray, beside: FloatArray, without: tuple[str, ...] = ()) -> Plan:
    """A plan of one push that goes on by a way (3,), or begins beside where it should [m].

    Args:
        scene: What it is checked with.
        by: What the thing goes more.
        beside: Where the hand is more.
        without: What is left out as it is planned.
    """
    situation = Situation(scene).without(*without)
    way = slides("book", situation, hand_shape(PANDA))[0]
    pose, place = way.grasp.pose_tool_to_world.copy(), way.placement.pose_before_to_after.copy()
    pose[:3, 3] += beside
    place[:3, 3] += by
    spoilt = Slide(
        replace(way.grasp, pose_tool_to_world=pose),
        replace(way.placement, pose_before_to_after=place),
        way.ahead,
    )
    handling = Handling("book", situation, PANDA, BASE)
    found = plan_push(handling, [spoilt], np.asarray(PANDA.home))
    assert isinstance(found, Transfer), found
    step = NextStep(found, Action.REMOVE, "to be pinched", order(situation.scene, ["book"]))
    station = Station(PANDA, BASE, np.asarray(PANDA.home))
    return plan_as_done(scene, parse_goal(GOAL, scene), station, [step], 0)


@pytest.mark.slow
def test_a_book_is_pushed_over_the_edge_pinched_there_and_carried_away() -> None:
    scene = by_the_edge()
    found = plan_from_json(plan_to_json(plan(scene, GOAL, PANDA, base=BASE, check=False)))
    first, last = found.steps
    assert (first.action, first.grasp.kind, first.fallbacks) == (
        "remove",
        "push",
        [str(Fallback.TO_THE_EDGE)],
    )
    kinds = [segment.kind for segment in first.segments]
    assert kinds == ["move", "approach", "grasp", "slide", "release", "retreat"]
    assert (last.action, last.grasp.kind) == ("place", "pinch")
    assert found.certified
    checked = found.verify(scene)
    assert checked.ok, [(each.name, each.value, each.witness) for each in checked.failed]


@pytest.mark.slow
def test_a_book_that_has_nowhere_to_hang_over_stays() -> None:
    with pytest.raises(NoSafePlan, match="cannot move book: wider than the hand opens"):
        plan(by_the_edge(side=False), GOAL, PANDA, base=BASE)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("by", "beside", "barred", "refuted"),
    [
        ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), False, set[str]()),
        ((0.0, 0.05, 0.0), (0.0, 0.0, 0.0), False, {"shift of what is pushed", "shift after letting go"}),
        ((0.0, 0.0, 0.0), (0.08, 0.0, 0.0), False, {"turn of what is pushed", "grasps that hold nothing"}),
        ((0.0, 0.0, 0.0), (0.0, -0.03, 0.0), False, {"shift of what is pushed", "grasps that hold nothing"}),
        ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), True, {"collisions (python-fcl)", "disturbed by what is pushed"}),
    ],
    ids=["honest", "beyond its middle", "beside its middle", "behind it", "through a can"],
)
def test_a_push_is_checked_by_playing_it(
    by: tuple[float, ...], beside: tuple[float, ...], barred: bool, refuted: set[str]
) -> None:
    scene = by_the_edge(barred=barred)
    without = ("can",) if barred else ()
    found = pushed(scene, np.array(by), np.array(beside), without)
    failed = {each.name for each in verify(found, scene, PANDA, step=ROUGH).failed}
    assert refuted <= failed
    if not refuted:
        assert failed <= {"goal clauses unmet", "actions that the goal does not ask for"}


def test_where_there_is_no_way_that_is_said() -> None:
    handling = Handling("book", Situation(by_the_edge(side=False)), PANDA, BASE)
    found = plan_push(handling, [], np.asarray(PANDA.home))
    assert "no edge that it can be pushed over" in str(found)


@pytest.mark.slow
def test_an_arm_does_it_by_friction_alone() -> None:
    with scenario_called("edge", 503) as stage:
        record = loop_in(stage, seed=503).run()
    assert record.success, record.violations
    assert [step.fallbacks for step in record.steps] == [("to the edge",), ()]
