"""What is judged is the world as it is, not what the cameras make of it."""

import numpy as np
import pytest

from topple.planner.decide.goal import parse_goal
from topple.planner.execution.judge import tilts, truly_unmet
from topple.robots import shapes
from topple.robots.scenarios.scenario import pose_at
from topple.robots.world.world import World
from topple.topology.scene import Scene

UP = np.array([0.0, 0.0, 1.0])


def test_a_turn_about_the_vertical_is_no_tilt_and_a_fall_is() -> None:
    turned, fallen = np.eye(4), np.eye(4)
    turned[:2, :2] = [[0, -1], [1, 0]]
    fallen[1:3, 1:3] = [[0, -1], [1, 0]]
    still = np.eye(4)
    found = tilts({"a": still, "b": still, "c": still}, {"a": turned, "b": fallen, "c": fallen}, ["c"])
    assert found == {"a": pytest.approx(0.0), "b": pytest.approx(np.pi / 2)}


def test_a_goal_holds_only_where_the_true_poses_say_so() -> None:
    with World() as world:
        world.add_table()
        world.add(shapes.block("blue"), pose_at(0.0, 0.0, 0.0))
        world.add(shapes.block("green"), pose_at(0.0, 0.0, 0.0502))
        world.add(shapes.block("red"), pose_at(0.0505, 0.0, 0.0))
        world.settle()
        scene = Scene({name: np.eye(3) for name in world.names}, fixed=["table"], up=UP)
        assert truly_unmet(parse_goal("green on blue", scene), world, UP) == ()
        assert truly_unmet(parse_goal("red on blue", scene), world, UP) == ("red is not on blue",)
        assert truly_unmet(parse_goal(["blue"], scene), world, UP) == ("blue is not free: it carries green",)
