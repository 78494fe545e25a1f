import sys
import time
from copy import copy
from pathlib import Path

import numpy as np
import pytest

from topple.planner.budget import OutOfBudget, within
from topple.planner.motion.collision import Checker
from topple.planner.motion.ompl_search import ompl_path
from topple.planner.motion.planner import Motion, MotionFailure, plan_motion
from topple.planner.motion.shortcut import length, shortcut
from topple.robots.catalog import robot
from topple.topology.base.errors import InvalidInput

sys.path.insert(0, str(Path(__file__).parent))
from scenes import box, clutter, densely, top_down, walled


@pytest.mark.parametrize("seed", range(4))
def test_a_motion_around_a_wall_is_free_everywhere_and_reaches_a_goal(seed):
    checker, start, goals = walled(robot("panda"), seed)
    found = plan_motion(checker, start, goals, seed=seed)
    assert isinstance(found, Motion)
    assert found.certificate is not None
    assert found.certificate.proven
    assert np.array_equal(found.path[0], start)
    assert np.array_equal(found.path[-1], goals[found.goal])
    assert checker.free(densely(found.path)).all()
    arm = checker.arm
    assert ((found.path >= arm.lower - 1e-6) & (found.path <= arm.upper + 1e-6)).all()


def test_the_same_seed_gives_the_same_path():
    checker, start, goals = walled(robot("panda"), 1)
    first, second = (plan_motion(checker, start, goals, seed=3) for _ in range(2))
    assert isinstance(first, Motion)
    assert isinstance(second, Motion)
    assert np.array_equal(first.path, second.path)
    assert first.stage == "rrt"


def test_where_the_straight_way_is_free_it_is_taken_to_the_nearest_goal():
    arm = robot("panda")
    checker = Checker(arm, np.eye(4), {"table": [box((0.5, 0.0, -0.03), (1.0, 1.0, 0.04))]})
    goals = arm.home + np.array([[0.8], [0.3], [-0.5]]) * np.eye(7)[0]
    found = plan_motion(checker, arm.home, goals)
    assert isinstance(found, Motion)
    assert (found.stage, found.goal, len(found.path)) == ("direct", 1, 2)


def test_a_start_in_collision_says_with_what():
    arm = robot("panda")
    checker = Checker(arm, np.eye(4), {"post": [box((0.45, 0.0, 0.5), (0.05, 0.05, 0.4))]})
    state = arm.inverse(top_down(0.45, 0.0, 0.4))[0][0]
    found = plan_motion(checker, state, arm.home)
    assert isinstance(found, MotionFailure)
    assert found.stage == "start"
    assert found.witness is not None
    assert found.witness[1] == "post"
    assert "post" in found.reason
    back = plan_motion(checker, np.array([2.5, *arm.home[1:]]), state)
    assert isinstance(back, MotionFailure)
    assert back.stage == "goals"
    assert back.distance < 0


def behind_walls() -> tuple[Checker, np.ndarray, np.ndarray]:
    """A start and a goal that walls part."""
    arm = robot("panda")
    walls = {
        "left wall": [box((0.0, 0.75, 1.25), (0.02, 1.2, 2.5))],
        "right wall": [box((0.0, -0.75, 1.25), (0.02, 1.2, 2.5))],
        "roof": [box((0.0, 0.0, 0.95), (2.0, 2.0, 0.02))],
    }
    return Checker(arm, np.eye(4), walls), arm.home, np.array([2.8, *arm.home[1:]])


def test_a_goal_behind_walls_fails_and_names_what_bars_the_way():
    found = plan_motion(*behind_walls(), rounds=40)
    assert isinstance(found, MotionFailure)
    assert found.stage == "search"
    assert found.witness is not None
    assert found.witness[1] in ("left wall", "right wall", "roof")
    assert found.witness[1] in found.reason


def test_a_budget_that_runs_out_is_the_failure_and_counts_for_the_whole_call():
    found = plan_motion(*behind_walls(), budget=0.05)
    assert isinstance(found, MotionFailure)
    assert (found.stage, found.contacts) == ("budget", ())
    assert "the budget of 0.05 s ran out" in found.reason
    with pytest.raises(OutOfBudget, match=r"of 0\.05 s"), within(0.05):
        plan_motion(*behind_walls(), budget=30.0)
    with pytest.raises(InvalidInput, match=r"budget is 0\.0: expected seconds above 0"):
        plan_motion(*behind_walls(), budget=0.0)


class Slow(Checker):
    """A checker on a machine that many share: every batch of edges takes a fifth of a second more."""

    def edges_free(self, *edges: object, **how: object) -> np.ndarray:
        time.sleep(0.2)
        return super().edges_free(*edges, **how)  # type: ignore[arg-type]


def test_on_a_busy_machine_the_answer_is_the_same_only_later():
    checker, start, goals = walled(robot("panda"), 1)
    slow = copy(checker)
    slow.__class__ = Slow
    idle, busy = plan_motion(checker, start, goals, seed=3), plan_motion(slow, start, goals, seed=3)
    assert isinstance(idle, Motion) and isinstance(busy, Motion)
    assert np.array_equal(idle.path, busy.path)
    assert busy.stage == idle.stage == "rrt"
    assert busy.seconds > 2.0
    barred, start, goal = behind_walls()
    slow = copy(barred)
    slow.__class__ = Slow
    idle, busy = (plan_motion(each, start, goal, rounds=8) for each in (barred, slow))
    assert isinstance(idle, MotionFailure) and isinstance(busy, MotionFailure)
    assert (busy.stage, busy.reason) == (idle.stage, idle.reason)


def test_what_is_no_query_is_refused():
    arm = robot("panda")
    checker = Checker(arm, np.eye(4), {})
    with pytest.raises(InvalidInput, match="panda has 7 joints"):
        plan_motion(checker, np.zeros(6), arm.home)
    with pytest.raises(InvalidInput, match="finite"):
        plan_motion(checker, arm.home, np.full(7, np.nan))
    beyond = plan_motion(checker, arm.home, arm.upper + 1)
    assert isinstance(beyond, MotionFailure)
    assert "joint limits" in beyond.reason
    nowhere = plan_motion(checker, arm.home, np.empty((0, 7)))
    assert isinstance(nowhere, MotionFailure)


@pytest.mark.parametrize(("planner", "iterations"), [("RRTConnect", 2000), ("AORRTC", 500)])
def test_ompl_finds_a_way_through_the_batched_validator(planner, iterations):
    checker, start, goals = walled(robot("panda"), 2)
    path = ompl_path(checker, start, goals, iterations=iterations, planner=planner)
    assert path is not None
    assert np.allclose(path[0], start)
    assert np.abs(goals - path[-1]).max(axis=1).min() < 1e-9
    assert checker.edges_free(path[:-1], path[1:]).all()


def test_a_shortcut_keeps_the_ends_and_is_no_longer():
    rng = np.random.default_rng(0)
    path = np.cumsum(rng.normal(size=(12, 3)), axis=0)
    blocked = path[6]

    def free(starts: np.ndarray, ends: np.ndarray) -> np.ndarray:
        t = np.linspace(0, 1, 200)[:, None, None]
        way = starts + t * (ends - starts)
        return np.linalg.norm(way - blocked - 0.8, axis=2).min(axis=0) > 0.5

    short = shortcut(path, free)
    assert short is not None
    assert np.array_equal(short[[0, -1]], path[[0, -1]])
    assert length(short) <= length(path)
    straight = shortcut(path, lambda a, b: np.ones(len(a), dtype=bool))
    assert straight is not None
    assert len(straight) == 2


def test_a_path_that_is_not_trusted_and_not_free_is_given_up():
    path = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]])
    assert shortcut(path, lambda a, b: np.zeros(len(a), dtype=bool), trusted=False) is None


def test_clutter_is_crossed_from_many_states():
    checker = Checker(robot("panda"), np.eye(4), clutter(7))
    arm = checker.arm
    rng = np.random.default_rng(7)
    states = rng.uniform(arm.lower, arm.upper, (200, 7))
    states = states[checker.free(states)][:8]
    for k in range(0, 8, 2):
        found = plan_motion(checker, states[k], states[k + 1], seed=k)
        assert isinstance(found, Motion)
        assert checker.free(densely(found.path, 0.005)).all()
