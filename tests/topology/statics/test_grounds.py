"""Nothing of a fixed body is lost as it is taken apart into tops and the rest."""

from dataclasses import replace

import numpy as np
import pytest

from topple.topology.bodies.upright import Upright
from topple.topology.scene.scene import Scene
from topple.topology.statics.contact import find_contacts
from topple.topology.statics.grounds import planes_and_rest


@pytest.mark.parametrize("noise", [0.0005, 0.005])
def test_a_floor_carries_however_rough_it_was_seen(noise):
    rng = np.random.default_rng(0)
    floor = np.column_stack([rng.uniform(-0.15, 0.15, (4000, 2)), rng.normal(0.0, noise, 4000)])
    wall = np.column_stack(
        [np.full(1000, 0.15), rng.uniform(-0.15, 0.15, 1000), rng.uniform(0.0, 0.05, 1000)]
    )
    box = rng.uniform(-0.03, 0.03, (3000, 3))
    box[np.arange(3000), rng.integers(0, 3, 3000)] = rng.choice([-0.03, 0.03], 3000)
    scene = Scene(
        {"tray": np.vstack([floor, wall]), "box": box + np.array([0.0, 0.0, 0.03])}, ["tray"], [0.0, 0.0, 1.0]
    )
    turned = Upright.of(scene)
    upright = replace(
        turned, tops={"tray": (floor @ turned.rotation.T,)}, rest={"tray": wall @ turned.rotation.T}
    )
    planes, rest = planes_and_rest(upright, "tray")
    assert (len(planes), len(rest)) == ((1, 1000) if noise < 0.003 else (0, 5000))
    assert [{one.a, one.b} for one in find_contacts(upright)] == [{"tray", "box"}]
