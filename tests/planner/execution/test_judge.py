"""What is judged is the world as it is, not what the cameras make of it."""

import numpy as np
import pytest
from handled import Handled

from topple.planner.decide.goal import parse_goal
from topple.planner.execution.attained import truly_unmet
from topple.planner.execution.execute import MISSED
from topple.planner.execution.judge import Judge, tilts
from topple.robots import robot as robot_named
from topple.robots import shapes
from topple.robots.scenarios.scenario import pose_at
from topple.robots.world.simulated_arm import SimulatedArm
from topple.robots.world.world import World
from topple.topology.scene.scene import Scene

UP = np.array([0.0, 0.0, 1.0])


def test_a_turn_about_the_vertical_is_no_tilt_and_a_fall_is():
    turned, fallen = np.eye(4), np.eye(4)
    turned[:2, :2] = [[0, -1], [1, 0]]
    fallen[1:3, 1:3] = [[0, -1], [1, 0]]
    still = np.eye(4)
    found = tilts({"a": still, "b": still, "c": still}, {"a": turned, "b": fallen, "c": fallen}, ["c"])
    assert found == {"a": pytest.approx(0.0), "b": pytest.approx(np.pi / 2)}


def test_a_goal_holds_only_where_the_true_poses_say_so():
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
        world.remove("blue")
        assert truly_unmet(parse_goal(["blue"], scene), world, UP) == ("blue is not free: it is gone",)
        assert truly_unmet(parse_goal("green on blue", scene), world, UP) == ("green is not on blue",)


def test_what_is_in_a_hollow_or_under_a_load_is_told_from_poses_and_forces():
    with World() as world:
        world.add_table()
        world.add(shapes.bowl("bowl"), pose_at(0.0, 0.0, 0.0))
        world.add(shapes.ball("ball"), pose_at(0.0, 0.0, 0.03))
        world.add(shapes.ball("far"), pose_at(0.3, 0.0, 0.0))
        world.settle()
        scene = Scene({name: np.eye(3) for name in world.names}, fixed=["table"], up=UP)

        def unmet(goal: str) -> tuple[str, ...]:
            return truly_unmet(parse_goal(goal, scene), world, UP)

        assert unmet("ball within bowl") == () and unmet("ball on bowl") == ()
        assert unmet("far within bowl") == ("far is not within bowl",)
        assert unmet("empty bowl") == ("ball is still in bowl",)
        assert unmet("free bowl") == ("bowl is not free: it carries ball",)
        assert unmet("free ball") == ()


def test_what_creeps_from_action_to_action_counts_and_so_does_what_a_failed_attempt_does():
    with World() as world:
        world.add_table()
        world.add(shapes.block("one"), pose_at(0.3, 0.0, 0.0))
        world.add(shapes.block("two"), pose_at(0.5, 0.0, 0.0))
        robot = SimulatedArm(world, robot_named("panda"), pose_at(-0.4, 0.0, 0.0))
        judge = Judge(robot, ["table"], UP)
        found: list[tuple[str, ...]] = []
        for step in range(1, 4):
            judge.begin(Handled("one"))
            world.place("two", pose_at(0.5 + 0.006 * step, 0.0, 0.0))
            found.append(judge.verdict().violations)
        assert found[0] == () and found[2] == ()
        assert len(found[1]) == 1 and "two has crept by 12 mm" in found[1][0]

        judge.begin(Handled("one"))
        world.place("two", pose_at(0.5, 0.0, -0.2))
        drop, energy = judge.verdict().severity["two"]
        assert drop == pytest.approx(0.2) and energy == pytest.approx(0.2 * 9.81 * world.body("two").mass)

        judge.begin(Handled("one"))
        world.place("one", pose_at(0.3, 0.0, 0.1))
        robot.step()
        judge.moment(MISSED, "fingers")
        tipped = pose_at(0.3, 0.0, 0.0)
        tipped[:3, :3] = [[1, 0, 0], [0, 0, -1], [0, 1, 0]]
        world.place("one", tipped)
        said = judge.verdict()
        assert said.dropped
        assert sorted(said.violations)[0].startswith("it was dropped by")
        assert sorted(said.violations)[1] == "it was tipped by 90 degrees in a failed attempt"
        assert robot.on_step == []
