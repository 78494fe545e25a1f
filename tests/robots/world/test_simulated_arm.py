"""The simulated arm holds by friction and by a vacuum that needs a seal, never by anything else."""

from collections.abc import Iterator

import numpy as np
import pybullet
import pytest
from moving import Way, at, down, go, way_to

from topple.robots import shapes
from topple.robots.catalog import robot
from topple.robots.poses import angle_between
from topple.robots.world.bodies import Body
from topple.robots.world.simulated_arm import SimulatedArm
from topple.robots.world.world import World
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput


@pytest.fixture
def world() -> Iterator[World]:
    with World() as world:
        world.add_table()
        yield world


def load_on(world: World, name: str) -> float:
    """Force [N] with which everything but robots presses on an object."""
    points = pybullet.getContactPoints(world.ids[name], physicsClientId=world.client)
    return sum(point[9] for point in points if point[2] not in world.robots)


def height(world: World, name: str) -> float:
    return float(world.pose(name)[2, 3])


def test_a_trajectory_ends_where_it_should(world):
    arm = SimulatedArm(world, robot("panda"), np.eye(4))
    assert go(arm, down(0.5, 0.1, 0.3), "fingers") < 2e-3
    assert arm.link_pose("panda_hand")[:2, 3] == pytest.approx([0.5, 0.1], abs=2e-3)


def test_fingers_lift_a_can_by_friction_and_drop_it_when_they_open(world):
    world.add(shapes.can("can"), at(0.5, 0.0, 0.0))
    world.settle()
    arm = SimulatedArm(world, robot("panda"), np.eye(4))
    go(arm, down(0.5, 0.0, 0.25), "fingers")
    go(arm, down(0.5, 0.0, 0.08), "fingers")
    assert not arm.holding
    opening = arm.close(40.0)
    assert arm.holding and 0.05 < opening < 0.08
    go(arm, down(0.5, 0.0, 0.25), "fingers")
    assert arm.holding and height(world, "can") > 0.12
    assert pybullet.getNumConstraints(physicsClientId=world.client) == 1, "the gear of the fingers, no glue"
    arm.open()
    arm.wait(0.6)
    assert height(world, "can") < 0.1


def _moved_by_closing(world: World, name: str, hand: FloatArray) -> tuple[float, float, SimulatedArm]:
    """Distance [m] and angle [degrees] by which an object moves while a hand closes on it."""
    world.settle()
    arm = SimulatedArm(world, robot("panda"), np.eye(4))
    before = world.pose(name)
    go(arm, at(0.0, 0.0, 0.1) @ hand, "fingers")
    go(arm, hand, "fingers")
    arm.close(42.0)
    assert arm.holding
    after = world.pose(name)
    moved = float(np.linalg.norm(after[:3, 3] - before[:3, 3]))
    return moved, float(np.degrees(angle_between(before, after))), arm


def test_a_closing_hand_gives_way_to_the_pad_that_comes_first(world):
    world.add(shapes.box("box", (0.05, 0.05, 0.08), mass=0.1), at(0.5, 0.0, 0.0))
    moved, angle, _ = _moved_by_closing(world, "box", down(0.5, 0.01, 0.05))
    assert moved < 1e-3 and angle < 1.0, "the pads met it a centimetre beside the hand's middle"


def test_a_closing_hand_turns_to_a_wall_that_leans(world):
    world.add(shapes.bowl("bowl"), at(0.5, 0.0, 0.0))
    lean = np.radians(10.0)  # the wall leans by 19 degrees
    turn = np.eye(4)
    turn[1:3, 1:3] = [[np.cos(lean), -np.sin(lean)], [np.sin(lean), np.cos(lean)]]
    hand = at(0.5, 0.076, 0.052) @ turn @ np.diag([1.0, -1.0, -1.0, 1.0])
    moved, angle, arm = _moved_by_closing(world, "bowl", hand)
    assert moved < 2e-3 and angle < 2.0, "the bowl stays"
    assert np.degrees(angle_between(arm.arm.tool_pose(arm.q, "fingers")[0], hand)) > 5.0, "the hand turns"


def test_an_arm_beside_its_trajectory_may_keep_its_offset(world):
    arm = SimulatedArm(world, robot("panda"), np.eye(4))
    start, offset = np.asarray(arm.arm.home), np.full(7, 0.05)
    arm.follow(Way.between(start, start + offset, seconds=0.5))
    way = Way.between(start, start - offset)
    arm.follow(way, keep_offset=True)
    assert arm.q == pytest.approx(start, abs=3e-3)
    arm.follow(way)
    assert arm.q == pytest.approx(start - offset, abs=3e-3)


def test_a_can_wider_than_the_grip_is_strong_slips(world):
    world.add(shapes.can("can", mass=4.0), at(0.5, 0.0, 0.0))
    world.settle()
    arm = SimulatedArm(world, robot("panda"), np.eye(4))
    go(arm, down(0.5, 0.0, 0.25), "fingers")
    go(arm, down(0.5, 0.0, 0.08), "fingers")
    arm.close(5.0)
    go(arm, down(0.5, 0.0, 0.25), "fingers")
    assert height(world, "can") < 0.05, "10 N of friction cannot carry 40 N"


def test_the_cup_lifts_a_plate_it_seals_on_and_lets_go_beyond_its_force(world):
    arm, top = _cup_above_a_plate(world)
    assert arm.cup is not None
    assert not arm.suck(), "there is no seal in the air"
    go(arm, down(0.5, 0.0, top), "suction")
    assert arm.suck()
    go(arm, down(0.5, 0.0, top + 0.15), "suction")
    assert arm.holding and height(world, "plate") > 0.12
    for _ in range(60):
        number = world.ids["plate"]
        where = pybullet.getBasePositionAndOrientation(number, physicsClientId=world.client)[0]
        pull = [0.0, 0.0, -1.2 * arm.cup.max_force]
        pybullet.applyExternalForce(
            number, -1, pull, where, pybullet.WORLD_FRAME, physicsClientId=world.client
        )
        arm.step()
    assert not arm.holding


def _cup_above_a_plate(world: World) -> tuple[SimulatedArm, float]:
    """An arm that holds its cup, pushed out, 10 cm above a plate, and the height of the plate's surface."""
    world.add(shapes.plate("plate"), at(0.5, 0.0, 0.0))
    world.settle()
    arm = SimulatedArm(world, robot("panda-suction"), np.eye(4))
    top = _surface(world, 0.5, 0.0)
    go(arm, down(0.5, 0.0, top + 0.1), "suction")
    assert arm.cup is not None
    arm.extend(arm.cup.stroke)
    return arm, top


def test_the_vacuum_does_not_push_what_it_takes(world):
    arm, top = _cup_above_a_plate(world)
    arm.follow_until(way_to(arm, down(0.5, 0.0, top), "suction"), 8.0)
    arm.wait(0.2)
    assert arm.suck()
    weight = 9.81 * world.body("plate").mass
    before = world.pose("plate")
    for _ in range(60):
        arm.step()
        assert load_on(world, "plate") < weight + 10.0, "no more than seats the lip"
    assert np.linalg.norm(world.pose("plate")[:3, 3] - before[:3, 3]) < 1e-4


def test_the_cup_finds_no_seal_on_a_spoon(world):
    world.add(shapes.spoon("spoon"), at(0.5, 0.0, 0.0))
    world.settle()
    arm = SimulatedArm(world, robot("panda-suction"), np.eye(4))
    assert arm.cup is not None
    top = _surface(world, 0.5, 0.0)
    go(arm, down(0.5, 0.0, top + 0.1), "suction")
    arm.extend(arm.cup.stroke)
    go(arm, down(0.5, 0.0, top), "suction")
    assert not arm.suck()


def test_a_hand_without_a_cup_says_so(world):
    arm = SimulatedArm(world, robot("panda"), np.eye(4))
    with pytest.raises(InvalidInput, match="no suction cup"):
        arm.suck()


def test_what_the_arm_touches_is_recorded(world):
    world.add(shapes.can("can"), at(0.5, 0.0, 0.0))
    world.settle()
    arm = SimulatedArm(world, robot("panda"), np.eye(4))
    go(arm, down(0.42, 0.0, 0.2), "fingers")
    go(arm, down(0.42, 0.0, 0.05), "fingers")
    arm.touched.clear()
    go(arm, down(0.48, 0.0, 0.05), "fingers")
    assert set(arm.touched) == {"can"} and arm.touched["can"].force > 0.1


def _surface(world: World, x: float, y: float) -> float:
    hit = pybullet.rayTest([x, y, 0.5], [x, y, -0.1], physicsClientId=world.client)[0]
    return float(hit[3][2])


def _turned_in_the_hand(world: World, mass: float) -> float:
    """By how many degrees a bar turns that is lifted 4 cm beside its middle."""
    world.add(shapes.box("bar", (0.16, 0.04, 0.05), mass=mass), at(0.5, 0.0, 0.0))
    world.settle()
    arm = SimulatedArm(world, robot("panda"), np.eye(4))
    go(arm, down(0.54, 0.0, 0.2), "fingers")
    go(arm, down(0.54, 0.0, 0.035), "fingers")
    arm.close(42.0)
    before = world.pose("bar")
    go(arm, down(0.54, 0.0, 0.2), "fingers")
    assert arm.holding
    return float(np.degrees(angle_between(before, world.pose("bar"))))


def test_rubber_pads_hold_a_bar_beside_its_middle(world):
    assert _turned_in_the_hand(world, 0.4) < 2.0


def test_a_heavy_bar_held_beside_its_middle_turns(world):
    assert _turned_in_the_hand(world, 2.5) > 10.0, "1 N m is more than pads of this size hold"


def _held_by_its_neck(world: World, body: Body) -> SimulatedArm:
    """An arm that holds cutlery by its neck, 15 cm above the table; the tips did not reach that."""
    world.add(body, at(0.5, 0.0, 0.0))
    world.settle()
    neck = world.pose(body.name) @ np.array([0.02, 0.0, 0.0, 1.0])
    top = _surface(world, neck[0], neck[1])
    arm = SimulatedArm(world, robot("panda"), np.eye(4))
    go(arm, down(neck[0], neck[1], top + 0.1), "fingers")
    go(arm, down(neck[0], neck[1], top - 0.003), "fingers")
    arm.close(42.0)
    arm.wait(0.2)
    closed = arm.pose_in_hand(body.name, "fingers")
    go(arm, down(neck[0], neck[1], top + 0.15), "fingers")
    lifted = arm.pose_in_hand(body.name, "fingers")
    assert np.linalg.norm(lifted[:3, 3] - closed[:3, 3]) < 1e-3
    assert np.degrees(angle_between(closed, lifted)) < 1.5
    return arm


def test_a_fork_held_by_its_neck_does_not_creep(world):
    arm = _held_by_its_neck(world, shapes.fork("fork"))
    before = arm.pose_in_hand("fork", "fingers")
    arm.wait(2.0)
    assert np.linalg.norm(arm.pose_in_hand("fork", "fingers")[:3, 3] - before[:3, 3]) < 2e-4


def test_a_spoon_held_by_its_neck_turns_with_the_hand(world):
    """Pads that it sinks into would leave it behind."""
    arm = _held_by_its_neck(world, shapes.spoon("spoon"))
    before = arm.pose_in_hand("spoon", "fingers")
    turn = np.eye(len(arm.arm.joints))[-1] * np.copysign(1.5, -arm.q_target[-1])
    arm.follow(Way.between(arm.q_target, arm.q_target + turn))
    assert np.degrees(angle_between(before, arm.pose_in_hand("spoon", "fingers"))) < 1.0


def test_hinged_fingers_open_and_close_as_fast_as_slides(world):
    """Speed and force of a jaw are those of its pads: hinges turn as fast as that takes."""
    arm = SimulatedArm(world, robot("xarm6"), np.eye(4))
    jaw = arm.jaw
    assert jaw is not None
    for opening in (0.05, 0.02, 0.08):
        way, begun = abs(arm.opening - opening), world.time
        arm.open(opening)
        assert arm.opening == pytest.approx(opening, abs=1e-3)
        assert world.time - begun < way / jaw.speed + 0.5
    assert jaw.lever("drive_joint") == pytest.approx(0.0873 / 2 / 0.85, rel=0.02)
    panda = robot("panda").jaw
    assert panda is not None and panda.lever("panda_finger_joint1") == 1.0
