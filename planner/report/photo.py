"""What a camera saw, with the mask of every object outlined and named."""

import base64
from collections.abc import Sequence
from html import escape

import numpy as np
from scipy.ndimage import binary_erosion, distance_transform_edt

from topple.planner.decide.words import ordinal, places, shortened
from topple.planner.formats.pictures import jpeg
from topple.planner.report.drawing import Document, Drawing
from topple.planner.report.palette import Colour, css, ink_on
from topple.topology.base.arrays import BoolArray
from topple.topology.scene.scene import Scene
from topple.topology.views.image import Photo

_TINT = 0.22
"""Share of an object's colour within its mask: enough to tell masks apart, and the photo stays a photo."""
_LINE = 0.003  # width of an outline, as a share of the photo's
_PLACES = 300  # places of a mask that are tried for its name
_LEAST = 0.5  # share of the photo's width and height that is shown at least


def photo(scene: Scene, drawing: Drawing, order: Document | None, taken: Photo | None = None) -> str:
    """Show a photo with its masks in the colours of the drawing, as HTML; nothing where there is none.

    Args:
        scene: The scene; its first colour image is shown.
        drawing: The scene as it is drawn.
        order: A `topple.order` document, for the places of objects in it; or None.
        taken: A photo that was taken for people; shown in place of the scene's own.
    """
    shown, index, place = taken or _first(scene), drawing.index, {} if order is None else places(order)
    if shown is None:
        return ""
    names = {n: name for n, name in shown.names.items() if name in index and name not in scene.fixed}
    masks = np.isin(shown.label, list(names))
    crop = _around(masks) if taken is None and masks.any() else (slice(None), slice(None))
    label, pixels = shown.label[crop], shown.rgb[crop].astype(np.float64)
    height, width = label.shape
    line = max(1, round(_LINE * width))
    doubted = {name for wrong in scene.wrong_masks for name in wrong.names}
    marks, placed = "", list[tuple[float, float]]()
    for number, name in names.items():
        mask, colour = label == number, drawing.colours[name]
        if not mask.any():
            continue
        pixels[mask] += (colour - pixels[mask]) * _TINT
        wide = 4 * line if name in doubted else line  # it shows beside the others
        inside = np.asarray(binary_erosion(mask, iterations=wide, border_value=1), dtype=np.bool_)
        pixels[mask & ~inside] = colour
        placed.append(_clear(mask, placed))
        marks += _chip(name, colour, index[name], place.get(name), placed[-1])
    source = base64.b64encode(jpeg(pixels.clip(0, 255).astype(np.uint8))).decode("ascii")
    told = ", and before it the place in the order" if place else ""
    said = "".join(f" Wide outline: {escape(str(wrong))}." for wrong in scene.wrong_masks)
    return (
        f'<figure class="photo"><div class="stage"><img src="data:image/jpeg;base64,{source}" '
        f'alt="what the camera saw, masks outlined" width="{width}" height="{height}">{marks}</div>'
        f'<figcaption class="note">What the camera saw: a colour for each mask, its name{told}.'
        f"{said}</figcaption></figure>"
    )


def _first(scene: Scene) -> Photo | None:
    """The first colour image that a scene came with."""
    for image in scene.images:
        if image.rgb is not None:
            numbers = [int(number) for number in np.unique(image.label) if number > 0]
            return Photo(image.rgb, image.label, {number: image.name_of(number) for number in numbers})
    return None


def _around(masks: BoolArray) -> tuple[slice, slice]:
    """The part of the photo about all masks, shaped like it, and not so small that its pixels show."""
    spans = [np.nonzero(masks.any(axis=axis))[0][[0, -1]] for axis in (1, 0)]
    shares = [(last - first) / size for (first, last), size in zip(spans, masks.shape, strict=True)]
    share = min(max(1.4 * max(shares), _LEAST), 1.0)
    lengths = [round(share * size) for size in masks.shape]
    starts = [
        int(np.clip((first + last - length) // 2, 0, size - length))
        for (first, last), size, length in zip(spans, masks.shape, lengths, strict=True)
    ]
    return slice(starts[0], starts[0] + lengths[0]), slice(starts[1], starts[1] + lengths[1])


def _clear(mask: BoolArray, taken: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """The place [%] deepest in a mask where no other name stands; below it where there is none."""

    def free(x: float, y: float) -> bool:  # a name is a fifth of the width wide, and a row of text high
        return 10 < x < 90 and not any(abs(x - u) < 20 and abs(y - v) < 6.5 for u, v in taken)

    height, width = mask.shape
    depth = np.asarray(distance_transform_edt(np.pad(mask, 1)))[1:-1, 1:-1]
    best = np.argsort(-depth, axis=None)[: int(mask.sum())]
    rows, columns = np.divmod(best[:: max(1, len(best) // _PLACES)], width)
    spots = list(zip((100 * columns / width).tolist(), (100 * rows / height).tolist(), strict=True))
    x, y = next((spot for spot in spots if free(*spot)), spots[0])
    while not free(x, y) and y < 92:
        y += 2
    return x, y


def _chip(name: str, colour: Colour, number: int, place: int | None, at: tuple[float, float]) -> str:
    """The name of an object, its place in the order before it; `at` is from the left and from the top [%]."""
    paint = f"background:{css(colour)};color:{css(ink_on(colour))}"
    badge = f'<b style="{paint}">{ordinal(place)}</b>' if place else ""
    edge = f"left:{at[0]:.1f}%;top:{at[1]:.1f}%;border-color:{css(colour)}"
    return (
        f'<span class="chip" data-object="{number}" style="{edge}" title="{escape(name)}">{badge}'
        f"<span>{escape(shortened(name))}</span></span>"
    )
