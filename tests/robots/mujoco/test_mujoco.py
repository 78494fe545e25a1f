"""Worlds on MuJoCo: the same bodies, what they touch, what cameras see, an arm that holds by friction."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

pytest.importorskip("mujoco", reason="MuJoCo is not installed: pip install '.[mujoco]'")

from topple.planner.motion.trajectory import retime
from topple.robots.arm.arm import Arm
from topple.robots.catalog import robot
from topple.robots.engines import arm_in, new_world, playing_on
from topple.robots.mujoco.acting import MujocoArm
from topple.robots.mujoco.model import _as_box
from topple.robots.mujoco.world import MujocoWorld
from topple.robots.scenarios.scenario import pose_at
from topple.robots.shapes import ball, block, bowl, box, can, lemon, orange, plate
from topple.robots.world.camera import Camera, Noise
from topple.robots.world.world import World
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput

HOME = 0.4  # [m] before the base, where the block stands


def at(x: float, y: float, z: float) -> FloatArray:
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose


@pytest.fixture
def world() -> Iterator[MujocoWorld]:
    with MujocoWorld() as world:
        world.add_table(size=(1.4, 1.2))
        yield world


def test_a_stack_stands_and_its_weight_is_in_the_contacts(world):
    for k in range(3):
        world.add(block(f"block {k}"), at(0.0, 0.0, 0.051 * k))
    assert world.settle(3.0)
    weight = world.body("block 0").mass * 9.81
    pressed: dict[frozenset[str], float] = {}
    for contact in world.contacts():
        assert abs(contact.normal[2]) > 0.99
        pair = frozenset((contact.a, contact.b))
        pressed[pair] = pressed.get(pair, 0.0) + contact.force
    assert pressed[frozenset(("table", "block 0"))] == pytest.approx(3 * weight, rel=0.05)
    assert pressed[frozenset(("block 1", "block 2"))] == pytest.approx(weight, rel=0.05)
    assert world.pose("block 2")[2, 3] == pytest.approx(0.1, abs=1e-3)


def test_what_falls_falls_as_gravity_says(world):
    world.add(block(), at(0.0, 0.0, 0.5))
    world.step(48)
    assert world.time == pytest.approx(0.2)
    assert world.pose("block")[2, 3] == pytest.approx(0.5 - 0.5 * 9.81 * 0.2**2, abs=0.005)


@pytest.mark.parametrize(("tilt", "slides"), [(0.5, False), (0.7, True)])
def test_friction_is_the_product_of_both(tilt, slides):
    """A block on a board at an angle: it holds up to atan(0.7 * 0.85) = 0.54 rad."""
    with MujocoWorld() as world:
        board = block("board", 0.4)
        turned = np.eye(4)
        turned[0, 0] = turned[2, 2] = np.cos(tilt)
        turned[0, 2], turned[2, 0] = np.sin(tilt), -np.sin(tilt)
        world.add(replace(board, friction=0.85), turned, fixed=True)
        world.add(block("block"), turned @ at(0.0, 0.0, 0.4))
        world.step(24)
        before = world.pose("block")[:3, 3]
        world.step(96)
        assert (np.linalg.norm(world.pose("block")[:3, 3] - before) > 0.01) == slides


@pytest.mark.parametrize("lever", [0.0, 1.5e-3])
@pytest.mark.parametrize("shape", [lemon, orange, ball])
def test_what_rolls_rolls_as_far_as_on_the_other_engine(shape, lever):
    """Down a board that gives way, too, by a lever [m]."""
    slope, ways = pose_at(0.0, 0.0, 0.0, Rotation.from_euler("y", 0.3)), list[float]()
    for world in (World(), MujocoWorld()):
        with world:
            board = replace(box("board", (1.2, 1.2, 0.04)), friction=0.85, rolling=lever)
            world.add(board, slope @ at(0.0, 0.0, -0.04), fixed=True)
            world.add(shape("fruit"), slope @ pose_at(0.0, 0.0, 3e-4, Rotation.from_euler("z", np.pi / 2)))
            world.step(12)
            before = world.pose("fruit")[:3, 3]
            world.step(96)
            ways.append(float(np.linalg.norm(world.pose("fruit")[:3, 3] - before)))
    assert ways[1] == pytest.approx(ways[0], rel=0.04) and ways[0] > 0.1


def test_bodies_come_go_and_are_put_elsewhere_while_the_rest_goes_on(world):
    world.add(block("a"), at(0.0, 0.0, 0.3))
    world.step(24)
    height, speed = world.pose("a")[2, 3], world.speeds("a")[0]
    world.add(can("b"), at(0.2, 0.0, 0.0))
    assert world.pose("a")[2, 3] == pytest.approx(height)
    assert world.speeds("a")[0] == pytest.approx(speed) and speed > 0.9
    world.place("a", at(-0.2, 0.0, 0.1))
    assert world.speeds("a") == (0.0, 0.0)
    world.remove("b")
    assert world.names == ("table", "a") and world.movable == ("a",)
    with pytest.raises(InvalidInput, match="two bodies are called 'a'"):
        world.add(block("a"))


def test_both_engines_see_the_same(world):
    camera = Camera.looking_at((0.6, 0.2, 0.5), (0.0, 0.0, 0.03), noise=Noise.none())
    with World() as other:
        other.add_table(size=(1.4, 1.2))
        for each in (world, other):
            each.add(bowl(), at(0.0, 0.0, 0.0))
            each.add(can(), at(0.05, 0.2, 0.0))
            each.add(plate(), at(-0.2, -0.1, 0.0))
        one, two = camera.look(world), camera.look(other)
    assert set(one.names.values()) == set(two.names.values()) == {"table", "bowl", "can", "plate"}
    for name in one.names.values():
        masks = [
            image.label == next(number for number, called in image.names.items() if called == name)
            for image in (one, two)
        ]
        assert (masks[0] & masks[1]).sum() > 0.97 * (masks[0] | masks[1]).sum(), name
    both = (one.depth > 0) & (two.depth > 0) & (one.label > 0)
    assert np.median(np.abs(one.depth - two.depth)[both]) < 5e-4
    assert np.quantile(np.abs(one.depth - two.depth)[both], 0.95) < 2e-3


def moved(acting: MujocoArm, target: FloatArray, seconds: float = 2.0) -> float:
    """Take the fingers straight to a pose (4, 4)."""
    states = [acting.q_target]
    start = acting.arm.tool_pose(acting.q_target)[0]
    for share in np.linspace(0.0, 1.0, 12)[1:]:
        pose = target.copy()
        pose[:3, 3] = (1.0 - share) * start[:3, 3] + share * target[:3, 3]
        found = acting.arm.inverse(pose, near=states[-1])[0]
        states.append(found[0])
    return acting.follow(retime(acting.arm, np.array(states), 0.3))


def down(x: float, y: float, z: float) -> FloatArray:
    pose = np.diag([1.0, -1.0, -1.0, 1.0])
    pose[:3, 3] = x, y, z
    return pose


@pytest.fixture(scope="module")
def panda() -> Arm:
    return robot("panda")


def test_an_arm_follows_and_stays_where_it_is(world, panda):
    acting = MujocoArm(world, panda, np.eye(4))
    assert moved(acting, down(HOME, 0.1, 0.3)) < acting.control.settled
    assert acting.tool_pose("fingers")[:3, 3] == pytest.approx([HOME, 0.1, 0.3], abs=2e-3)
    before = acting.q
    acting.wait(0.5)
    assert np.abs(acting.q - before).max() < 1e-3
    assert acting.link_poses()["panda_hand"] == pytest.approx(
        panda.forward(acting.q)[0, panda.links.index("panda_hand")], abs=1e-6
    )


@pytest.mark.parametrize("friction", [0.7, 0.005])
def test_a_grasp_holds_by_friction_and_by_nothing_else(world, panda, friction):
    world.add(replace(block("block", 0.05), friction=friction), at(HOME, 0.0, 0.0))
    world.settle()
    acting = MujocoArm(world, panda, np.eye(4))
    acting.open()
    moved(acting, down(HOME, 0.0, 0.15))
    moved(acting, down(HOME, 0.0, 0.03))
    assert acting.close(20.0) == pytest.approx(0.05, abs=2e-3)
    assert acting.holding
    assert acting.grip_force == pytest.approx(20.0, rel=0.1)
    held = acting.pose_in_hand("block", "fingers")
    moved(acting, down(HOME, 0.0, 0.2))
    acting.wait(1.0)
    lifted = world.pose("block")[2, 3] > 0.15
    assert lifted == (friction == 0.7)
    if lifted:
        slip = acting.pose_in_hand("block", "fingers")[:3, 3] - held[:3, 3]
        assert np.linalg.norm(slip) < 2e-3
        assert acting.touched["block"].force > 5.0 and "panda_leftfinger" in acting.touched["block"].links
        acting.release()
        world.settle()
        assert not acting.holding
        assert world.pose("block")[2, 3] < 0.03


def test_a_jaw_that_closes_on_nothing_says_so(world, panda):
    acting = MujocoArm(world, panda, np.eye(4))
    assert acting.close(20.0) < 1e-3
    assert not acting.holding


def test_a_guarded_motion_stops_where_something_holds_the_hand_up(world, panda):
    world.add(block("post", 0.15), at(HOME, 0.0, 0.0), fixed=True)
    acting = MujocoArm(world, panda, np.eye(4))
    acting.close(5.0)
    moved(acting, down(HOME, 0.0, 0.25))
    states = [acting.q_target]
    for z in np.linspace(0.25, 0.1, 12)[1:]:
        states.append(panda.inverse(down(HOME, 0.0, z), near=states[-1])[0][0])
    acting.follow_until(retime(panda, np.array(states), 0.1), 8.0)
    assert 0.14 < acting.tool_pose("fingers")[2, 3] < 0.17
    assert acting.touched["post"].force < 60.0


def test_a_box_is_known_by_its_corners():
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-2, 2) for z in (-3, 3)]) * 0.01
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    found = _as_box(corners @ turn.T + [0.1, 0.2, 0.3])
    assert found is not None
    assert np.sort(found[1]) == pytest.approx([0.01, 0.02, 0.03])
    assert found[0][:3, 3] == pytest.approx([0.1, 0.2, 0.3])
    corners[0] *= 1.1
    assert _as_box(corners) is None


def test_engines_go_by_their_names(panda):
    with playing_on("mujoco"), new_world() as world:
        assert isinstance(world, MujocoWorld)
        assert isinstance(arm_in(world, panda, np.eye(4)), MujocoArm)
        with pytest.raises(InvalidInput, match="there is an arm in this world"):
            arm_in(world, panda, np.eye(4))
    with new_world() as world:
        assert isinstance(world, World)
    with pytest.raises(InvalidInput, match="no engine 'ode': expected bullet or mujoco"), playing_on("ode"):
        pass
