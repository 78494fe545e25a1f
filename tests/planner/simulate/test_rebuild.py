"""Scenes rebuilt from clouds stay as they were."""

from collections.abc import Mapping

import numpy as np
import pytest

from topple.planner.simulate.rebuild import Rebuilt, rebuild
from topple.robots import shapes
from topple.robots.scenarios.scenario import pose_at
from topple.robots.world.bodies import Body
from topple.robots.world.camera import Camera
from topple.robots.world.world import World
from topple.topology.base.arrays import FloatArray
from topple.topology.scene.cloud import clean
from topple.topology.scene.scene import Scene
from topple.topology.statics.rest import Statics

CAMERAS = ((0.45, 0.3, 0.5), (-0.5, 0.2, 0.5), (0.05, -0.55, 0.5))


def _seen(bodies: Mapping[Body, FloatArray], cameras: int) -> Scene:
    """What some cameras see of bodies at rest on a table."""
    with World() as world:
        world.add_table(size=(0.6, 0.6))
        for body, pose in bodies.items():
            world.add(body, pose)
        world.settle(2.0)
        rng = np.random.default_rng(0)
        images = [Camera.looking_at(eye, (0, 0, 0.03)).look(world, rng) for eye in CAMERAS[:cameras]]
    scene = Scene.from_images(images, fixed=["table"], up=(0, 0, 1))
    clouds = {name: clean(points) for name, points in scene.clouds.items()}
    return Scene(clouds, ["table"], (0, 0, 1), scene.viewpoints)


def _shifts(rebuilt: Rebuilt, seconds: float = 2.0) -> dict[str, float]:
    """How far each body moves in a world of its own [m]."""
    with World() as world:
        rebuilt.fill(world)
        before = world.poses()
        world.step(round(seconds / world.time_step))
        return {
            name: float(np.linalg.norm((world.pose(name) - pose)[:3, 3])) for name, pose in before.items()
        }


@pytest.mark.parametrize("kind", ["box", "bowl", "mug", "plate"])
def test_a_thing_seen_from_above_stands_on_the_table(kind):
    made = getattr(shapes, kind)(kind)
    rebuilt = rebuild(Statics.of(_seen({made: np.eye(4)}, 1)))
    body, pose = rebuilt.bodies[kind], rebuilt.poses[kind]
    assert body.lower[2] + pose[2, 3] == pytest.approx(0.0, abs=1e-3)
    assert body.upper[2] + pose[2, 3] == pytest.approx(made.upper[2], abs=0.006)
    assert _shifts(rebuilt)[kind] < 0.01


@pytest.mark.slow
def test_things_in_and_on_each_other_stay_where_they_are():
    stack: dict[Body, FloatArray] = {
        shapes.bowl("bowl"): np.eye(4),
        shapes.lemon("lemon"): pose_at(0.01, 0, 0.008),
        shapes.box("low", (0.1, 0.1, 0.05)): pose_at(0.16, 0, 0),
        shapes.can("high", diameter=0.06, height=0.08): pose_at(0.16, 0.01, 0.05),
    }
    for cameras in (1, 3):
        rebuilt = rebuild(Statics.of(_seen(stack, cameras)))
        assert max(_shifts(rebuilt).values()) < 0.01
        assert len(rebuilt.bodies["bowl"].parts) > 8


def test_an_arm_above_a_table_that_is_seen_stays_in_the_air():
    rng = np.random.default_rng(0)
    foot = shapes.block(side=0.06).surface(2500, rng)
    arm = shapes.bar(size=(0.16, 0.03, 0.02)).surface(1500, rng) + np.array([0.1, 0, 0.04])
    x, y = np.meshgrid(np.linspace(-0.2, 0.3, 120), np.linspace(-0.2, 0.2, 100))
    table = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    scene = Scene({"crane": np.concatenate([foot, arm]), "table": table}, fixed=["table"], up=(0, 0, 1))
    rebuilt = rebuild(Statics.of(scene))
    pose = rebuilt.poses["crane"]
    corners = np.concatenate(rebuilt.bodies["crane"].parts) + pose[:3, 3]
    assert corners[:, 2].min() == pytest.approx(0.0, abs=1e-3)
    assert rebuilt.bodies["crane"].mass > 0
