"""An arm that stands elsewhere than it believes is seen by the cameras; one that does not is left alone."""

from collections.abc import Iterator

import numpy as np
import pytest

from topple.benchmarks.faults.arms import Through
from topple.planner.execution.look import Look, Observer
from topple.planner.execution.standing import misplacement
from topple.robots import shapes
from topple.robots.catalog import robot
from topple.robots.scenarios.scenario import BASE, around, pose_at
from topple.robots.world.camera import Camera
from topple.robots.world.simulated_arm import SimulatedArm
from topple.robots.world.world import World
from topple.topology.base.arrays import FloatArray


class Aside(Through):
    """An arm that believes to stand elsewhere."""

    way = np.zeros(3)

    @property
    def pose_base_to_world(self) -> FloatArray:
        pose = self.inner.pose_base_to_world.copy()
        pose[:3, 3] += self.way
        return pose


@pytest.fixture(scope="module", params=["panda", "panda-suction"])
def arm(request: pytest.FixtureRequest) -> Iterator[SimulatedArm]:
    with World() as world:
        world.add_table(size=(1.4, 1.2))
        world.add(shapes.can("can"), pose_at(0.05, 0.0, 0.0))
        yield SimulatedArm(world, robot(request.param), pose_at(*BASE))


def look(arm: SimulatedArm, *cameras: Camera) -> Look:
    return Observer(arm.world, cameras, np.random.default_rng(0), ("table",)).look()


def test_three_centimetres_aside_are_seen_and_none_are_not(arm):
    for cameras in (around((0.0, 0.0, 0.03)), around((0.0, 0.0, 0.03))[:1]):
        seen, aside = look(arm, *cameras), Aside(arm, np.random.default_rng(0))
        assert misplacement(arm, seen.images, seen.scene) is None
        for way in ([0.03, 0.0, 0.0], [-0.02, 0.022, 0.0]):
            aside.way = np.array(way)
            assert "from where it should be" in str(misplacement(aside, seen.images, seen.scene))


def test_without_a_camera_that_shows_the_arm_nothing_is_said(arm):
    above = Camera.looking_at((0.15, 0.0, 0.3), (0.15, 0.0, 0.0), fov=0.5)
    seen, aside = look(arm, above), Aside(arm, np.random.default_rng(0))
    aside.way = np.array([0.03, 0.0, 0.0])
    assert misplacement(aside, seen.images, seen.scene) is None
    assert misplacement(aside, (), seen.scene) is None
