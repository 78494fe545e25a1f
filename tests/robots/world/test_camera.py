"""The camera sees what is there, where it is, and errs as a depth camera does."""

import numpy as np
import pybullet
import pytest

from topple.robots import shapes
from topple.robots.scenarios.scenario import pose_at
from topple.robots.world.camera import Camera, Noise
from topple.robots.world.world import World
from topple.topology.base.errors import InvalidInput

EYE, TARGET = (0.5, -0.3, 0.5), (0.0, 0.0, 0.03)


@pytest.fixture(scope="module")
def world():
    with World() as made:
        made.add_table()
        made.add(shapes.plate(), pose_at(0, 0, 0))
        made.add(shapes.can(), pose_at(0.18, 0.1, 0))
        made.add(shapes.block(), pose_at(-0.1, -0.25, 0))
        yield made


def test_an_exact_picture_agrees_with_rays(world):
    camera = Camera.looking_at(EYE, TARGET, noise=Noise.none())
    image = camera.look(world)
    rng = np.random.default_rng(0)
    rows, columns = np.nonzero(image.label)
    chosen = rng.choice(len(rows), 1500)
    rows, columns = rows[chosen], columns[chosen]
    rays = np.stack([columns, rows, np.ones(len(rows))], axis=1) @ np.linalg.inv(camera.K).T
    pose = camera.pose_camera_to_world
    ends = 3 * rays @ pose[:3, :3].T + pose[:3, 3]
    hits = pybullet.rayTestBatch(
        np.repeat(pose[None, :3, 3], len(ends), axis=0).tolist(), ends.tolist(), physicsClientId=world.client
    )
    depth = np.array([hit[2] * 3 for hit in hits])
    same = np.array([hit[0] + 1 for hit in hits]) == image.label[rows, columns]
    assert same.mean() > 0.98
    error = np.abs(depth - image.depth[rows, columns])[same]
    assert np.median(error) < 1e-4 and np.quantile(error, 0.95) < 1.5e-3


def test_clouds_lie_on_the_things_they_are_named_after(world):
    clouds = Camera.looking_at(EYE, TARGET, noise=Noise.none()).look(world).clouds()
    assert set(clouds) == {"table", "plate", "can", "block"}
    assert np.abs(clouds["table"][:, 2]).max() < 5e-3  # at the foot of a thing a pixel is of either
    radius = np.linalg.norm(clouds["can"][:, :2] - [0.18, 0.1], axis=1)
    assert radius.max() < 0.0335 and clouds["can"][:, 2].max() < 0.1015
    assert radius[clouds["can"][:, 2] < 0.095].min() > 0.0315


def test_noise_grows_with_the_distance_and_is_quantised(world):
    rng = np.random.default_rng(1)
    spread = []
    for distance in (0.6, 1.4):
        eye, below = (0.35, -0.35, distance), (0.35, -0.35, 0.0)
        exact = Camera.looking_at(eye, below, noise=Noise.none()).look(world)
        noisy = Camera.looking_at(eye, below).look(world, rng)
        table = exact.label == world.ids["table"] + 1
        both = table & (noisy.depth > 0) & (np.abs(noisy.depth - exact.depth) < 0.02)
        spread.append(float((noisy.depth - exact.depth)[both].std()))
        steps = noisy.depth[noisy.depth > 0] / 0.001
        assert np.abs(steps - np.round(steps)).max() < 1e-6
    assert spread[0] == pytest.approx(1.31e-3, rel=0.1)  # 1.28 mm, and a millimetre's rounding
    assert spread[1] == pytest.approx(3.1e-3, rel=0.1)


def test_edges_are_torn_and_the_rest_is_seen(world):
    rng = np.random.default_rng(2)
    exact = Camera.looking_at(EYE, TARGET, noise=Noise.none()).look(world)
    noisy = Camera.looking_at(EYE, TARGET).look(world, rng)
    lost = (noisy.depth == 0) & (exact.depth > 0)
    assert 0.003 < lost.mean() < 0.05
    flying = np.abs(noisy.depth - exact.depth)[(noisy.depth > 0) & (exact.label > 0)] > 0.012
    assert 0 < flying.mean() < 0.02
    np.testing.assert_array_equal(noisy.label, exact.label)


def test_the_same_seed_gives_the_same_picture(world):
    camera = Camera.looking_at(EYE, TARGET)
    pictures = [camera.look(world, np.random.default_rng(seed)).depth for seed in (3, 3, 4)]
    np.testing.assert_array_equal(pictures[0], pictures[1])
    assert (pictures[0] != pictures[2]).any()


def test_mask_noise_moves_edges_only(world):
    exact = Camera.looking_at(EYE, TARGET).look(world).label
    wrong = Camera.looking_at(EYE, TARGET).with_mask_noise(1.0, missing=0.0).look(world).label
    changed = (exact != wrong).mean()
    assert 0.0005 < changed < 0.05
    assert set(np.unique(wrong)) == set(np.unique(exact))


def test_a_robot_is_background():
    with World() as world:
        world.add_table()
        shape = pybullet.createCollisionShape(
            pybullet.GEOM_BOX, halfExtents=[0.1] * 3, physicsClientId=world.client
        )
        robot = pybullet.createMultiBody(0, shape, basePosition=[0, 0, 0.1], physicsClientId=world.client)
        world.register_robot(robot)
        image = Camera.looking_at(EYE, (0.0, 0.0, 0.1), noise=Noise.none()).look(world)
        middle = image.label[240, 320], image.depth[240, 320]
        assert middle[0] == 0 and middle[1] > 0.3
        assert set(image.names.values()) == {"table"}


@pytest.mark.parametrize("eye", [(0, 0, 1), (1, 0, 0.2), (0, -1, 0.5)])
def test_the_target_is_in_the_middle_and_up_is_up(eye):
    camera = Camera.looking_at(eye, (0, 0, 0))
    seen = np.linalg.inv(camera.pose_camera_to_world) @ [0, 0, 0, 1]
    np.testing.assert_allclose(seen[:2], 0, atol=1e-12)
    assert seen[2] == pytest.approx(np.linalg.norm(eye))
    above = np.linalg.inv(camera.pose_camera_to_world) @ [0, 0, 0.1, 1]
    assert above[1] <= 1e-12  # y points down in the picture


def test_a_camera_needs_something_to_look_at():
    with pytest.raises(InvalidInput, match="two places"):
        Camera.looking_at((1, 1, 1), (1, 1, 1))
    with pytest.raises(InvalidInput):
        Camera(640, 480, np.zeros((3, 3)), np.eye(4))


def test_mask_noise_moves_the_edges_of_masks_alone(world):
    exact = Camera.looking_at(EYE, TARGET, noise=Noise.none())
    rough = exact.with_mask_noise(1.5, missing=0.0)
    labels = exact.look(world).label, rough.look(world).label
    share = float((labels[0] != labels[1]).mean())
    assert 0.0005 < share < 0.02
    assert np.array_equal(exact.with_mask_noise(0.0).look(world).label, labels[0])
    for pixels in (-1.0, float("nan")):
        with pytest.raises(InvalidInput, match="mask noise"):
            exact.with_mask_noise(pixels)


def test_objects_whose_mask_is_missing_are_seen_without_one(world):
    exact = Camera.looking_at(EYE, TARGET, noise=Noise.none())
    true, seen = exact.look(world), exact.with_mask_noise(0.0, 1.0).look(world)
    assert set(true.clouds()) > set(seen.clouds()) and not set(world.movable) & set(seen.clouds())
    assert np.array_equal(true.depth, seen.depth)
    with pytest.raises(InvalidInput, match="missing"):
        exact.with_mask_noise(0.0, 1.5)
