"""An arm's motion as pages play it, and as it is packed."""

import base64
import json
from dataclasses import replace

import numpy as np
import pytest
from carrying import ABOVE, carried
from scipy.spatial.transform import Rotation

from topple.planner.formats.arm_motion import HAND_SECONDS, ArmMotion
from topple.planner.report.limits import LIMITS
from topple.planner.report.plan_page import plan_motion, plan_page
from topple.planner.report.played import STEP, TURN, arm_shape, motion_json, spans
from topple.robots.arm.arm import Arm
from topple.robots.arm.gripper import ToolState
from topple.robots.arm.tolerances import BARE, DARKEST
from topple.robots.arm.visuals import visuals
from topple.robots.catalog import robot


def unpacked(text):
    return np.frombuffer(base64.b64decode(text), dtype="<i2").reshape(-1, 7).astype(float)


def test_links_are_where_the_kinematics_have_them(panda):
    motion = carried("box", panda)
    assert np.allclose(motion.links[0], panda.forward(ABOVE, ToolState(0.08))[0])
    assert (np.diff(motion.times) >= 0).all() and np.isclose(motion.times[-1], 2.0 + 2 * HAND_SECONDS)
    assert [kind for kind, _, _ in spans(motion)] == ["approach", "grasp", "lift", "release"]


def test_what_is_carried_keeps_its_place_in_the_hand_and_falls_when_let_go(panda):
    motion = carried("box", panda)
    hand = panda.links.index("panda_hand")
    lifts = [k for k, kind in enumerate(motion.kinds) if kind == "lift"]
    in_hand = [np.linalg.inv(motion.links[k, hand]) @ motion.carried["box"][k] for k in lifts]
    assert np.allclose(in_hand, in_hand[0], atol=1e-9)
    assert motion.carried["box"][lifts[-1]][2, 3] > 0.02  # it was lifted
    assert np.isclose(motion.carried["box"][-1][2, 3], motion.carried["box"][lifts[-1]][2, 3] - 0.05)


def test_a_hand_that_stands_still_has_no_motion(panda):
    assert ArmMotion.of(panda, np.eye(4), []) is None


def test_poses_come_back_within_a_step_of_their_packing(panda):
    motion, centre = carried("box", panda), np.array([0.4, 0.1, 0.2])
    shape = arm_shape(panda)
    data = motion_json(motion, shape, {"box": 3}, centre)
    chosen = shape["links"]
    packed = unpacked(data["links"])
    truth = motion.links[:, chosen].reshape(-1, 4, 4)
    assert np.abs(packed[:, :3] * STEP + centre - truth[:, :3, 3]).max() <= 0.51 * STEP
    turns = Rotation.from_quat(packed[:, 3:] / TURN) * Rotation.from_matrix(truth[:, :3, :3]).inv()
    assert turns.magnitude().max() < 2e-4
    (box,) = data["carried"]
    assert box["object"] == 3
    about = unpacked(box["poses"])
    turned = Rotation.from_quat(about[:, 3:] / TURN).as_matrix()
    point = np.array([0.5, 0.0, 0.1])
    back = turned @ (point - centre) + centre + about[:, :3] * STEP
    assert np.abs(back - (motion.carried["box"] @ [*point, 1.0])[:, :3]).max() < 2e-4


@pytest.mark.parametrize("name", ["panda-suction", "iiwa", "xarm6"])
def test_an_arm_looks_like_its_urdf_in_few_triangles(name):
    arm = robot(name)
    seen = visuals(arm, LIMITS.arm_triangles)
    assert 1500 < sum(len(visual.faces) for parts in seen for visual in parts) <= LIMITS.arm_triangles
    for parts, drawn in zip(arm.parts, seen, strict=True):
        assert bool(drawn) >= bool(parts)  # whatever can be hit is seen
        if parts and drawn:
            solid, shown = np.concatenate(parts), np.concatenate([visual.vertices for visual in drawn])
            assert np.abs(solid.min(axis=0) - shown.min(axis=0)).max() < 0.03
            assert np.abs(solid.max(axis=0) - shown.max(axis=0)).max() < 0.03
    colours = {visual.colour for parts in seen for visual in parts}
    assert min(max(colour) for colour in colours) >= DARKEST
    assert len(json.dumps(arm_shape(arm))) < 100_000


def test_an_arm_without_meshes_and_colours_is_seen_by_its_hulls_in_grey(tmp_path):
    bare = tmp_path / "bare.urdf"
    box = "<collision><geometry><box size='0.1 0.1 0.4'/></geometry></collision>"
    link = f"<link name='{{}}'><visual><geometry><mesh filename='gone.stl'/></geometry></visual>{box}</link>"
    joint = "<joint name='j' type='revolute'><parent link='a'/><child link='b'/>"
    joint += "<axis xyz='0 0 1'/><limit lower='-1' upper='1' velocity='1'/></joint>"
    bare.write_text(f"<robot name='bare'>{link.format('a')}{link.format('b')}{joint}</robot>")
    seen = visuals(Arm.from_urdf(bare, "b", {}), 100)
    assert [[len(visual.faces) for visual in parts] for parts in seen] == [[12], [12]]
    assert {visual.colour for parts in seen for visual in parts} == {BARE}


def test_another_arm_stands_beside(panda):
    motion = carried("box", panda)
    beside = replace(motion, beside=motion.links[0])
    shape, centre = arm_shape(panda), np.zeros(3)
    poses = unpacked(motion_json(beside, shape, {}, centre)["beside"])
    assert np.abs(poses[:, :3] * STEP - motion.links[0, shape["links"], :3, 3]).max() <= 0.51 * STEP
    assert motion_json(motion, shape, {}, centre)["beside"] is None


def test_the_motion_of_a_plan_ends_where_the_plan_puts_things(lone_plan, panda):
    plan, _ = lone_plan
    motion = plan_motion(plan, panda)
    (step,) = plan.steps
    put = np.array(step.placement.pose_before_to_after)
    put[:3, 3] -= step.placement.drop * np.array(plan.up)
    assert np.allclose(motion.carried["box"][-1], put, atol=2e-3)
    assert len(motion.ends) == 1 and motion.ends[0] == len(motion.times) - 1


def test_the_page_of_a_plan_is_small_and_says_why(lone_plan):
    page = plan_page(*lone_plan)
    assert len(page) < 1_000_000
    assert "free box" in page and "grasp; put down" in page and "proven to stay" in page
