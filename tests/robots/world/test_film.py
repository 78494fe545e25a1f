"""A film shows what the camera saw while the arm moved."""

from pathlib import Path

import numpy as np
import pytest

from topple.robots.catalog import robot
from topple.robots.shapes import box
from topple.robots.world.camera import Camera
from topple.robots.world.film import RATE, SIZE, Film
from topple.robots.world.simulated_arm import SimulatedArm
from topple.robots.world.world import World
from topple.topology.base.errors import InvalidInput

av = pytest.importorskip("av", reason="films need PyAV (dev extra)")

CAMERA = Camera.looking_at((1.2, 0.6, 0.9), (0.2, 0.0, 0.2))


def _pictures(path: Path) -> list[np.ndarray]:
    with av.open(str(path)) as film:
        return [frame.to_ndarray(format="rgb24").astype(float) for frame in film.decode(video=0)]


@pytest.mark.slow
def test_a_film_has_a_picture_for_every_tick_and_shows_the_motion(tmp_path):
    with World() as world:
        world.add_table()
        world.add(box("box", (0.1, 0.1, 0.1)), np.eye(4))
        arm = SimulatedArm(world, robot("panda"), np.eye(4))
        with Film(tmp_path / "out.mp4", arm, CAMERA):
            arm.wait(0.5)
            arm.q_target = np.add(arm.q_target, [0.8, 0, 0, 0, 0, 0, 0])
            arm.wait(1.0)
    pictures = _pictures(tmp_path / "out.mp4")
    assert abs(len(pictures) - 1.5 * RATE) <= 2
    assert pictures[0].shape == (SIZE[1], SIZE[0], 3)
    assert np.abs(pictures[-1] - pictures[0]).mean() > 1.0  # the arm turned
    assert np.abs(pictures[1] - pictures[0]).mean() < 1.0  # it stood still before
    assert list(tmp_path.iterdir()) == [tmp_path / "out.mp4"]


def test_what_was_filmed_until_an_error_is_there(tmp_path):
    with World() as world:
        world.add_table()
        arm = SimulatedArm(world, robot("panda"), np.eye(4))
        with pytest.raises(KeyboardInterrupt), Film(tmp_path / "out.mp4", arm, CAMERA):
            arm.wait(0.3)
            raise KeyboardInterrupt
    assert len(_pictures(tmp_path / "out.mp4")) >= 3
    assert arm.on_step == []


def test_a_folder_that_is_not_there_is_said(tmp_path):
    with World() as world:
        arm = SimulatedArm(world, robot("panda"), np.eye(4))
        with pytest.raises(InvalidInput, match="its folder does not exist"):
            Film(tmp_path / "none" / "out.mp4", arm, CAMERA)
