"""Clouds of any PyBullet world lie on its surfaces and carry its names."""

import numpy as np
import pybullet
import pytest

from topple.robots import scene_from_world, shapes
from topple.robots.scenarios.scenario import pose_at
from topple.robots.world.world import World
from topple.topology.base.errors import InvalidInput, UnknownObject


@pytest.fixture
def client():
    number = pybullet.connect(pybullet.DIRECT)
    yield number
    pybullet.disconnect(number)


def primitive(
    client: int, kind: int, place: tuple[float, float, float], mass: float = 1.0, **size: object
) -> int:
    shape = pybullet.createCollisionShape(kind, physicsClientId=client, **size)
    return pybullet.createMultiBody(mass, shape, basePosition=place, physicsClientId=client)


def test_primitives_are_sampled_on_their_surfaces_from_all_sides(client):
    primitive(client, pybullet.GEOM_PLANE, (0, 0, 0), 0.0)
    ball = primitive(client, pybullet.GEOM_SPHERE, (0, 0, 0.05), radius=0.05)
    box = primitive(client, pybullet.GEOM_BOX, (0.2, 0, 0.03), halfExtents=[0.04, 0.02, 0.03])
    scene = scene_from_world(client, names={ball: "ball", box: "box"})
    assert scene.names == ("body_0", "ball", "box")
    assert scene.fixed == {"body_0"}
    ball_points = scene.clouds["ball"] - [0, 0, 0.05]
    np.testing.assert_allclose(np.linalg.norm(ball_points, axis=1), 0.05, atol=1e-3)
    assert (ball_points[:, 2] < -0.045).any() and (ball_points[:, 2] > 0.045).any()
    np.testing.assert_allclose(scene.clouds["box"].min(axis=0), [0.16, -0.02, 0.0], atol=2e-3)
    np.testing.assert_allclose(scene.clouds["box"].max(axis=0), [0.24, 0.02, 0.06], atol=2e-3)
    assert np.ptp(scene.clouds["body_0"], axis=0)[:2].max() < 1.5  # the endless plane is cut to a patch
    assert np.abs(scene.clouds["body_0"][:, 2]).max() < 1e-3


def test_a_body_of_two_links_is_one_object(client):
    shape = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[0.03] * 3, physicsClientId=client)
    pybullet.createMultiBody(
        1.0, shape, linkMasses=[1.0], linkCollisionShapeIndices=[shape], linkVisualShapeIndices=[-1],
        linkPositions=[[0.2, 0, 0]], linkOrientations=[[0, 0, 0, 1]], linkInertialFramePositions=[[0, 0, 0]],
        linkInertialFrameOrientations=[[0, 0, 0, 1]], linkParentIndices=[0],
        linkJointTypes=[pybullet.JOINT_FIXED], linkJointAxis=[[0, 0, 1]], physicsClientId=client,
    )  # fmt: skip
    (cloud,) = scene_from_world(client).clouds.values()
    assert cloud[:, 0].min() == pytest.approx(-0.03, abs=2e-3)
    assert cloud[:, 0].max() == pytest.approx(0.23, abs=2e-3)
    assert not ((cloud[:, 0] > 0.04) & (cloud[:, 0] < 0.16)).any()


def test_a_bowl_is_hollow_and_what_is_in_it_is_seen():
    with World() as world:
        world.add_table()
        world.add(shapes.bowl(), pose_at(0, 0, 0))
        world.add(shapes.plum(), pose_at(0, 0, 0.006))
        scene = scene_from_world(world.client, names={number: name for name, number in world.ids.items()})
    assert {"table", "bowl", "plum"} <= set(scene.names)
    inner = scene.clouds["bowl"][np.linalg.norm(scene.clouds["bowl"][:, :2], axis=1) < 0.06]
    assert inner[:, 2].max() < 0.03
    assert scene.clouds["plum"][:, 2].max() == pytest.approx(0.055, abs=2e-3)
    assert "table" in scene.fixed and "plum" not in scene.fixed


def test_names_are_unique_and_some_can_be_left_out(client):
    first = primitive(client, pybullet.GEOM_SPHERE, (0, 0, 0), radius=0.05)
    second = primitive(client, pybullet.GEOM_SPHERE, (0.3, 0, 0), radius=0.05)
    assert scene_from_world(client, names={first: "ball", second: "ball"}).names == ("ball", "ball_1")
    assert scene_from_world(client, ignore=[first]).names == ("body_1",)
    assert scene_from_world(client, fixed=["body_0"]).fixed == {"body_0"}
    with pytest.raises(UnknownObject, match="shelf"):
        scene_from_world(client, fixed=["shelf"])


def test_an_empty_world_is_refused(client):
    with pytest.raises(InvalidInput, match="no bodies"):
        scene_from_world(client)


def test_masses_and_friction_are_those_of_the_world(client):
    primitive(client, pybullet.GEOM_PLANE, (0, 0, 0), 0.0)
    box = primitive(client, pybullet.GEOM_BOX, (0.2, 0, 0.03), 1.5, halfExtents=[0.04, 0.02, 0.03])
    rough = primitive(client, pybullet.GEOM_BOX, (0.4, 0, 0.03), 0.2, halfExtents=[0.04, 0.02, 0.03])
    pybullet.changeDynamics(box, -1, lateralFriction=0.3, physicsClientId=client)
    pybullet.changeDynamics(rough, -1, lateralFriction=50.0, physicsClientId=client)
    scene = scene_from_world(client, names={box: "box", rough: "rough"})
    assert scene.masses == {"box": 1.5, "rough": 0.2}, "what has no mass never moves"
    assert scene.friction == {"body_0": 0.5, "box": 0.3, "rough": 10.0}
    assert any("friction of 'rough', 50, is taken as 10" in line for line in scene.assumptions)


def test_a_body_weighs_what_its_links_weigh(client):
    shape = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[0.03] * 3, physicsClientId=client)
    body = pybullet.createMultiBody(
        1.0, shape, linkMasses=[0.5], linkCollisionShapeIndices=[shape], linkVisualShapeIndices=[-1],
        linkPositions=[[0.2, 0, 0]], linkOrientations=[[0, 0, 0, 1]], linkInertialFramePositions=[[0, 0, 0]],
        linkInertialFrameOrientations=[[0, 0, 0, 1]], linkParentIndices=[0],
        linkJointTypes=[pybullet.JOINT_FIXED], linkJointAxis=[[0, 0, 1]], physicsClientId=client,
    )  # fmt: skip
    assert list(scene_from_world(client).masses.values()) == [1.5]
    pybullet.changeDynamics(body, 0, lateralFriction=0.9, physicsClientId=client)
    scene = scene_from_world(client)
    assert scene.friction == {}
    assert any("differ in friction" in line for line in scene.assumptions)


def test_the_masses_of_a_world_of_topples_own_are_read_too():
    with World() as world:
        world.add_table()
        world.add(shapes.box("box", (0.06, 0.06, 0.06), mass=0.9), pose_at(0, 0, 0))
        scene = scene_from_world(world.client, names={number: name for name, number in world.ids.items()})
    assert scene.masses["box"] == pytest.approx(0.9)
    assert scene.friction["box"] == pytest.approx(0.7)
