"""A depth camera in a world: depth with a real camera's faults, exact masks, colours."""

from dataclasses import dataclass, field, replace
from typing import Protocol, cast, runtime_checkable

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from topple.robots.poses import looking_at
from topple.robots.tolerances import TOLERANCES
from topple.robots.world.tolerances import MASKS_MISSING
from topple.topology.base.arguments import checked_arguments
from topple.topology.base.arrays import BoolArray, FloatArray, IntArray
from topple.topology.base.checks import as_intrinsics, as_pose
from topple.topology.base.errors import InvalidInput
from topple.topology.bodies.matter import MATTER
from topple.topology.views.image import DepthImage

Rendered = tuple[FloatArray, IntArray, NDArray[np.uint8]]
"""Exact depth (H, W) in [m], 0 where nothing is; numbers of bodies (H, W), those of no body where nothing is;
colours (H, W, 3)."""


@runtime_checkable
class Visible(Protocol):
    """What a camera asks of a world."""

    ids: dict[str, int]

    @property
    def movable(self) -> tuple[str, ...]:
        """Names of the objects that are not fixed."""
        ...

    def rendered(self, camera: "Camera") -> Rendered:
        """Render the view of a camera without faults."""
        ...


@dataclass(frozen=True)
class Noise:
    """What a structured-light depth camera gets wrong.

    The axial error is what Nguyen, Izadi and Lovell measured on a Kinect, "Modeling Kinect sensor noise for
    improved 3D reconstruction and tracking" (3DIMPVT 2012): 1.2 mm + 1.9 mm/m^2 (z - 0.4 m)^2, which is
    1.5 mm at 0.8 m. Edges have a few times what recorded frames show at steps of depth
    (`topple bench truth --data`): 81 % of the pixels there are of the nearer surface, 4 % fly, 1 % are lost.

    Attributes:
        floor: Standard deviation at 0.4 m in [m].
        growth: Its growth with the square of the distance beyond, in [1/m].
        quantum: Step of the depth values in [m]; 0 for none.
        edge_loss: Share of the pixels along an object's edge that have no depth.
        edge_mix: Share of them that fly between the object and what is behind it.
        loss: Share of all pixels that have no depth.
    """

    floor: float = 0.0012
    growth: float = 0.0019
    quantum: float = 0.001
    edge_loss: float = 0.1
    edge_mix: float = 0.1
    loss: float = 0.002

    @classmethod
    def none(cls) -> "Noise":
        """A camera without faults."""
        return cls(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)

    def deviation(self, depth: FloatArray) -> FloatArray:
        """Standard deviation in [m] of the axial error at depths in [m]."""
        return self.floor + self.growth * np.square(depth - 0.4)


@checked_arguments
@dataclass(frozen=True, eq=False)
class Camera:
    """A pinhole camera that sees depth, objects and colours.

    Attributes:
        width: In pixels.
        height: In pixels.
        K: Intrinsic matrix (3, 3) in pixels; the centre of the first pixel is (0, 0).
        pose_camera_to_world: (4, 4); x right, y down, z forward.
        noise: Faults of its depth.
        nearest: Least distance in [m] it sees.
        farthest: Largest distance in [m] it sees.
        mask_noise: Standard deviation in pixels by which edges of masks are wrong; 0 for exact masks.
        masks_missing: Chance of an object that no mask shows it in a picture.

    Examples:
        >>> Camera.looking_at((1, 0, 1), (0, 0, 0)).width
        640
    """

    width: int
    height: int
    K: FloatArray
    pose_camera_to_world: FloatArray
    noise: Noise = field(default_factory=Noise)
    nearest: float = 0.15
    farthest: float = 4.0
    mask_noise: float = 0.0
    masks_missing: float = 0.0

    def __post_init__(self) -> None:
        """Check the matrices and make them read-only."""
        object.__setattr__(self, "K", as_intrinsics(self.K, self.width))
        object.__setattr__(
            self, "pose_camera_to_world", as_pose(self.pose_camera_to_world, "pose_camera_to_world")
        )

    @classmethod
    @checked_arguments
    def looking_at(
        cls,
        eye: tuple[float, float, float],
        target: tuple[float, float, float],
        up: tuple[float, float, float] = (0.0, 0.0, 1.0),
        *,
        width: int = 640,
        height: int = 480,
        fov: float = np.radians(60),
        noise: Noise | None = None,
    ) -> "Camera":
        """A camera at a place, turned towards another.

        Args:
            eye: Where it is in [m].
            target: What is in the middle of its picture in [m].
            up: Direction that points up in the picture; another is taken if it is the viewing direction.
            width: In pixels.
            height: In pixels.
            fov: Horizontal field of view in [rad]; 60 degrees as a Kinect or a D415 has.
            noise: Its faults; None: those of a Kinect.

        Returns:
            The camera.

        Raises:
            InvalidInput: If eye and target are one place.
        """
        if np.linalg.norm(np.subtract(target, eye)) < 1e-6:
            raise InvalidInput(f"a camera at {eye} cannot look at {target}: give two places")
        pose = looking_at(eye, target, up)
        focal = width / 2 / np.tan(fov / 2)
        K = np.array([[focal, 0, (width - 1) / 2], [0, focal, (height - 1) / 2], [0, 0, 1.0]])
        return cls(width, height, K, pose, noise or Noise())

    def with_mask_noise(self, pixels: float, missing: float | None = None) -> "Camera":
        """The same camera, whose masks are as a segmentation gives them.

        Args:
            pixels: By which they are wrong along their edges (standard deviation).
            missing: Chance of an object that no mask shows it in a picture; None: one in twenty where edges
                are wrong.

        Raises:
            InvalidInput: If these are no number of pixels and no chance.
        """
        if not np.isfinite(pixels) or pixels < 0:
            raise InvalidInput(f"mask noise is {pixels}: expected pixels, 0 or more")
        if missing is None:
            missing = MASKS_MISSING * (pixels > 0)
        if not 0.0 <= missing <= 1.0:
            raise InvalidInput(f"{missing} of the masks are missing: expected a chance, 0 to 1")
        return replace(self, mask_noise=float(pixels), masks_missing=float(missing))

    def coarse(self) -> "Camera":
        """The same camera with every other row and column, as depth cameras deliver 30 times a second."""
        K = np.diag([0.5, 0.5, 1.0]) @ self.K
        return replace(self, width=(self.width + 1) // 2, height=(self.height + 1) // 2, K=K)

    def look(self, world: Visible, rng: np.random.Generator | None = None) -> DepthImage:
        """Take a picture.

        Args:
            world: What to look at.
            rng: Where the faults come from; None: a generator seeded with 0.

        Returns:
            Depth, masks and colours; the label of an object is the engine's number + 1, that of robots and of
            `topple.topology.bodies.matter.MATTER` 0.
        """
        rng = rng or np.random.default_rng(0)
        depth, body, rgb = world.rendered(self)
        names = {number + 1: name for name, number in world.ids.items() if name != MATTER}
        label = np.where(np.isin(body + 1, list(names)), body + 1, 0)
        depth = self._with_faults(depth, label, rng)
        if self.mask_noise > 0:
            label = roughen(label, self.mask_noise, rng)
        if self.masks_missing > 0:
            movable = [number for number, name in names.items() if name in world.movable]
            missed = rng.random(len(movable)) < self.masks_missing
            label = np.where(np.isin(label, np.array(movable)[missed]), 0, label)
        return DepthImage(
            depth=depth,
            K=self.K,
            label=label,
            pose_camera_to_world=self.pose_camera_to_world,
            names={number: name for number, name in names.items() if (label == number).any()},
            rgb=rgb,
        )

    def picture(self, world: Visible) -> NDArray[np.uint8]:
        """The colours alone, (H, W, 3): for films."""
        return world.rendered(self)[2]

    def _with_faults(self, depth: FloatArray, label: IntArray, rng: np.random.Generator) -> FloatArray:
        """Noise, quantisation, grazing views, edges and lost pixels."""
        noise = self.noise
        if noise == Noise.none():
            return depth
        seen = depth > 0
        edge, jump = _edges(depth, label)
        faulty = depth + rng.standard_normal(depth.shape) * noise.deviation(depth)
        draw = rng.random(depth.shape)
        flying = edge & (draw < noise.edge_mix)
        faulty[flying] += (jump * rng.random(depth.shape))[flying]
        if noise.quantum > 0:
            faulty = np.round(faulty / noise.quantum) * noise.quantum
        lost = edge & (draw > 1 - noise.edge_loss)
        lost |= rng.random(depth.shape) < noise.loss
        lost |= self._grazing_pixels(depth) & (rng.random(depth.shape) < 0.8)
        return np.where(seen & ~lost & (faulty > 0), faulty, 0.0)

    def _grazing_pixels(self, depth: FloatArray) -> BoolArray:
        """Pixels whose surface is seen nearly from the side; a step to another surface makes none so."""
        rise = np.hypot(*(_slope(depth, axis) * self.K[1 - axis, 1 - axis] for axis in (0, 1)))
        return rise > np.tan(TOLERANCES.grazing) * np.maximum(depth, 1e-3)


def _slope(depth: FloatArray, axis: int) -> FloatArray:
    """How depth (H, W) rises along an axis [m per pixel], to that side on which it rises less."""
    step = np.abs(np.diff(depth, axis=axis))
    before, after = ([(1, 0), (0, 0)], [(0, 1), (0, 0)])
    if axis == 1:
        before, after = before[::-1], after[::-1]
    return np.minimum(np.pad(step, before, mode="edge"), np.pad(step, after, mode="edge"))


def _edges(depth: FloatArray, label: IntArray) -> tuple[BoolArray, FloatArray]:
    """Pixels (H, W) beside a depth step between objects, and how far it is to the other side in [m]."""
    edge = np.zeros(depth.shape, dtype=bool)
    jump = np.zeros(depth.shape)
    for axis in (0, 1):
        for shift in (-1, 1):
            other = np.roll(depth, shift, axis)
            step = other - depth
            found = (np.abs(step) > TOLERANCES.edge_jump) & (np.roll(label, shift, axis) != label)
            found &= (other > 0) & (depth > 0)
            edge |= found
            jump = np.where(found, step, jump)
    return edge, jump


def roughen(label: IntArray, pixels: float, rng: np.random.Generator) -> IntArray:
    """Masks whose edges wander by some pixels, smoothly along them, as a segmentation's do."""
    wander = rng.standard_normal((2, *label.shape))
    smooth = cast(FloatArray, ndimage.gaussian_filter(wander, (0, 6, 6)))
    smooth *= pixels / max(float(smooth.std()), 1e-9)
    rows, columns = np.indices(label.shape)
    rows = np.clip(np.round(rows + smooth[0]), 0, label.shape[0] - 1).astype(np.int64)
    columns = np.clip(np.round(columns + smooth[1]), 0, label.shape[1] - 1).astype(np.int64)
    return label[rows, columns]
