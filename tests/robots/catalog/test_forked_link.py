"""A link with two prongs collides with its prongs, not with the room between them."""

from pathlib import Path

import numpy as np
import pybullet
import pytest
import trimesh

from topple.planner.motion.certificate import Certifier
from topple.planner.motion.collision import Checker
from topple.robots.arm.arm import Arm
from topple.robots.catalog import robot
from topple.topology.base.arrays import FloatArray

PRONGS = ("0 -0.07 0.12", "0 0.07 0.12")
HEIGHT = 0.3  # of the fork's foot above the ground, prongs up
JOINT = "<axis xyz='0 0 1'/><limit lower='-1' upper='1' velocity='1' effort='50'/>"


def _arm(folder: Path, shapes: str) -> Arm:
    """Two joints that slide and turn a fork."""
    text = (
        "<robot name='forklift'><link name='base'/><link name='post'/>"
        f"<joint name='up' type='prismatic'><parent link='base'/><child link='post'/>{JOINT}</joint>"
        f"<link name='fork'>{shapes}</link><joint name='turn' type='revolute'><parent link='post'/>"
        f"<child link='fork'/><origin xyz='0 0 {HEIGHT}'/>{JOINT}</joint></robot>"
    )
    (folder / "fork.urdf").write_text(text)
    return robot(folder / "fork.urdf")


def _elements(_: Path) -> str:
    def box(size: str, centre: str) -> str:
        return f"<collision><origin xyz='{centre}'/><geometry><box size='{size}'/></geometry></collision>"

    return box("0.02 0.16 0.02", "0 0 0.01") + "".join(box("0.02 0.01 0.2", at) for at in PRONGS)


def _one_mesh(folder: Path) -> str:
    solids = [
        trimesh.creation.box((0.02, 0.16, 0.02)),
        *(trimesh.creation.box((0.02, 0.01, 0.2)) for _ in PRONGS),
    ]
    for solid, at in zip(solids, ("0 0 0.01", *PRONGS), strict=True):
        solid.apply_translation([float(x) for x in at.split()])
    trimesh.util.concatenate(solids).export(folder / "fork.stl")
    return "<collision><geometry><mesh filename='fork.stl'/></geometry></collision>"


def _post(x: float, y: float) -> FloatArray:
    """A standing post beside the fork's prongs."""
    corners = np.array([[a, b, c] for a in (-1, 1) for b in (-1, 1) for c in (0, 1)], dtype=float)
    return corners * [0.008, 0.008, 0.18] + [x, y, HEIGHT + 0.03]


def _in_pybullet(arm: Arm, q: FloatArray, post: FloatArray) -> bool:
    client = pybullet.connect(pybullet.DIRECT)
    try:
        body = pybullet.loadURDF(str(arm.urdf), useFixedBase=True, physicsClientId=client)
        for joint, value in enumerate(q):
            pybullet.resetJointState(body, joint, value, physicsClientId=client)
        shape = pybullet.createCollisionShape(
            pybullet.GEOM_MESH, vertices=post.tolist(), physicsClientId=client
        )
        other = pybullet.createMultiBody(0.0, shape, physicsClientId=client)
        found = pybullet.getClosestPoints(body, other, 0.0, physicsClientId=client)
        return any(point[8] < 0.0 for point in found)
    finally:
        pybullet.disconnect(client)


@pytest.mark.parametrize("shapes", [_elements, _one_mesh], ids=["three elements", "one mesh"])
def test_between_the_prongs_there_is_room_and_in_a_prong_there_is_none(tmp_path: Path, shapes) -> None:  # type: ignore[no-untyped-def]
    arm = _arm(tmp_path, shapes(tmp_path))
    states = np.array([[0.0, 0.0], [-0.02, 0.2], [-0.05, -0.4], [0.0, 0.9]])
    for post, free in ((_post(0.0, 0.0), True), (_post(0.0, 0.07), False), (_post(0.035, 0.0606), None)):
        checker = Checker(arm, np.eye(4), {"post": [post]})
        for q, found in zip(states, checker.free(states), strict=True):
            assert found == (not _in_pybullet(arm, q, post)), q
        if free is not None:
            assert checker.free(states[0])[0] == free
    between = Checker(arm, np.eye(4), {"post": [_post(0.0, 0.0)]})
    proof = Certifier(between).certify(states[1][None], states[2][None])[0]
    assert proof.proven and 0.02 < proof.clearance <= 0.03  # that is how far the foot is below the post
    assert (
        not Certifier(Checker(arm, np.eye(4), {"post": [_post(0.035, 0.0606)]}))
        .certify(-states[3][None], states[3][None])[0]
        .proven
    )


def test_a_forks_parts_fill_little_more_than_the_fork(tmp_path):
    parts = _arm(tmp_path, _one_mesh(tmp_path)).parts[-1]
    volume = sum(trimesh.convex.convex_hull(part).volume for part in parts)
    assert 1.0 <= volume / (0.02 * (0.16 * 0.02 + 2 * 0.01 * 0.2)) < 1.1
