"""What the arm reaches of a cube's grasps and places; its ways there and out are straight and free."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import islice

import numpy as np
import pytest
from on_table import BASE

from topple.planner.failure import FailureLog
from topple.planner.grasp.grasp import Grasp
from topple.planner.motion.shortcut import densely
from topple.planner.placement.placement import Placement
from topple.planner.transfer.handling import Handling, Reached
from topple.planner.transfer.segments import SegmentKind
from topple.robots.arm.arm import Arm, Station
from topple.robots.catalog import robot
from topple.robots.poses import angle_between
from topple.topology.base.arrays import FloatArray
from topple.topology.bodies.solids import Solids
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation

PANDA, CUP = robot("panda"), robot("panda-suction")
SIDE = 0.05  # [m] of the cube, which stands at the origin
LENGTH = 0.08  # [m] of the straight ways here


def block(x: tuple[float, float], y: tuple[float, float], z: tuple[float, float]) -> Sequence[FloatArray]:
    """The one convex part of a block between limits [m]."""
    return [np.array([[a, b, c] for a in x for b in y for c in z])]


def handling(arm: Arm = PANDA, **others: Sequence[FloatArray]) -> tuple[Handling, FailureLog]:
    """A cube on a table among others, to be handled, and a log of it."""
    half = SIDE / 2
    bodies: Solids = {
        "cube": block((-half, half), (-half, half), (0.0, SIDE)),
        "table": block((-0.4, 0.8), (-0.6, 0.6), (-0.05, -0.002)),
        **others,
    }
    clouds = {name: np.vstack(parts) for name, parts in bodies.items()}
    scene = Scene(clouds, fixed=["table"], up=(0, 0, 1))
    return Handling(
        "cube", Situation(scene, known_solids=bodies), Station(arm, BASE, np.asarray(arm.home))
    ), FailureLog(frozenset(others))


def pinch(x: float = 0.0, y: float = 0.0) -> Grasp:
    """A hand from above that closes along y, its tips 2 cm below the cube's top."""
    pose = np.diag([1.0, -1.0, -1.0, 1.0])
    pose[:3, 3] = [x, y, 0.03]
    return Grasp("cube", "pinch", pose, SIDE, SIDE + 0.02, 1.0)


def sucking() -> Grasp:
    """A cup on the middle of the cube's top."""
    pose = np.diag([1.0, -1.0, -1.0, 1.0])
    pose[2, 3] = SIDE
    return Grasp("cube", "suction", pose, 0.0, 0.0, 1.0)


def moved_by(x: float, y: float, z: float = 0.0) -> Placement:
    pose = np.eye(4)
    pose[:3, 3] = [x, y, z]
    return Placement(pose, 1.0)


def tools(arm: Arm, path: FloatArray, tool: str = "fingers") -> FloatArray:
    """(k, 4, 4) tool poses in the world along a path."""
    return BASE @ arm.tool_pose(path, tool)


def standing(made: Handling, log: FailureLog) -> Reached:
    """The cube's grasp as the arm makes it first."""
    found = list(made.reach(made.hands([pinch()], np.array(PANDA.home), log), False, log))
    assert found, log.reasons
    return found[0]


@pytest.mark.parametrize(("arm", "grasp", "turns"), [(PANDA, pinch(), 2), (CUP, sucking(), 4)])
def test_a_jaw_is_tried_both_ways_round_and_a_cup_in_quarters(arm, grasp, turns):
    made, log = handling(arm)
    hands = list(made.hands([grasp], np.array(arm.home), log))
    angles = sorted(
        round(np.degrees(angle_between(grasp.pose_tool_to_world, hand.pose_tool_to_world)))
        for hand, _ in hands
    )
    assert angles == {2: [0, 180], 4: [0, 90, 90, 180]}[turns]
    for hand, states in hands:
        assert len(states) > 0
        assert np.abs(tools(arm, states, grasp.tool) - hand.pose_tool_to_world).max() < 1e-4
    assert not log.reasons


def test_pads_that_swing_as_they_close_come_to_where_the_grasp_has_them():
    arm = robot("xarm6")
    made, log = handling(arm)
    hands = list(made.hands([replace(pinch(), width=0.08, opening=0.085)], np.array(arm.home), log))
    assert hands, log.reasons
    for hand, states in hands:
        pads = tools(arm, states) @ arm.tools["fingers"].pads(hand.width)
        assert np.abs(pads - hand.pose_tool_to_world).max() < 1e-4
        assert np.abs(tools(arm, states)[:, 2, 3] - hand.pose_tool_to_world[2, 3]).max() > 5e-3


def test_a_hand_that_meets_something_is_left_out_and_says_what_it_meets():
    wall = block((-0.1, 0.1), (SIDE / 2 + 0.001, SIDE / 2 + 0.04), (0.0, 0.2))
    made, log = handling(wall=wall)
    assert list(made.hands([pinch()], np.array(PANDA.home), log)) == []
    assert log.barring["wall"] == 2
    assert log.furthest is not None
    assert (log.furthest.step, log.furthest.check) == ("grasp", "collision")
    assert log.furthest.pair is not None and log.furthest.pair[1] == "wall"


def test_a_grasp_out_of_reach_is_left_out_and_says_so():
    made, log = handling()
    assert list(made.hands([pinch(x=2.0)], np.array(PANDA.home), log)) == []
    assert dict(log.reasons) == {"grasp out of reach": 2}


def test_of_each_hand_at_most_two_free_states_are_kept():
    made, log = handling()
    hands = list(made.hands([pinch()], np.array(PANDA.home), log))
    found = list(made.reach(hands, False, log))
    assert {id(state.grasp) for state in found} == {id(hand) for hand, _ in hands}
    assert len(hands) <= len(found) <= 2 * len(hands)
    for state in found:
        assert made.checker(SegmentKind.APPROACH, state.grasp).free(state.q[None]).all()
        assert np.abs(tools(PANDA, state.q[None])[0] - state.grasp.pose_tool_to_world).max() < 1e-4


def test_the_way_in_comes_straight_along_the_approach_and_ends_in_the_grasp():
    made, log = handling()
    state = standing(made, log)
    path = made.approach(state, LENGTH, log).path
    assert path is not None
    assert np.array_equal(path[-1], state.q)
    line = tools(PANDA, densely(path, 0.01))[:, :3, 3] - state.grasp.pose_tool_to_world[:3, 3]
    assert line[0] == pytest.approx([0.0, 0.0, LENGTH], abs=1e-3)
    assert np.abs(line[:, :2]).max() < 1e-3
    assert (np.diff(line[:, 2]) < 1e-6).all()


def test_the_way_up_starts_in_the_grasp_and_rises_straight():
    made, log = handling()
    state = standing(made, log)
    path = made.lift(state, LENGTH, log).path
    assert path is not None
    assert np.array_equal(path[0], state.q)
    line = tools(PANDA, densely(path, 0.01))[:, :3, 3] - state.grasp.pose_tool_to_world[:3, 3]
    assert line[-1] == pytest.approx([0.0, 0.0, LENGTH], abs=1e-3)
    assert np.abs(line[:, :2]).max() < 1e-3


def test_a_way_up_into_something_is_none_and_says_what_is_met():
    bar = block((SIDE / 2 - 0.005, 0.2), (-0.03, 0.03), (SIDE + 0.02, SIDE + 0.04))
    free, _ = handling()
    made, log = handling(bar=bar)
    hands = list(free.hands([pinch()], np.array(PANDA.home), FailureLog(frozenset())))
    state = next(free.reach(hands, False, FailureLog(frozenset())))  # as if the bar were not there
    assert made.lift(state, LENGTH, log).path is None
    assert log.barring["bar"] == 1
    assert log.furthest is not None and log.furthest.step == "lift"


def test_a_way_beyond_the_reach_of_the_arm_is_none_and_says_so():
    made, log = handling()
    state = standing(made, log)
    assert made.lift(state, 2.0, log).path is None
    assert dict(log.reasons) == {"no straight lift within the arm's reach": 1}


def test_only_places_where_object_and_hand_are_free_are_open():
    post = block((0.02, 0.08), (0.22, 0.28), (0.0, 0.3))
    made, log = handling(post=post)
    free, taken = moved_by(0.05, -0.25), moved_by(0.05, 0.25)
    assert made.open_ends(pinch(), [taken, free], LENGTH, LENGTH, log) == [free]
    assert log.barring["post"] >= 1
    assert log.furthest is not None and log.furthest.step == "place"


def test_an_end_comes_down_onto_its_place_and_draws_back_from_it():
    made, log = handling()
    state = standing(made, log)
    place, far = moved_by(0.05, -0.25), moved_by(2.0, 0.0)
    (end,) = made.ends(state, [far, place], state.q, LENGTH, LENGTH, log)
    assert end.placement is place
    assert log.reasons["place out of reach"] == 1
    wanted = place.pose_before_to_after @ state.grasp.pose_tool_to_world
    lower, retreat = tools(PANDA, end.lower), tools(PANDA, end.retreat)
    assert np.array_equal(end.lower[-1], end.retreat[0])
    assert np.abs(lower[-1] - wanted).max() < 1e-3
    assert lower[0, :3, 3] - wanted[:3, 3] == pytest.approx([0.0, 0.0, LENGTH], abs=1e-3)
    assert retreat[-1, :3, 3] - wanted[:3, 3] == pytest.approx([0.0, 0.0, LENGTH], abs=1e-3)
    assert made.checker(SegmentKind.TRANSFER, state.grasp).free(densely(end.lower, 0.02)).all()


def test_the_ends_of_the_first_places_come_first():
    made, log = handling()
    state = standing(made, log)
    places = [moved_by(0.05, y) for y in (-0.25, 0.2, 0.28)]
    found = made.ends(state, places, state.q, LENGTH, LENGTH, log)
    assert [end.placement for end in islice(found, 2)] == places[:2]
