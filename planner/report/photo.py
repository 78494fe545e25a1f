"""What a camera saw, with the mask of every object outlined and named."""

import base64
from collections.abc import Mapping, Sequence
from html import escape

import numpy as np
from scipy.ndimage import binary_erosion, distance_transform_edt

from topple.planner.formats.pictures import jpeg
from topple.planner.report.palette import Colour, css, ink_on
from topple.planner.report.words import ordinal, shortened
from topple.topology.arrays import BoolArray
from topple.topology.image import DepthImage
from topple.topology.scene import Scene

_TINT = 0.28
"""Share of an object's colour within its mask: enough to tell masks apart, and the photo stays a photo."""
_LINE = 2
"""Width of an outline [px]."""
_LEAST = 0.5
"""Share of the photo's width and height that is shown at least."""


def photo(
    scene: Scene, colours: Mapping[str, Colour], index: Mapping[str, int], places: Mapping[str, int]
) -> str:
    """Show the first photo that a scene came with.

    Args:
        scene: The scene; without a colour image there is nothing to show.
        colours: Object -> its colour on the page.
        index: Object -> its number in the viewer.
        places: Object -> its place in the order, from 1.

    Returns:
        HTML; empty where the scene has no photo.
    """
    image = next((image for image in scene.images if image.rgb is not None), None)
    if image is None or image.rgb is None:
        return ""
    rows, columns = _around(
        np.isin(image.label, [n for n in np.unique(image.label) if _shown(image, n, scene, index)])
    )
    label, pixels = image.label[rows, columns], image.rgb[rows, columns].astype(np.float64)
    height, width = label.shape
    marks, taken = "", list[tuple[float, float]]()
    for number in np.unique(label[label > 0]):
        name = image.name_of(int(number))
        if not _shown(image, number, scene, index):
            continue
        mask, colour = label == number, np.array(colours[name], dtype=np.float64)
        pixels[mask] += (colour - pixels[mask]) * _TINT
        inside = np.asarray(binary_erosion(mask, iterations=_LINE, border_value=1), dtype=np.bool_)
        pixels[mask & ~inside] = colour
        depth = np.asarray(distance_transform_edt(np.pad(mask, 1)))[1:-1, 1:-1]
        y, x = np.unravel_index(int(np.argmax(depth)), label.shape)
        at = _clear((100 * float(x) / width, 100 * float(y) / height), taken)
        taken.append(at)
        marks += _chip(name, colours[name], index[name], places.get(name), at)
    source = base64.b64encode(jpeg(pixels.clip(0, 255).astype(np.uint8))).decode("ascii")
    return (
        f'<figure class="photo"><div class="stage"><img src="data:image/jpeg;base64,{source}" '
        f'alt="what the camera saw, masks outlined" width="{width}" height="{height}">{marks}</div>'
        '<figcaption class="note">What the camera saw: a colour for each mask, its name, and before it the '
        "place in the order.</figcaption></figure>"
    )


def _shown(image: DepthImage, label: int, scene: Scene, index: Mapping[str, int]) -> bool:
    """Whether a label is that of something that can be taken."""
    name = image.name_of(int(label))
    return label > 0 and name in index and name not in scene.fixed


def _around(masks: BoolArray) -> tuple[slice, slice]:
    """The part of the photo about all masks, shaped like it, and not so small that its pixels show."""
    if not masks.any():
        return slice(None), slice(None)
    spans = [np.nonzero(masks.any(axis=axis))[0][[0, -1]] for axis in (1, 0)]
    shares = [(last - first) / size for (first, last), size in zip(spans, masks.shape, strict=True)]
    share = min(max(1.4 * max(shares), _LEAST), 1.0)
    parts: list[slice] = []
    for (first, last), size in zip(spans, masks.shape, strict=True):
        length = round(share * size)
        start = int(np.clip((first + last - length) // 2, 0, size - length))
        parts.append(slice(start, start + length))
    return parts[0], parts[1]


def _clear(at: tuple[float, float], taken: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """A place at or below one [%], where no other name stands."""
    x, y = at
    while any(abs(x - u) < 16 and abs(y - v) < 7 for u, v in taken) and y < 90:
        y += 2
    return x, y


def _chip(name: str, colour: Colour, number: int, place: int | None, at: tuple[float, float]) -> str:
    """The name of an object, its place in the order before it; `at` is from the left and from the top [%]."""
    badge = (
        f'<b style="background:{css(colour)};color:{css(ink_on(colour))}">{ordinal(place)}</b>'
        if place
        else ""
    )
    edge = f"left:{at[0]:.1f}%;top:{at[1]:.1f}%;border-color:{css(colour)}"
    return (
        f'<span class="chip" data-object="{number}" style="{edge}" title="{escape(name)}">{badge}'
        f"<span>{escape(shortened(name))}</span></span>"
    )
