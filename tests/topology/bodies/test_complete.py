import numpy as np
from scipy.spatial.transform import Rotation

from topple.topology.bodies.complete import complete_body, kind_of
from topple.topology.views.free_space import FreeSpace


def test_a_bowl_seen_from_one_side_gets_its_far_wall_and_its_foot():
    rng = np.random.default_rng(0)
    angle, share = rng.uniform(-np.pi, 0, 3000), rng.uniform(0.35, 1, 3000)
    near = np.c_[0.08 * share * np.cos(angle), 0.08 * share * np.sin(angle), 0.05 * share**2]
    rim = rng.uniform(-np.pi, np.pi, 600)
    seen = np.concatenate([near, np.c_[0.08 * np.cos(rim), 0.08 * np.sin(rim), np.full(600, 0.05)]])
    whole = complete_body(seen, FreeSpace({"seen": seen}, np.array([[0.0, -0.5, 0.5]])))
    added = whole[len(seen) :]
    assert (whole[: len(seen)] == seen).all()
    assert (added[:, 1] > 0.02).any()
    assert added[:, 2].min() < 0.02
    assert np.linalg.norm(added[:, :2], axis=1).max() < 0.09


def test_what_lies_flat_and_hollow_is_a_plate_and_the_same_tilted_may_be_a_lid():
    rng = np.random.default_rng(0)
    angle, share = rng.uniform(-np.pi, np.pi, 6000), np.sqrt(rng.uniform(0, 1, 6000))
    height = 0.075 * np.maximum(share - 0.6, 0)  # a rim of 3 cm
    dish = np.c_[0.12 * share * np.cos(angle), 0.12 * share * np.sin(angle), height]
    assert kind_of(dish, None) == "plate"
    assert kind_of(Rotation.from_euler("x", 10, degrees=True).apply(dish), None) == "object"
