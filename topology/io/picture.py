"""Pictures that hold numbers: depth, masks and colours of PNG, TIFF and JPEG files."""

import io
import warnings
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from topple.topology.base.errors import InvalidInput
from topple.topology.io.limits import check_size, read_bytes

_FORMATS = ("PNG", "TIFF", "JPEG")
"""What Pillow may take a picture for: some of its other readers start programs."""
_WIDEST = 4  # bytes a pixel unpacks to: RGBA, 32 bits of depth


def read_picture(source: Path | bytes, what: str) -> NDArray[Any]:
    """Unpack a picture.

    Args:
        source: The file, or its bytes.
        what: What it is, for the message.

    Returns:
        (H, W) or (H, W, channels), as stored.

    Raises:
        InvalidInput: If it is broken, or would unpack to more than is allowed.
        OSError: If the file cannot be read.
    """
    from PIL import Image, UnidentifiedImageError

    data = source if isinstance(source, bytes) else read_bytes(source, what)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)  # asked below
            with Image.open(io.BytesIO(data), formats=_FORMATS) as picture:
                check_size(_WIDEST * picture.width * picture.height, what)
                return np.asarray(picture)
    except InvalidInput:
        raise
    except UnidentifiedImageError as error:
        raise InvalidInput(f"{what} is no picture: expected a PNG, TIFF or JPEG file") from error
    except Exception as error:  # each of Pillow's readers fails on a broken file in its own way
        reason = " ".join(str(error).split())[:120] or type(error).__name__
        raise InvalidInput(f"{what} is no readable picture: {reason}") from error
