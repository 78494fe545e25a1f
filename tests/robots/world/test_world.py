"""The world keeps the laws: things stand, slide, roll and fall as they should, and touch where they touch."""

import numpy as np
import pybullet
import pytest
from scipy.spatial.transform import Rotation

from topple.robots import shapes
from topple.robots.scenarios.scenario import pose_at
from topple.robots.world.world import World, principal_axes
from topple.topology.base.errors import InvalidInput, UnknownObject


@pytest.mark.parametrize("kind", ["plate", "bowl", "mug", "can", "tray", "block", "spoon", "fork", "banana"])
def test_a_thing_rests_on_the_table_without_a_gap(kind):
    with World() as world:
        world.add_table()
        world.add(getattr(shapes, kind)(), pose_at(0, 0, 0.002))
        assert world.settle()
        lowest = min(part[:, 2].min() for part in world.parts(kind))
        assert abs(lowest) < 3e-4
        assert {(c.a, c.b) for c in world.contacts()} <= {("table", kind), (kind, "table")}
        weight = sum(contact.force * abs(contact.normal[2]) for contact in world.contacts())
        assert weight == pytest.approx(world.body(kind).mass * 9.81, rel=0.1)


def test_plates_nest_and_stay():
    with World() as world:
        world.add_table()
        for k in range(3):
            world.add(shapes.plate(f"plate_{k}"), pose_at(0, 0, 0.001 + 0.02 * k))
        assert world.settle()
        before = world.poses()
        world.step(240)
        for name, pose in world.poses().items():
            assert np.abs(pose - before[name])[:3, 3].max() < 1e-3
        top = world.pose("plate_2")[2, 3]
        assert 0.012 < top < 0.015  # each lies 6.5 mm above the one below: wells nest


def test_a_ball_falls_as_galileo_says():
    with World() as world:
        world.add(shapes.ball(), pose_at(0, 0, 1.0))
        world.step(96)
        fallen = 1.0 - world.pose("ball")[2, 3]
        assert fallen == pytest.approx(9.81 * world.time**2 / 2, rel=0.03)


@pytest.mark.parametrize(("slope", "slides"), [(25, False), (36, True)])
def test_friction_holds_up_to_its_angle(slope, slides):
    turn = Rotation.from_euler("y", slope, degrees=True)  # 0.7 times 0.85: 31 degrees
    with World() as world:
        ramp = shapes.box("ramp", (0.8, 0.4, 0.02))
        world.add(ramp, pose_at(0, 0, 0, turn), fixed=True)
        pybullet.changeDynamics(world.ids["ramp"], -1, lateralFriction=0.85, physicsClientId=world.client)
        place = turn.apply([0, 0, 0.0202])
        world.add(shapes.box("box", (0.1, 0.1, 0.03)), pose_at(*place, turn))
        start = world.pose("box")[:3, 3]
        world.step(120)
        moved = np.linalg.norm(world.pose("box")[:3, 3] - start)
        assert (moved > 0.02) == slides


def test_a_rolling_can_comes_to_rest():
    with World() as world:
        world.add_table(size=(4.0, 1.0))
        world.add(shapes.can(), pose_at(-1, 0.05, 0.0332, Rotation.from_euler("x", 90, degrees=True)))
        pybullet.resetBaseVelocity(world.ids["can"], [0.3, 0, 0], [0, 9, 0], physicsClientId=world.client)
        assert world.settle(12.0)
        assert 0.1 < world.pose("can")[0, 3] + 1 < 1.5


def test_pose_is_that_of_the_body_frame_not_of_its_centre_of_mass():
    turn = Rotation.from_euler("xyz", [0.3, -0.7, 1.1])
    for body in (shapes.mug(), shapes.banana(), shapes.strawberry()):
        with World() as world:
            pose = pose_at(0.1, -0.2, 0.4, turn)
            world.add(body, pose)
            np.testing.assert_allclose(world.pose(body.name), pose, atol=1e-9)
            world.place(body.name, np.eye(4))
            np.testing.assert_allclose(world.pose(body.name), np.eye(4), atol=1e-9)


def test_inertia_in_the_simulation_is_the_bodys():
    mug = shapes.mug()
    moments, pose_inertial_to_body = principal_axes(mug)
    axes = pose_inertial_to_body[:3, :3]
    np.testing.assert_allclose(axes @ np.diag(moments) @ axes.T, mug.inertia, atol=0.011 * moments.min())
    with World() as world:
        world.add(mug)
        told = pybullet.getDynamicsInfo(world.ids["mug"], -1, physicsClientId=world.client)
        assert told[0] == pytest.approx(mug.mass)
        np.testing.assert_allclose(told[2], moments, rtol=1e-6)


def test_a_snapshot_brings_back_poses_and_time():
    with World() as world:
        world.add_table()
        world.add(shapes.can(), pose_at(0, 0, 0.1))
        world.step(10)
        kept, before = world.snapshot(), world.pose("can")
        world.step(200)
        first = world.pose("can")
        world.restore(kept)
        np.testing.assert_array_equal(world.pose("can"), before)
        assert world.time == kept.time
        world.step(200)
        np.testing.assert_allclose(world.pose("can"), first, atol=1e-4)
        world.add(shapes.plum(), pose_at(0.3, 0, 0.1))
        with pytest.raises(InvalidInput, match="plum came or went"):
            world.restore(kept)


def test_what_falls_off_the_table_lands_on_a_floor_and_is_no_object():
    with World() as world:
        world.add_table(size=(0.4, 0.4))
        world.add(shapes.block(), pose_at(0.5, 0, 0.1))
        assert world.settle(4.0)
        assert world.pose("block")[2, 3] == pytest.approx(-0.75, abs=0.05)
        assert world.contacts() == []
        assert world.names == ("table", "block") and world.movable == ("block",)


def test_worlds_do_not_see_each_other():
    with World() as one, World() as other:
        one.add_table()
        one.add(shapes.can(), pose_at(0, 0, 0))
        other.add(shapes.can(), pose_at(0, 0, 0))
        one.step(100)
        other.step(100)
        assert abs(one.pose("can")[2, 3]) < 1e-3
        assert other.pose("can")[2, 3] < -0.5


def test_names_are_unique_known_and_forgotten():
    with World() as world:
        world.add(shapes.can())
        with pytest.raises(InvalidInput, match="two bodies are called 'can'"):
            world.add(shapes.can())
        with pytest.raises(UnknownObject, match="mug"):
            world.pose("mug")
        number = world.ids["can"]
        assert world.name_of(number) == "can"
        world.remove("can")
        assert world.names == () and world.name_of(number) is None
        world.add(shapes.can())


def test_the_same_scene_runs_the_same_way_twice():
    def run() -> np.ndarray:
        with World() as world:
            world.add_table()
            world.add(shapes.bowl(), pose_at(0, 0, 0))
            world.add(shapes.orange(), pose_at(0.01, 0.02, 0.08))
            world.step(200)
            return world.pose("orange")

    np.testing.assert_array_equal(run(), run())
