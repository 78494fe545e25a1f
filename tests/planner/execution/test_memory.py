"""What a run remembers of where it put things, and by which grasp."""

import numpy as np
import pytest
from on_table import on_table

from topple.planner.decide.beliefs import Beliefs
from topple.planner.decide.goal import Action
from topple.planner.execution.memory import Memory
from topple.planner.grasp.grasp import Grasp
from topple.planner.placement.placement import Placement
from topple.planner.planning.order import cautious
from topple.planner.planning.step import Context, NextStep
from topple.planner.transfer.transfer import Transfer
from topple.robots.arm.arm import Station
from topple.robots.catalog import robot
from topple.robots.scenarios.scenario import pose_at
from topple.robots.shapes import box

SCENE = on_table((box("mug", (0.06, 0.06, 0.09)), (0, 0, 0)), (box("can", (0.06, 0.06, 0.1)), (0.2, 0, 0)))
ORDER = cautious(SCENE, ["mug"])
STATION = Station(robot("panda"), np.eye(4), np.asarray(robot("panda").home))


def step(action: Action, name: str = "mug", along: float = 0.1) -> NextStep:
    grasp = Grasp(name, "rim", pose_at(0.03, 0.0, 0.08), 0.004, 0.04, 0.5)
    placement = Placement(pose_at(along, 0.0, 0.0), 1.0)
    return NextStep(Transfer(name, grasp, placement, (), np.zeros(7), {}), action, "", ORDER)


def context(memory: Memory, most: int = 3) -> Context:
    return memory.context(Context(STATION, orderer=cautious), most)


def test_the_grasp_by_which_a_thing_was_put_down_goes_with_it():
    memory = Memory().after_action(step(Action.PLACE), True)
    (grasp,) = context(memory).placed["mug"]
    assert np.allclose(grasp.pose_tool_to_world[:3, 3], [0.13, 0.0, 0.08])
    first, second = context(memory.after_action(step(Action.PLACE, along=-0.1), True)).placed["mug"]
    assert np.allclose([first.pose_tool_to_world[0, 3], second.pose_tool_to_world[0, 3]], [0.03, -0.07])


def test_nothing_is_known_of_how_it_lies_once_it_made_room():
    memory = Memory().after_action(step(Action.PLACE), True).after_action(step(Action.PLACE, "can"), True)
    assert set(context(memory.after_action(step(Action.REMOVE), True)).placed) == {"can"}


@pytest.mark.parametrize(("success", "tries"), [(False, 3), (True, 6)])
def test_what_was_put_down_may_be_tried_twice_as_often_as_what_failed(success, tries):
    memory = Memory()
    for count in range(1, tries + 1):
        memory = memory.after_action(step(Action.PLACE), success)
        assert ("mug" in context(memory).given_up) == (count == tries)
        assert memory.failures("mug") == (0 if success else count)


def test_what_moved_as_a_thing_was_lifted_is_remembered_until_one_of_the_two_is_taken():
    stopped = Memory().after_action(step(Action.REMOVE), False, True)
    memory = stopped.after_look(step(Action.REMOVE), False, moved=["can"])
    assert context(memory).beliefs == Beliefs(measured=frozenset([("can", "mug")]))
    assert not context(memory).avoid, "the grasp held"
    slipped = memory.after_look(step(Action.REMOVE, "can"), False)
    assert slipped.beliefs.measured == {("can", "mug")}
    assert not slipped.after_look(step(Action.REMOVE, "can"), False, ["can"], ["can"]).beliefs.measured
    assert not slipped.after_look(step(Action.REMOVE, "can"), True).beliefs.measured
