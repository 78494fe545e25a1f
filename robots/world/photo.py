"""Photos of a simulated world for people: smooth edges, soft shadows, framed on what can be taken.

The engine's software renderer gives colours, depth and masks; it draws neither smooth edges nor
shadows. Both are made of what it gives: pixels are averaged, and what is dark is told from the depth that two
lamps see.
"""

import numpy as np
from scipy.ndimage import gaussian_filter, zoom

from topple.robots.poses import inverse
from topple.robots.world.camera import Camera, Noise
from topple.robots.world.physical_world import PhysicalWorld
from topple.topology.base.arrays import FloatArray
from topple.topology.geometry.rigid import move_points
from topple.topology.views.image import Photo

SIZE = (800, 600)
"""Width and height [px]: half a page, at four pixels to three of the page."""
FINE = 2
"""Rendered this many times larger: an edge has five shades."""
ROOM = 1.5
"""Width of the picture, in widths of what can be taken: where things are put down should be in it too."""
CLOSEST = 0.35
"""Share of the camera's own view that is shown at least: nearer, round things show their corners."""
LAMPS = ((np.array([0.55, -0.75, 1.3]), 0.012, 0.38), (np.array([-0.05, 0.1, 1.0]), 0.05, 0.30))
"""Where each lamp is seen from, how wide its shadow's edge is [m], and how dark it is. The first one is the
sun; the second is the sky: what stands close takes its light away, as under the rim of a plate."""
AWAY = 2.0
"""Distance of a lamp [m]; its view is nearly parallel."""
MAP = 700
"""Width of a lamp's picture [px]: a millimetre a pixel."""
SAMPLES = 14
"""Places that are asked of a lamp for each pixel, on a spiral over the shadow's edge."""
GOLDEN = 2.39996
"""Turn from one of them to the next [rad]: the golden angle spreads them evenly."""
COARSE = 2
"""Light is worked out for one pixel of so many each way: shadows are soft."""
SMOOTH = 0.8
"""Width of the blur that evens out the grain of few samples, in these pixels."""
LIFTED = 0.004
"""How far in front of a surface something must be to darken it [m], a pixel of a lamp on a slope."""


def photograph(world: PhysicalWorld, camera: Camera, *, whole: bool = False) -> Photo:
    """Take a photo of what can be taken in a world.

    Args:
        world: The world.
        camera: Where from; its picture is framed anew.
        whole: Whether all that the camera sees is shown, not what can be taken alone.

    Returns:
        The photo, `SIZE` large.
    """
    corners = _corners(world)
    framed = _frame_camera(camera, corners[:0] if whole else corners, FINE)
    depth, body, rgb = world.rendered(framed)
    coarse = (slice(FINE // 2, None, FINE), slice(FINE // 2, None, FINE))
    height, width = SIZE[1], SIZE[0]
    colours = rgb.reshape(height, FINE, width, FINE, 3).mean(axis=(1, 3))
    light = zoom(_light(world, framed, depth[coarse][::COARSE, ::COARSE], corners), COARSE, order=1)
    names = {number + 1: name for name, number in world.ids.items()}
    label = np.where(np.isin(body[coarse] + 1, list(names)), body[coarse] + 1, 0)
    colours[depth[coarse] <= 0] = 255.0
    return Photo((colours * light[..., None]).clip(0, 255).astype(np.uint8), label, names)


def _corners(world: PhysicalWorld) -> FloatArray:
    """(N, 3) corners of everything that can be taken [m]; of everything where nothing can."""
    names = world.movable or world.names
    return np.concatenate([np.concatenate(world.parts(name)) for name in names])


def _frame_camera(camera: Camera, corners: FloatArray, fine: int) -> Camera:
    """The camera turned to nothing else, with a picture of `SIZE` that is filled by some points."""
    seen = (
        corners @ inverse(camera.pose_camera_to_world)[:3, :3].T + inverse(camera.pose_camera_to_world)[:3, 3]
    )
    seen = seen[seen[:, 2] > camera.nearest]
    width, height = SIZE[0] * fine, SIZE[1] * fine
    share = np.full(2, 1.0)
    middle = np.array([(camera.width - 1) / 2, (camera.height - 1) / 2])
    if len(seen):
        pixel = seen[:, :2] / seen[:, 2:] * np.diag(camera.K)[:2] + camera.K[:2, 2]
        low, high = pixel.min(axis=0), pixel.max(axis=0)
        middle = (low + high) / 2
        share = np.clip(ROOM * (high - low) / (camera.width, camera.height), CLOSEST, 1.0)
    scale = width / (camera.width * float(share.max()))
    K = np.eye(3)
    K[0, 0], K[1, 1] = camera.K[0, 0] * scale, camera.K[1, 1] * scale
    K[:2, 2] = (camera.K[:2, 2] - middle) * scale + ((width - 1) / 2, (height - 1) / 2)
    return Camera(
        width, height, K, camera.pose_camera_to_world, Noise.none(), camera.nearest, camera.farthest
    )


def _light(world: PhysicalWorld, camera: Camera, depth: FloatArray, corners: FloatArray) -> FloatArray:
    """(H, W) by what the colours are to be multiplied: 1 in the light of both lamps."""
    height, width = depth.shape
    row, column = np.mgrid[:height, :width] * (FINE * COARSE) + FINE / 2
    rays = np.stack(
        [
            (column - camera.K[0, 2]) / camera.K[0, 0],
            (row - camera.K[1, 2]) / camera.K[1, 1],
            np.ones_like(row),
        ],
        -1,
    )
    pose = camera.pose_camera_to_world
    points = (rays * depth[..., None]) @ pose[:3, :3].T + pose[:3, 3]
    middle = (corners.min(axis=0) + corners.max(axis=0)) / 2
    reach = 0.5 * float(np.linalg.norm(np.ptp(corners, axis=0))) + 0.15
    light = np.ones(depth.shape)
    for direction, edge, dark in LAMPS:
        shadow = _shadow(world, points.reshape(-1, 3), middle, direction, reach, edge)
        shadow = np.asarray(gaussian_filter(shadow.reshape(depth.shape), SMOOTH))
        light -= dark * np.where(depth > 0, shadow, 0.0)
    return light


def _shadow(
    world: PhysicalWorld,
    points: FloatArray,
    middle: FloatArray,
    direction: FloatArray,
    reach: float,
    edge: float,
) -> FloatArray:
    """(N,) how much of a lamp is hidden from points, 0 to 1."""
    eye = middle + AWAY * direction / np.linalg.norm(direction)
    lamp = Camera.looking_at(
        (float(eye[0]), float(eye[1]), float(eye[2])), (float(middle[0]), float(middle[1]), float(middle[2])),
        width=MAP, height=MAP, fov=2 * float(np.arctan(reach / AWAY)), noise=Noise.none(),
    )  # fmt: skip
    depth = world.rendered(lamp)[0]
    # around the map is nothing that hides anything
    nearest = np.pad(np.where(depth > 0, depth, np.inf).astype(np.float32), 1, constant_values=np.inf)
    seen = move_points(points, inverse(lamp.pose_camera_to_world)).astype(np.float32)
    scale = np.float32(lamp.K[0, 0]) / seen[:, 2]
    place = seen[:, :2] * scale[:, None] + np.float32(lamp.K[:2, 2] + 1)
    # a slope rises over the shadow's edge: what is only a little nearer may be the same surface
    limit = seen[:, 2] - np.float32(LIFTED + 0.35 * edge)
    first = np.arange(len(points), dtype=np.float32) * np.float32(GOLDEN * GOLDEN)  # else edges show as rings
    toward = np.stack([np.cos(first), np.sin(first)], axis=1) * (np.float32(edge) * scale)[:, None]
    across = toward[:, ::-1] * np.array([-1.0, 1.0], dtype=np.float32)
    hidden = np.zeros(len(points), dtype=np.float32)
    for k in range(SAMPLES):
        turn, radius = GOLDEN * k, np.sqrt((k + 0.5) / SAMPLES)
        step = np.float32(radius * np.cos(turn)) * toward + np.float32(radius * np.sin(turn)) * across
        pixel = np.rint(place + step).clip(0, len(nearest) - 1).astype(np.int32)
        hidden += nearest[pixel[:, 1], pixel[:, 0]] < limit
    return hidden / SAMPLES
