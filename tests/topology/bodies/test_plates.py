import numpy as np

from topple.robots.shapes.boxes import tray
from topple.topology.bodies.plates import plates_of
from topple.topology.geometry.hull import Hull
from topple.topology.geometry.thin import voxel_means

UP = np.array([0.0, 0.0, 1.0])


def noisy(points: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    return points + rng.normal(0, 0.0015, points.shape)


def test_a_bin_is_a_floor_and_four_walls_and_room_between_them():
    rng = np.random.default_rng(0)
    cloud = noisy(tray("bin", (0.26, 0.18, 0.05)).surface(5000, rng), rng)
    strays = rng.uniform([-0.1, -0.06, 0.015], [0.1, 0.06, 0.05], (15, 3))
    plates = plates_of(np.concatenate([cloud, strays]), 0.008, UP)
    assert len(plates) == 5
    assert all(np.sort(np.ptp(plate, axis=0))[0] < 0.016 for plate in plates)
    room = np.stack(np.meshgrid([-0.1, 0.0, 0.1], [-0.06, 0.0, 0.06], [0.025, 0.05]), axis=-1).reshape(-1, 3)
    for plate in map(Hull.of, plates):
        assert ((room @ plate.normals.T + plate.offsets).max(axis=1) > 0).all()


def test_what_is_not_flat_is_cut_into_convex_parts_and_strays_alone_are_nothing():
    rng = np.random.default_rng(1)
    ball = rng.normal(size=(2000, 3))
    ball *= 0.05 / np.linalg.norm(ball, axis=1, keepdims=True)
    parts = plates_of(ball, 0.008, UP)
    assert np.concatenate(parts).max() < 0.051 and np.concatenate(parts).min() > -0.051
    assert plates_of(rng.uniform(-1, 1, (30, 3)), 0.008, UP) == ()


def test_the_rim_of_a_tray_is_no_lid_on_it():
    body = tray("tray", (0.34, 0.24, 0.03))
    room = np.stack(np.meshgrid([-0.12, 0.0, 0.12], [-0.08, 0.0, 0.08], [0.024]), axis=-1).reshape(-1, 3)
    for seed in range(3):
        rng = np.random.default_rng(seed)
        cloud = body.surface(6000, rng) + rng.normal(0, 0.002, (6000, 3))
        rim = voxel_means(cloud[cloud[:, 2] > 0.02], 0.006)  # a level plane has more of these than a wall
        plates = plates_of(rim, 0.008, UP)
        assert len(plates) >= 4
        for plate in map(Hull.of, plates):
            assert ((room @ plate.normals.T + plate.offsets).max(axis=1) > 0).all()
