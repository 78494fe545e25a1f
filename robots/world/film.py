"""A film of an arm at work, as a camera in its world sees it."""

import os
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from fractions import Fraction
from pathlib import Path
from typing import Any

from topple.robots.world.acting_arm import ActingArm
from topple.robots.world.camera import Camera
from topple.robots.world.tolerances import BACK
from topple.topology.base.errors import InvalidInput, NotInstalled

RATE = 12  # pictures a second of simulated time: motion is smooth, and drawing stays a small part of a run
SIZE = (480, 360)  # [pixels]
Each = Callable[[Any], None]


class Film:
    """Films from when it is entered until it is left; the file is there then, whatever happened between.

    Args:
        path: Where the film goes: MP4 with H.264.
        robot: The arm.
        camera: Where from; only its place and direction count.
        each: Called with each picture (H, W, 3) as it is taken, if given.

    Raises:
        InvalidInput: The encoder is not installed, or the path's folder is not there.
    """

    def __init__(self, path: Path, robot: ActingArm, camera: Camera, each: Each | None = None) -> None:
        encoder()
        if not path.resolve().parent.is_dir():
            raise InvalidInput(f"{path}: cannot be written, its folder does not exist; make it first")
        self._path, self._robot, self._each = path, robot, each
        self._part = path.with_name(f"{path.name}.part")
        target = camera.pose_camera_to_world[:3, 3]
        eye = target - BACK * camera.pose_camera_to_world[:3, 2]
        self._camera = Camera.looking_at(
            (float(eye[0]), float(eye[1]), float(eye[2])),
            (float(target[0]), float(target[1]), float(target[2])),
            width=SIZE[0],
            height=SIZE[1],
        )
        self._next = 0.0

    def __enter__(self) -> "Film":
        """Begin to film."""
        self._file: Any = encoder().open(str(self._part), mode="w", format="mp4")
        self._stream: Any = self._file.add_stream("libx264", rate=Fraction(RATE))
        self._stream.width, self._stream.height = SIZE
        self._stream.pix_fmt = "yuv420p"
        self._next = self._robot.world.time
        self._on_step()
        self._robot.on_step.append(self._on_step)
        return self

    def __exit__(self, *_: object) -> None:
        """End the film."""
        self._robot.on_step.remove(self._on_step)
        self._write(None)
        self._file.close()
        os.replace(self._part, self._path)

    def _on_step(self) -> None:
        if self._robot.world.time < self._next - 1e-9:
            return
        self._next += 1.0 / RATE
        picture = self._camera.picture(self._robot.world)
        if self._each is not None:
            self._each(picture)
        self._write(encoder().VideoFrame.from_ndarray(picture, format="rgb24"))

    def _write(self, frame: Any) -> None:
        """Encode a picture; None what is left in the encoder."""
        for packet in self._stream.encode(frame):
            self._file.mux(packet)


def film_of(path: Path | None, robot: ActingArm, camera: Camera) -> AbstractContextManager[object]:
    """A film, or nothing where no path is given."""
    return nullcontext() if path is None else Film(path, robot, camera)


def encoder() -> Any:
    """The library that encodes.

    Raises:
        NotInstalled: It is not installed.
    """
    try:
        import av  # an extra: only films need it
    except ImportError as error:
        raise NotInstalled("a film needs PyAV", "video") from error
    return av
