"""Scenes made for tests without an engine: boxes on a table, whole or as depth cameras see them; bowls."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from topple.topology.base.arrays import FloatArray
from topple.topology.relations.relate import Relations
from topple.topology.scene.scene import Scene
from topple.topology.views.image import DepthImage

UP = np.array([0.0, 0.0, 1.0])
EYES = np.array([[0.55, -0.25, 0.6], [-0.45, -0.35, 0.65], [0.05, 0.6, 0.55]])
"""Where cameras stand [m]."""
PIXELS = (160, 120)
FOCAL = 190.0
HALF_TABLE = 0.35


@dataclass(frozen=True, eq=False)
class Box:
    """A box turned about the vertical: (3,) centre [m], (3,) edges [m], yaw [rad]."""

    centre: FloatArray
    size: FloatArray
    yaw: float

    def local(self, vectors: FloatArray) -> FloatArray:
        """Vectors (N, 3) of the world in the box's axes."""
        return vectors @ Rotation.from_euler("z", self.yaw).as_matrix()

    def depths(self, eye: FloatArray, rays: FloatArray) -> FloatArray:
        """(N,) how many rays (N, 3) from an eye it is away, infinite where they miss it (slab method)."""
        start, along = self.local((eye - self.centre)[None])[0], self.local(rays)
        with np.errstate(divide="ignore"):
            ends = np.stack([(-side * self.size / 2 - start) / along for side in (1.0, -1.0)])
        enter, leave = ends.min(axis=0).max(axis=1), ends.max(axis=0).min(axis=1)
        return np.where((enter <= leave) & (enter > 0), enter, np.inf)

    def surface(self, rng: np.random.Generator, count: int) -> FloatArray:
        """(count, 3) points all over it [m]."""
        area = np.array([np.prod(np.delete(self.size, k)) for k in range(3)])
        axis = rng.choice(3, count, p=area / area.sum())
        points = rng.uniform(-1, 1, (count, 3))
        points[np.arange(count), axis] = np.sign(points[np.arange(count), axis])
        turn = Rotation.from_euler("z", self.yaw).as_matrix()
        return points * self.size / 2 @ turn.T + self.centre


def pile(rng: np.random.Generator, count: int = 5) -> dict[str, Box]:
    """Boxes that stand on the table or on each other, beside each other or apart."""
    boxes: list[Box] = []
    for _ in range(count):
        size = rng.uniform(0.04, 0.1, 3)
        below = boxes[rng.integers(len(boxes))] if boxes and rng.random() < 0.5 else None
        height = 0.0 if below is None else below.centre[2] + below.size[2] / 2
        place = rng.uniform(-0.14, 0.14, 2) if below is None else below.centre[:2] + rng.normal(0, 0.02, 2)
        box = Box(np.array([*place, height + size[2] / 2]), size, rng.uniform(0, np.pi))
        reach = [np.linalg.norm((box.size + other.size)[:2]) / 2 for other in boxes]
        level = [abs(box.centre[2] - other.centre[2]) < (box.size + other.size)[2] / 2 for other in boxes]
        far = [np.linalg.norm((box.centre - other.centre)[:2]) for other in boxes]
        if all(not same or d > 0.8 * r for d, r, same in zip(far, reach, level, strict=True)):
            boxes.append(box)
    return {f"box {number}": box for number, box in enumerate(boxes)}


def look(
    boxes: dict[str, Box], eye: FloatArray, rng: np.random.Generator, noise: float = 0.001
) -> DepthImage:
    """What a depth camera at a place sees of boxes on a table; it looks at the middle of the table."""
    forward = np.array([0.0, 0.0, 0.05]) - eye
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, UP)
    right /= np.linalg.norm(right)
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = np.stack([right, np.cross(forward, right), forward], axis=1), eye
    width, height = PIXELS
    K = np.array([[FOCAL, 0, (width - 1) / 2], [0, FOCAL, (height - 1) / 2], [0, 0, 1.0]])
    rows, columns = np.indices((height, width))
    pixels = np.stack([columns.ravel(), rows.ravel(), np.ones(width * height)], axis=1)
    rays = pixels @ np.linalg.inv(K).T @ pose[:3, :3].T
    with np.errstate(divide="ignore"):
        ground = np.where(rays[:, 2] < 0, -eye[2] / rays[:, 2], np.inf)
    off = np.abs(eye + np.where(np.isfinite(ground), ground, 0.0)[:, None] * rays)[:, :2].max(axis=1)
    depths = np.stack(
        [np.where(off < HALF_TABLE, ground, np.inf)] + [b.depths(eye, rays) for b in boxes.values()]
    )
    depth, label = depths.min(axis=0), depths.argmin(axis=0) + 1
    seen = np.isfinite(depth)
    depth = np.where(seen, depth + rng.normal(0, noise, depth.shape), 0.0)
    names = dict(enumerate(["table", *boxes], start=1))
    shape = (height, width)
    return DepthImage(depth.reshape(shape), K, np.where(seen, label, 0).reshape(shape), pose, names)


def whole(boxes: dict[str, Box], rng: np.random.Generator, count: int = 2500) -> Scene:
    """Boxes on a table as whole surfaces."""
    table = np.c_[rng.uniform(-HALF_TABLE, HALF_TABLE, (4000, 2)), rng.normal(0, 3e-4, 4000)]
    clouds = {name: box.surface(rng, count) + rng.normal(0, 3e-4, (count, 3)) for name, box in boxes.items()}
    return Scene({"table": table, **clouds}, fixed=["table"], up=UP)


def seen(boxes: dict[str, Box], rng: np.random.Generator, cameras: int, images: bool = True) -> Scene:
    """Boxes on a table as cameras see them; without their images only clouds and where the cameras stand."""
    scene = Scene.from_images([look(boxes, eye, rng) for eye in EYES[:cameras]], fixed=["table"], up=UP)
    return scene if images else Scene(scene.clouds, ["table"], UP, scene.viewpoints)


def bowl(
    rng: np.random.Generator, radius: float = 0.08, depth: float = 0.05, count: int = 6000
) -> FloatArray:
    """(count, 3) points on both sides of a bowl's wall [m], its foot at the origin."""
    reach, turn = radius * np.sqrt(rng.random(count)), rng.uniform(0, 2 * np.pi, count)
    height = depth * (reach / radius) ** 2 + 0.003 * rng.integers(0, 2, count)
    return np.c_[reach * np.cos(turn), reach * np.sin(turn), height] + rng.normal(0, 5e-4, (count, 3))


def ball(rng: np.random.Generator, radius: float, centre: FloatArray, count: int = 2000) -> FloatArray:
    """(count, 3) points on a ball [m]."""
    points = rng.normal(size=(count, 3))
    return radius * points / np.linalg.norm(points, axis=1, keepdims=True) + centre


def moved(scene: Scene, turn: FloatArray, shift: FloatArray) -> Scene:
    """The same scene in another frame: turned by (3, 3), then shifted by (3,) [m]."""
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = turn, shift
    images = [
        DepthImage(image.depth, image.K, image.label, pose @ image.pose_camera_to_world, dict(image.names))
        for image in scene.images
    ]
    return Scene(
        {name: cloud @ turn.T + shift for name, cloud in scene.clouds.items()},
        scene.fixed,
        None if scene.up is None else turn @ scene.up,
        scene.viewpoints @ turn.T + shift,
        images,
    )


def reordered(scene: Scene, rng: np.random.Generator) -> Scene:
    """The same objects, named in another order."""
    return _with({name: scene.clouds[name] for name in rng.permutation(scene.names).tolist()}, scene)


def blurred(scene: Scene, rng: np.random.Generator) -> Scene:
    """The same points, off by what nobody can measure: 1e-7 m."""
    return _with(
        {name: cloud + rng.normal(0, 1e-7, cloud.shape) for name, cloud in scene.clouds.items()}, scene
    )


def with_far_ball(scene: Scene, rng: np.random.Generator) -> Scene:
    """The scene with a ball, "far", 8 m away."""
    return _with({**scene.clouds, "far": ball(rng, 0.03, np.array([8.0, 0.0, 0.03]))}, scene)


def _with(clouds: dict[str, FloatArray], scene: Scene) -> Scene:
    return Scene(clouds, scene.fixed, scene.up, scene.viewpoints, scene.images)


CHANGES: dict[str, Callable[[Scene, np.random.Generator], Scene]] = {
    "turned about the vertical": lambda scene, rng: moved(
        scene, Rotation.from_euler("z", rng.uniform(0.2, 6.0)).as_matrix(), np.zeros(3)
    ),
    "turned": lambda scene, rng: moved(
        scene, Rotation.random(random_state=int(rng.integers(1 << 30))).as_matrix(), np.zeros(3)
    ),
    "shifted": lambda scene, rng: moved(scene, np.eye(3), rng.uniform(-1, 1, 3)),
    "in another order": reordered,
    "with a ball 8 m away": with_far_ball,
    "blurred": blurred,
}
"""What changes how a scene is told and nothing that is in it."""


def told(relations: Relations) -> dict[tuple[str, str], tuple[str, bool, bool]]:
    """Relation, observed and inferred of every ordered pair."""
    return {
        (one.a, one.b): (str(one.relation), one.observed, one.inferred)
        for pair in relations
        for one in (pair, pair.converse)
    }
