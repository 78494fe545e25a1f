"""Pictures as PNG and JPEG files."""

import io
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from topple.topology.base.errors import InvalidInput

if TYPE_CHECKING:
    from PIL import Image

Pixels = NDArray[np.uint8]


def picture(rgb: Pixels) -> bytes:
    """Write an image as PNG.

    Args:
        rgb: (H, W, 3) uint8.

    Returns:
        The bytes of the PNG file.

    Raises:
        InvalidInput: If the array is no such image.
    """
    from PIL import Image

    rgb = np.ascontiguousarray(rgb)
    if rgb.ndim != 3 or rgb.shape[2] != 3 or rgb.dtype != np.uint8 or rgb.size == 0:
        raise InvalidInput(f"a picture needs (H, W, 3) uint8, got shape {rgb.shape} of {rgb.dtype}")
    return png(Image.fromarray(rgb))


def png(image: "Image.Image") -> bytes:
    """The bytes of an image as a PNG file."""
    buffer = io.BytesIO()
    image.save(buffer, format="PNG")
    return buffer.getvalue()


def pixels_of(data: bytes) -> Pixels:
    """(H, W, 3) uint8 of a PNG or JPEG file."""
    from PIL import Image

    return np.asarray(Image.open(io.BytesIO(data), formats=("PNG", "JPEG")).convert("RGB"))


def jpeg(rgb: Pixels) -> bytes:
    """The bytes of a photo, (H, W, 3) uint8, as a JPEG file: a fifth of what PNG takes."""
    from PIL import Image

    buffer = io.BytesIO()
    Image.fromarray(rgb).save(buffer, format="JPEG", quality=82)
    return buffer.getvalue()
