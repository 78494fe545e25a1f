"""Ways to push a thing over an edge: both fingers against its side, its centre of mass on the table."""

import numpy as np
from by_the_edge import END, by_the_edge

from topple.planner.grasp.candidates import grasp_candidates
from topple.planner.grasp.grasp import GraspKind
from topple.planner.grasp.hand import hand_shape
from topple.planner.placement.slides import slides
from topple.planner.placement.tolerances import BALANCED, HANGS
from topple.robots.catalog import robot
from topple.topology.situation import Situation

HAND = hand_shape(robot("panda"))
UP = np.array([0.0, 0.0, 1.0])


def test_a_book_is_pushed_over_the_edge_as_far_as_its_middle_allows() -> None:
    situation = Situation(by_the_edge())
    (way,) = slides("book", situation, HAND)
    assert way.grasp.kind is GraspKind.PUSH
    assert np.allclose(way.ahead, [0.0, 1.0, 0.0], atol=0.02)
    cloud = situation.scene.clouds["book"] + way.placement.pose_before_to_after[:3, 3]
    hangs = float(cloud[:, 1].max()) - END
    assert HANGS[0] - 0.004 < hangs < HANGS[1] + 0.004
    assert (cloud[:, 1].max() + cloud[:, 1].min()) / 2 < END - BALANCED + 0.004
    behind = situation.scene.clouds["book"][:, 1].min() - way.grasp.pose_tool_to_world[1, 3]
    assert 0.005 < behind < 0.015  # half a finger's breadth


def test_without_an_edge_or_room_to_balance_there_is_no_way() -> None:
    assert slides("book", Situation(by_the_edge(side=False)), HAND) == []
    short = Situation(by_the_edge(size=(0.19, 0.09, 0.03)))
    assert slides("book", short, HAND) == []
    assert slides("carton", Situation(by_the_edge()), HAND) == []  # too far, and the palm would be first


def test_the_book_is_pinched_where_it_hangs_over_and_nowhere_before() -> None:
    situation = Situation(by_the_edge())
    assert grasp_candidates("book", situation, hand=HAND) == []
    (way,) = slides("book", situation, HAND)
    there = situation.moved(("book",), way.placement.pose_before_to_after)
    grasps = grasp_candidates("book", there, hand=HAND)
    assert grasps and {grasp.kind for grasp in grasps} == {GraspKind.PINCH}
    for grasp in grasps:
        assert abs(float(grasp.closing @ UP)) > 0.99 and abs(float(grasp.approach @ UP)) < 0.01
        assert grasp.pose_tool_to_world[1, 3] > END  # the hand is beyond the table
