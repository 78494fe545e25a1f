"""What is seen of a staged scene: few depth images, or whole surfaces."""

from collections.abc import Mapping

import numpy as np

from topple.benchmarks.paper.rgbd_layouts import WALLS
from topple.benchmarks.paper.truth import RGBD, SCENES
from topple.robots.world.camera import Camera
from topple.robots.world.world import World
from topple.topology.base.arrays import FloatArray
from topple.topology.base.values import FrozenDict
from topple.topology.scene.scene import Scene
from topple.topology.views.image import DepthImage

POINTS = 10_000
"""Points of a whole surface: one every 2 mm to 4 mm."""
GROUND_POINTS = 20_000
"""Points of the table around the objects."""
NOISE = 0.0003
"""Standard deviation of a whole surface's points along each axis [m]: that of merged close-up scans."""
AROUND = 0.08
"""Table kept beyond the objects [m]."""

FEW = "few views"
WHOLE = "whole surfaces"
ONE = "1 view"
THREE = "3 views"

_AZIMUTHS: Mapping[int, tuple[float, float]] = FrozenDict(
    {1: (-20, 130), 2: (-100, 50), 3: (15, 75), 4: (-25, 25), 5: (-20, 130), 6: (-40, 120), 7: (20, 170)}
)
"""Where the two cameras of scenes 1 to 7 stand [degrees]. The paper has images of all sides but of scenes 3,
near a corner, and 4."""


def looks_at(number: int) -> tuple[str, ...]:
    """The ways a scene is looked at."""
    return (FEW,) if number in RGBD else (WHOLE, ONE, THREE)


def look(world: World, number: int, how: str, rng: np.random.Generator) -> Scene:
    """See a staged scene.

    Args:
        world: The settled world.
        number: Of the scene.
        how: `FEW`, `WHOLE`, `ONE` or `THREE`.
        rng: Where samples and the cameras' faults come from.

    Returns:
        The scene, with `up`, and viewpoints where cameras look; what none of them sees is absent.
    """
    if how == WHOLE:
        return _whole(world, number, rng)
    if how == FEW:
        azimuths = _AZIMUTHS[number]
    else:
        first = rng.uniform(0, 360)
        azimuths = tuple(first + 120 * k for k in range(1 if how == ONE else 3))
    images = [_image(world, azimuth, rng) for azimuth in azimuths]
    return Scene.from_images(images, fixed=[SCENES[number].ground], up=(0, 0, 1))


def camera_at(azimuth: float) -> Camera:
    """A Kinect 0.9 m from the middle, 38 degrees above the ground, in a direction [degrees]."""
    angle = np.radians(azimuth)
    return Camera.looking_at((0.7 * float(np.cos(angle)), 0.7 * float(np.sin(angle)), 0.6), (0.0, 0.0, 0.05))


def _image(world: World, azimuth: float, rng: np.random.Generator) -> DepthImage:
    """A depth image in which walls are background."""
    seen = camera_at(azimuth).look(world, rng)
    walls = [label for label, name in seen.names.items() if name in WALLS]
    return DepthImage(
        depth=seen.depth,
        K=seen.K,
        label=np.where(np.isin(seen.label, walls), 0, seen.label),
        pose_camera_to_world=seen.pose_camera_to_world,
        names={label: name for label, name in seen.names.items() if label not in walls},
        rgb=seen.rgb,
    )


def _whole(world: World, number: int, rng: np.random.Generator) -> Scene:
    """Clouds of the whole surfaces, bottoms and insides too, as models stitched from all sides have."""
    scene = SCENES[number]
    clouds: dict[str, FloatArray] = {}
    for name in scene.objects[1:]:
        pose = world.pose(name)
        points = world.body(name).surface(POINTS, rng) @ pose[:3, :3].T + pose[:3, 3]
        clouds[name] = points + rng.normal(0, NOISE, points.shape)
    everything = np.concatenate(list(clouds.values()))
    lower, upper = everything[:, :2].min(axis=0) - AROUND, everything[:, :2].max(axis=0) + AROUND
    ground = np.column_stack([rng.uniform(lower, upper, (GROUND_POINTS, 2)), np.zeros(GROUND_POINTS)])
    ground += rng.normal(0, NOISE, ground.shape)
    return Scene({scene.ground: ground, **clouds}, fixed=[scene.ground], up=(0, 0, 1))
