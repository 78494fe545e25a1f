"""The distance that motions keep from obstacles: held where there is room, relaxed and stated where not."""

import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pybullet
import pytest

from topple.benchmarks.motion_problems import Problem, pick, transfer
from topple.planner.motion.collision import Checker
from topple.planner.motion.planner import Motion, MotionFailure, plan_motion
from topple.planner.motion.tolerances import CLEARANCE
from topple.robots.arm.arm import Arm
from topple.robots.catalog import robot

sys.path.insert(0, str(Path(__file__).parent))
from scenes import box, densely, top_down


@pytest.fixture
def client() -> Iterator[int]:
    number = pybullet.connect(pybullet.DIRECT)
    yield number
    pybullet.disconnect(number)


def least_distance(client: int, arm: Arm, corners: list[np.ndarray], path: np.ndarray) -> float:
    """Smallest distance of a moving link to a box on a path, as PyBullet sees it with hardly any margin."""
    pybullet.resetSimulation(physicsClientId=client)
    body = pybullet.loadURDF(str(arm.urdf), useFixedBase=True, physicsClientId=client)
    joints: dict[str, int] = {}
    for index in range(pybullet.getNumJoints(body, physicsClientId=client)):
        joints[pybullet.getJointInfo(body, index, physicsClientId=client)[1].decode()] = index
        pybullet.changeDynamics(body, index, collisionMargin=1e-6, physicsClientId=client)
    things: list[int] = []
    for part in corners:
        shape = pybullet.createCollisionShape(
            pybullet.GEOM_MESH, vertices=part.tolist(), physicsClientId=client
        )
        things.append(pybullet.createMultiBody(0.0, shape, physicsClientId=client))
        pybullet.changeDynamics(things[-1], -1, collisionMargin=1e-6, physicsClientId=client)
    least = np.inf
    for q in densely(path, 0.02):
        for name, value in arm.joint_values(q, arm.open_hand).items():
            pybullet.resetJointState(body, joints[name], value, physicsClientId=client)
        for thing in things:
            found = pybullet.getClosestPoints(body, thing, 0.02, physicsClientId=client)
            least = min([least, *(point[8] for point in found if point[3] >= 0)])
    return float(least)


@pytest.mark.parametrize("make", [pick, pytest.param(transfer, marks=pytest.mark.slow)])
def test_pybullet_sees_no_overlap_on_the_paths_and_what_is_stated_is_kept(client, make):
    arm = robot("panda")
    kept: list[float] = []
    for seed in range(6):
        problem: Problem = make(arm, seed)  # type: ignore[operator]
        found = plan_motion(problem.checker, problem.start, problem.goals, seed=seed)
        assert isinstance(found, Motion)
        assert found.certificate is not None and found.certificate.proven
        corners = [thing.corners for thing in problem.boxes.values()]
        seen = least_distance(client, arm, corners, found.path)
        assert (
            seen > found.certificate.clearance - 1e-3
        )  # PyBullet's own distances of hulls are off by so much
        assert seen > 0.0
        kept.append(found.certificate.clearance)
    assert np.mean(np.array(kept) >= CLEARANCE - 1e-4) > 0.5


def slit(width: float) -> tuple[Checker, np.ndarray, np.ndarray]:
    """The hand above two walls, and between them, with a width in [m] and some to spare on either side."""
    arm = robot("panda")
    checker = Checker(arm, np.eye(4), {})
    start = arm.inverse(top_down(0.5, 0.0, 0.45), near=arm.home)[0][0]
    goal = arm.inverse(top_down(0.5, 0.0, 0.15), near=start)[0][0]
    points = checker.model.vertices[checker.model.names.index("panda_hand")]
    pose = arm.chain.frames(goal[None])[0, -1]
    across = (points @ pose[:3, :3].T + pose[:3, 3])[:, 0]
    low, high = across.min() - width, across.max() + width
    walls = {
        "left": [box((low - 0.05, 0.0, 0.12), (0.1, 0.6, 0.24))],
        "right": [box((high + 0.05, 0.0, 0.12), (0.1, 0.6, 0.24))],
    }
    return Checker(arm, np.eye(4), walls), start, goal


def test_where_there_is_room_the_clearance_is_kept_and_asking_for_none_gives_none():
    checker, start, goal = slit(0.03)
    found = plan_motion(checker, start, goal)
    assert isinstance(found, Motion) and found.certificate is not None
    assert found.certificate.clearance >= CLEARANCE
    wide = plan_motion(checker, start, goal, clearance=0.02)
    assert isinstance(wide, Motion) and wide.certificate is not None
    assert wide.certificate.clearance >= 0.02


def test_a_goal_nearer_than_the_clearance_is_reached_and_the_certificate_says_how_near():
    checker, start, goal = slit(0.002)
    found = plan_motion(checker, start, goal)
    assert isinstance(found, Motion) and found.certificate is not None
    assert found.certificate.proven
    assert 0.001 < found.certificate.clearance < CLEARANCE - 1e-3


def test_only_the_part_that_the_start_is_near_to_is_approached():
    checker, start, goal = slit(0.002)
    stricter = checker.at_distance(CLEARANCE, np.stack([start, goal]))
    far = Checker(checker.arm, np.eye(4), {"post": [box((0.0, 0.6, 0.5), (0.1, 0.1, 1.0))]})
    assert far.at_distance(CLEARANCE, start[None]).model.margin.max() == CLEARANCE
    wanted = stricter.model.margin[stricter.model.obstacle]
    assert ((wanted > 0.001) & (wanted < CLEARANCE - 1e-3)).all()
    assert not stricter.model.margin[~stricter.model.obstacle].any()
    assert stricter.free(np.stack([start, goal])).all()


def test_a_passage_narrower_than_the_clearance_is_passed_before_there_is_no_plan():
    """The start and the goal are clear; between them there are 2 mm beside a plate."""
    arm = robot("panda")
    turned = arm.home + np.array([1.2, *np.zeros(6)])
    ring = Checker(arm, np.eye(4), {"floor": [box((0.4, 0.4, -0.05), (2.0, 2.0, 0.02))]})
    assert ring.free(np.stack([arm.home, turned])).all()
    states = arm.home + np.linspace(0.0, 1.2, 200)[:, None] * np.eye(7)[0]
    top = max(
        float((part @ pose[:3, :3].T + pose[:3, 3])[:, 2].max())
        for parts, pose in zip(arm.parts, arm.forward(arm.home)[0], strict=True)
        for part in parts
    )
    bottom = min(
        float((part @ pose[:3, :3].T + pose[:3, 3])[:, 2].min())
        for link, parts, pose in zip(arm.links, arm.parts, arm.forward(arm.home)[0], strict=True)
        for part in parts
        if arm.frame_of_link[arm.links.index(link)] > 1
    )
    across = np.array([np.cos(0.6), np.sin(0.6), 0.0])
    lid = box((0.55 * across[0], 0.55 * across[1], top + 0.002 + 0.25), (1.4, 0.3, 0.5), yaw=0.6)
    below = box(
        (0.65 * across[0], 0.65 * across[1], (bottom - 0.002) / 2), (0.9, 0.3, bottom - 0.002), yaw=0.6
    )
    checker = Checker(arm, np.eye(4), {"lid": [lid], "below": [below]})
    assert checker.free(states).all()
    found = plan_motion(checker, arm.home, turned)
    assert isinstance(found, Motion), found.reason if isinstance(found, MotionFailure) else ""
    assert found.certificate is not None and found.certificate.proven
    assert 0.0 < found.certificate.clearance < CLEARANCE
