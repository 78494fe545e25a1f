import sys
from pathlib import Path

import fcl
import numpy as np
import pybullet
import pytest

from topple.planner.motion.collision import Checker
from topple.planner.motion.model import Attachment
from topple.robots.arm.gripper import ToolState
from topple.robots.catalog import robot
from topple.robots.collision.convex import hull_of
from topple.topology.base.errors import InvalidInput

sys.path.insert(0, str(Path(__file__).parent))
from scenes import box, clutter, top_down


def states(count: int, seed: int = 0) -> np.ndarray:
    arm = robot("panda")
    return np.random.default_rng(seed).uniform(arm.lower, arm.upper, (count, 7))


def one_by_one(checker: Checker, q: np.ndarray) -> np.ndarray:
    """What python-fcl says of each state, one pair at a time."""
    model = checker.model
    objects = []
    for vertices in model.vertices:
        corners, triangles = hull_of(vertices)
        faces = np.concatenate([np.full((len(triangles), 1), 3), triangles], axis=1).ravel()
        objects.append(fcl.CollisionObject(fcl.Convex(corners, len(triangles), faces)))
    pairs = [(model.moving[m], model.standing[s]) for m, s in np.argwhere(model.standing_pairs)]
    pairs += [tuple(pair) for pair in model.moving_pairs]
    free = np.ones(len(q), dtype=bool)
    for k, frames in enumerate(checker.arm.chain.frames(q)):
        for i in model.moving:
            pose = frames[model.sets.frame[i]]
            objects[i].setTransform(fcl.Transform(pose[:3, :3], pose[:3, 3]))
        free[k] = not any(
            fcl.collide(objects[i], objects[j], fcl.CollisionRequest(), fcl.CollisionResult())
            for i, j in pairs
        )
    return free


@pytest.mark.parametrize("seed", range(3))
def test_the_batch_agrees_with_fcl_state_by_state(seed):
    checker = Checker(robot("panda"), np.eye(4), clutter(seed))
    q = states(1500, seed)
    found = checker.free(q)
    assert 0.05 < found.mean() < 0.95
    assert np.array_equal(found, one_by_one(checker, q))


def test_the_batch_agrees_with_fcl_with_an_object_in_the_hand():
    held = Attachment((box((0.0, 0.0, 0.05), (0.2, 0.05, 0.1)),))
    checker = Checker(
        robot("panda"), np.eye(4), clutter(5), tool_state=ToolState(0.05), attached=held, margin=0.0
    )
    q = states(1000)
    assert np.array_equal(checker.free(q), one_by_one(checker, q))


def test_the_size_of_the_batch_does_not_matter():
    checker = Checker(robot("panda"), np.eye(4), clutter(1))
    q = states(300)
    assert np.array_equal(checker.free(q), np.concatenate([checker.free(part) for part in np.split(q, 60)]))


def test_pybullet_agrees_beyond_its_margin():
    """PyBullet's hulls carry a millimetre of margin: within 2 mm of contact it may say either."""
    arm, scene = robot("panda"), clutter(2)
    checker = Checker(arm, np.eye(4), scene)
    client = pybullet.connect(pybullet.DIRECT)
    try:
        body = pybullet.loadURDF(str(arm.urdf), useFixedBase=True, physicsClientId=client)
        obstacles = []
        for (vertices,) in scene.values():
            shape = pybullet.createCollisionShape(
                pybullet.GEOM_MESH, vertices=vertices.tolist(), physicsClientId=client
            )
            obstacles.append(pybullet.createMultiBody(0, shape, physicsClientId=client))
        joints = {
            pybullet.getJointInfo(body, j, physicsClientId=client)[1].decode(): j
            for j in range(pybullet.getNumJoints(body, physicsClientId=client))
        }
        compared = {True: 0, False: 0}
        for q, free in zip(states(400, 3), checker.free(states(400, 3)), strict=True):
            for name, value in arm.joint_values(q, arm.open_hand).items():
                pybullet.resetJointState(body, joints[name], value, physicsClientId=client)
            if any(self_hit(contact) for contact in checker.contacts(q)):
                continue
            near = [
                point[8]
                for obstacle in obstacles
                for point in pybullet.getClosestPoints(body, obstacle, 0.01, physicsClientId=client)
                if point[3] >= 0
            ]
            distance = min(near, default=1.0)
            if abs(distance) > 0.002:
                assert free == (distance > 0)
                compared[distance > 0] += 1
        assert min(compared.values()) > 20
    finally:
        pybullet.disconnect(client)


def self_hit(contact: object) -> bool:
    return str(getattr(contact, "b", "")).startswith("panda")


def test_a_witness_names_who_hits_whom():
    arm = robot("panda")
    checker = Checker(arm, np.eye(4), {"pillar": [box((0.5, 0.0, 0.3), (0.05, 0.05, 0.6))]})
    (q,) = (found[0] for found in arm.inverse(top_down(0.5, 0.0, 0.3)))
    witness = checker.witness(q)
    assert witness is not None
    assert witness[1] == "pillar"
    assert checker.contacts(q)[0].distance < -0.005
    assert checker.witness(arm.home) is None
    assert checker.contacts(arm.home) == ()


def test_what_may_touch_is_not_reported():
    arm = robot("panda")
    scene = {"ball": [box((0.5, 0.0, 0.3), (0.02, 0.02, 0.02))]}
    q = arm.inverse(top_down(0.5, 0.0, 0.3))[0][:1]
    closed = ToolState(0.015)
    assert not Checker(arm, np.eye(4), scene, tool_state=closed).free(q)[0]
    fingers = [frozenset((finger, "ball")) for finger in ("panda_leftfinger", "panda_rightfinger")]
    assert Checker(arm, np.eye(4), scene, tool_state=closed, allow=fingers).free(q)[0]


def test_a_held_object_hits_what_the_hand_would_not():
    arm = robot("panda")
    scene = {"table": [box((0.5, 0.0, -0.02), (1.0, 1.0, 0.04))]}
    q = arm.inverse(top_down(0.5, 0.0, 0.1))[0][:1]
    long = Attachment((box((0.0, 0.0, 0.06), (0.02, 0.02, 0.12)),), name="rod")
    assert Checker(arm, np.eye(4), scene).free(q)[0]
    checker = Checker(arm, np.eye(4), scene, attached=long)
    assert checker.witness(q[0]) == ("rod", "table")
    assert Checker(arm, np.eye(4), scene, attached=long, allow=[frozenset(("rod", "table"))]).free(q)[0]


@pytest.mark.parametrize("gap", [0.004, 0.02])
def test_a_margin_keeps_that_distance(gap):
    arm = robot("panda")
    q = arm.inverse(top_down(0.5, 0.0, 0.2))[0][:1]
    lowest = min(
        float((np.vstack(arm.parts[i]) @ pose[:3, :3].T + pose[:3, 3])[:, 2].min())
        for i, pose in enumerate(arm.forward(q)[0])
        if "finger" in arm.links[i]
    )
    table = {"table": [box((0.5, 0.0, lowest - gap - 0.02), (0.6, 1.0, 0.04))]}
    assert Checker(arm, np.eye(4), table, margin=gap - 0.0005).free(q)[0]
    assert not Checker(arm, np.eye(4), table, margin=gap + 0.0005).free(q)[0]


def test_moving_base_and_scene_together_changes_nothing():
    arm, scene, q = robot("panda"), clutter(4), states(400)
    c, s = np.cos(0.7), np.sin(0.7)
    pose = np.array([[c, -s, 0, 0.3], [s, c, 0, -1.0], [0, 0, 1, 0.2], [0, 0, 0, 1]])
    moved = {name: [p @ pose[:3, :3].T + pose[:3, 3] for p in parts] for name, parts in scene.items()}
    assert np.array_equal(Checker(arm, np.eye(4), scene).free(q), Checker(arm, pose, moved).free(q))


def test_an_edge_is_free_where_its_samples_are():
    checker = Checker(robot("panda"), np.eye(4), clutter(0))
    starts, ends = states(40, 1), states(40, 2)
    ends = starts + 0.3 * (ends - starts)
    found = checker.edges_free(starts, ends)
    assert 0 < found.sum() < 40
    for a, b, free in zip(starts, ends, found, strict=True):
        count = int(np.ceil(np.abs(b - a).max() / 0.05)) + 1
        assert free == checker.free(np.linspace(a, b, count)).all()
        assert free == checker.edge_free(a, b)


def test_flat_and_tiny_obstacles_are_obstacles():
    arm = robot("panda")
    hand = arm.tool_pose(arm.home)[0, :3, 3] - 0.08 * arm.tool_pose(arm.home)[0, :3, 2]
    sheet = hand + np.array([[x, y, 0.0] for x in (-0.2, 0.2) for y in (-0.2, 0.2)])
    for part in (sheet, sheet[:2] * 0 + hand, hand[None]):
        assert Checker(arm, np.eye(4), {"thing": [part]}).witness(arm.home) == ("panda_hand", "thing")


def test_bad_obstacles_are_refused_by_name():
    arm = robot("panda")
    with pytest.raises(InvalidInput, match="'hole'"):
        Checker(arm, np.eye(4), {"hole": [np.empty((0, 3))]})
    with pytest.raises(InvalidInput, match="'hole'"):
        Checker(arm, np.eye(4), {"hole": [np.full((4, 3), np.nan)]})
    with pytest.raises(InvalidInput, match="'panda_hand' has the name of a link"):
        Checker(arm, np.eye(4), {"panda_hand": [np.zeros((1, 3))]})
