"""Small motions between two looks: found where they are, and none where nothing moved."""

import numpy as np
from scipy.spatial.transform import Rotation

from topple.planner.look import STIRRED, Observer
from topple.planner.stir import shift
from topple.robots import shapes
from topple.robots.camera import Camera
from topple.robots.scenarios.scenario import pose_at
from topple.robots.world import World
from topple.topology.arrays import FloatArray

EYES = (
    Camera.looking_at((0.7, 0.0, 0.4), (0.0, 0.0, 0.05)),
    Camera.looking_at((-0.4, 0.6, 0.4), (0.0, 0.0, 0.05)),
)
BODIES = {
    "box": shapes.box("box", (0.05, 0.08, 0.12)),
    "can": shapes.can("can"),
    "plate": shapes.plate("plate"),
    "bar": shapes.bar("bar", (0.18, 0.03, 0.03)),
}


def _moved(name: str, pose: FloatArray, cameras: int) -> bool:
    """Whether cameras tell that a body was brought from where it stood to a pose."""
    with World() as world:
        world.add_table()
        world.add(BODIES[name], pose_at(0.0, 0.0, 0.0))
        told = Observer(world, EYES[:cameras], np.random.default_rng(0), ("table",)).watch()
        world.place(name, pose)
        return told() == (name,)


def test_what_stays_in_place_did_not_move() -> None:
    for name in BODIES:
        for cameras in (1, 2):
            assert not _moved(name, pose_at(0.0, 0.0, 0.0), cameras), (name, cameras)


def test_what_is_raised_or_tipped_by_a_few_millimetres_moved() -> None:
    tipped = pose_at(0.0, 0.0, 0.004)
    tipped[:3, :3] = Rotation.from_euler("x", 8, degrees=True).as_matrix()
    for name in BODIES:
        assert _moved(name, pose_at(0.0, 0.0, 0.005), 1), name
        assert _moved(name, tipped, 2), name


def test_a_way_is_measured_to_a_millimetre() -> None:
    points = BODIES["box"].surface(6000, np.random.default_rng(1))
    noisy = points + np.random.default_rng(2).normal(0.0, 0.001, points.shape)
    found = shift(points, noisy + np.array([0.005, 0.0, 0.003]))
    assert found is not None and abs(found - np.hypot(0.005, 0.003)) < 0.001
    assert found > STIRRED


def test_too_little_to_tell_is_not_told() -> None:
    assert shift(np.zeros((3, 3)), np.zeros((3, 3))) is None
