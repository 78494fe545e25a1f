"""Photos for people: shadows, smooth edges, and masks that fit."""

import numpy as np
import pytest

from topple.robots.shapes import box
from topple.robots.world.camera import Camera
from topple.robots.world.photo import SIZE, photograph
from topple.robots.world.world import World

CAMERA = Camera.looking_at((0.0, -0.7, 0.6), (0.0, 0.0, 0.02))


@pytest.fixture
def world():
    with World() as world:
        world.add_table()
        pose = np.eye(4)
        pose[2, 3] = 0.05
        world.add(box("crate", (0.1, 0.1, 0.1)), pose)
        yield world


def test_a_box_throws_a_shadow_and_its_mask_fits(world):
    photo = photograph(world, CAMERA)
    assert photo.rgb.shape == (SIZE[1], SIZE[0], 3) and photo.label.shape == photo.rgb.shape[:2]
    names = {name: number for number, name in photo.names.items()}
    table = photo.rgb[photo.label == names["table"]].mean(axis=1)
    assert np.percentile(table, 1) < 0.75 * np.median(table)  # there is a shadow ...
    assert (table < 0.9 * np.median(table)).mean() < 0.5  # ... and most of the table is in the light
    share = (photo.label == names["crate"]).mean()
    assert 0.03 < share < 0.4  # framed on what can be taken


def test_edges_have_shades_between(world):
    photo = photograph(world, CAMERA)
    plain = CAMERA.picture(world)
    assert len(np.unique(photo.rgb.reshape(-1, 3), axis=0)) > 5 * len(np.unique(plain.reshape(-1, 3), axis=0))
