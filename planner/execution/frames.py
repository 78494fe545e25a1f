"""The pictures of one look: what a camera delivers that cannot be one of now is left out, and named."""

from collections.abc import Sequence
from typing import Protocol, runtime_checkable

import numpy as np

from topple.robots.world.physical_world import PhysicalWorld
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput
from topple.topology.views.image import DepthImage


@runtime_checkable
class Eye(Protocol):
    """What takes a picture of a world: a simulated camera, or what stands in for one."""

    def look(self, world: PhysicalWorld, rng: np.random.Generator | None = None) -> DepthImage:
        """Take a picture; the generator is of the noise."""
        ...


class Frames:
    """Takes a picture with every camera, and leaves out what is no picture of now.

    A frame is left out where it is no depth image at all (depth in millimetres among others), where it shows
    nothing, and where it is the one that the camera delivered at the last look. No two frames of a depth
    camera are alike to the last bit, so one that is was not taken anew.

    Args:
        cameras: At least one.
    """

    def __init__(self, cameras: Sequence[Eye]) -> None:
        self._cameras = tuple(cameras)
        self._last: dict[int, FloatArray] = {}

    def take(
        self, world: PhysicalWorld, rng: np.random.Generator, changed: bool = True
    ) -> tuple[tuple[DepthImage, ...], tuple[str, ...]]:
        """Take the pictures.

        Args:
            world: What to look at.
            rng: Of the noise.
            changed: Whether something was moved since the last look. If nothing was, and no camera delivers
                another frame than then, these are taken: cameras without noise see the same again.

        Returns:
            The pictures of the cameras that deliver one, and a sentence for each of the others, which are
            counted from 1.

        Raises:
            InvalidInput: No camera delivers one.
        """
        images: dict[int, DepthImage] = {}
        wrong: dict[int, str] = {}
        for number, camera in enumerate(self._cameras, 1):
            try:
                image = camera.look(world, rng)
            except InvalidInput as error:
                wrong[number] = f"camera {number} is left out: {error}"
                continue
            if not (image.depth.any() or image.names):
                wrong[number] = f"camera {number} delivers nothing: it is left out"
            else:
                images[number] = image
        old = [number for number, image in images.items() if self._is_old(number, image)]
        if changed or len(old) < len(images):
            for number in old:
                del images[number]
                wrong[number] = f"camera {number} delivers an old frame: it is left out"
        self._last |= {number: image.depth for number, image in images.items()}
        said = tuple(wrong[number] for number in sorted(wrong))
        if not any(image.names for image in images.values()):
            raise InvalidInput(
                f"none of {len(self._cameras)} cameras sees anything: "
                "expected objects with a mask and a depth" + "".join(f"; {text}" for text in said)
            )
        return tuple(images.values()), said

    def _is_old(self, number: int, image: DepthImage) -> bool:
        return number in self._last and np.array_equal(self._last[number], image.depth)
