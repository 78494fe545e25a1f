"""A camera that delivers no picture of now is left out and named; the others go on."""

from collections.abc import Iterator

import numpy as np
import pytest

from topple.benchmarks.faults.cameras import Dark, Late, Millimetres
from topple.planner.execution.frames import Eye, Frames
from topple.robots import shapes
from topple.robots.scenarios.scenario import pose_at
from topple.robots.world.camera import Camera, Noise
from topple.robots.world.world import World
from topple.topology.base.errors import InvalidInput


@pytest.fixture
def world() -> Iterator[World]:
    with World() as made:
        made.add_table()
        made.add(shapes.can("can"), pose_at(0.0, 0.0, 0.0))
        yield made


def camera(x: float, noise: Noise | None = None) -> Camera:
    return Camera.looking_at((x, 0.0, 0.4), (0.0, 0.0, 0.05), width=160, height=120, noise=noise)


def take(world: World, *eyes: Eye, looks: int = 2, changed: bool = True) -> tuple[int, tuple[str, ...]]:
    """How many pictures the last of some looks has, and what is said of the others."""
    frames, rng = Frames(eyes), np.random.default_rng(0)
    for _ in range(looks - 1):
        frames.take(world, rng)
    images, said = frames.take(world, rng, changed)
    return len(images), said


@pytest.mark.parametrize(
    ("spoilt", "said"),
    [
        (Dark(camera(0.6)), "camera 1 delivers nothing: it is left out"),
        (Late(camera(0.6), 1), "camera 1 delivers an old frame: it is left out"),
        (Millimetres(camera(0.6)), "camera 1 is left out: depth reaches"),
    ],
)
def test_one_that_goes_wrong_is_left_out_and_named(world, spoilt, said):
    left, (text,) = take(world, spoilt, camera(-0.6))
    assert left == 1
    assert text.startswith(said)


def test_cameras_that_do_not_go_wrong_are_all_taken(world):
    assert take(world, camera(0.6), camera(-0.6)) == (2, ())


def test_without_any_that_delivers_it_is_said_why(world):
    with pytest.raises(InvalidInput, match=r"none of 1 cameras .*camera 1 delivers nothing"):
        take(world, Dark(camera(0.6)))
    with pytest.raises(InvalidInput, match="camera 1 delivers an old frame"):
        take(world, Late(camera(0.6), 1))


def test_cameras_without_noise_may_see_the_same_again_where_nothing_was_moved(world):
    exact = camera(0.6, Noise.none()), camera(-0.6, Noise.none())
    assert take(world, *exact, changed=False) == (2, ())
