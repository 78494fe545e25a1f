"""What a camera saw, with the mask of every object outlined and named."""

import base64
from collections.abc import Collection, Iterable, Sequence
from html import escape
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from scipy.ndimage import binary_erosion, distance_transform_edt

from topple.planner.decide.names import Colour, photo_of
from topple.planner.decide.words import ordinal, places, shorten
from topple.planner.formats.pictures import Pixels, jpeg, png
from topple.planner.report.drawing import Document, Drawing
from topple.planner.report.palette import css, ink_on
from topple.topology.base.arrays import BoolArray
from topple.topology.scene.scene import Scene
from topple.topology.views.image import Photo

_Kind = TypeVar("_Kind", bound=np.generic)
Box = tuple[float, float, float, float]  # top, bottom, left and right of a part of a picture, as shares of it

_TINT = 0.22
"""Share of an object's colour within its mask: enough to tell masks apart, and the photo stays a photo."""
_LINE = 0.003  # width of an outline, as a share of the photo's
_PLACES = 300  # places of a mask that are tried for its name
_LEAST = 0.5  # share of the photo's width and height that is shown at least


def photo(scene: Scene, drawing: Drawing, order: Document | None) -> str:
    """Show the photo that a scene came with and its masks in the colours of the drawing, as HTML; or nothing.

    Args:
        scene: The scene; its first colour image is shown.
        drawing: The scene as it is drawn.
        order: A `topple.order` document, for the places of objects in it; or None.
    """
    if (shown := photo_of(scene)) is None:
        return ""
    box = around([shown], scene.fixed)
    pixels = cut(shown.rgb, box)
    height, width = pixels.shape[:2]
    image = f'<img src="{jpeg_url(pixels)}" alt="what the camera saw" width="{width}" height="{height}">'
    return photo_figure(image, masks(shown, box, scene, drawing, order), said_of_masks(scene, order))


def photo_figure(image: str, over: str, words: str, slider: str = "") -> str:
    """A picture with what lies over it, and words and a slider below."""
    return (
        f'<figure class="photo"><div class="stage">{image}{over}</div>{slider}'
        f'<figcaption class="note">{words}</figcaption></figure>'
    )


def said_of_masks(scene: Scene, order: Document | None) -> str:
    """Explain the colours and numbers on a photo, and say which masks are wrong."""
    told = ", and before it the place in the order" if order and places(order) else ""
    said = "".join(f" Wide outline: {escape(str(wrong))}." for wrong in scene.wrong_masks)
    return f"What the camera saw: a colour for each mask, its name{told}.{said}"


def jpeg_url(pixels: Pixels) -> str:
    """A picture (H, W, 3) as the address of a JPEG file."""
    return f"data:image/jpeg;base64,{base64.b64encode(jpeg(pixels)).decode('ascii')}"


def cut(pixels: NDArray[_Kind], box: Box) -> NDArray[_Kind]:
    """A part of a picture (H, W, ...)."""
    (height, width), (top, bottom, left, right) = pixels.shape[:2], box
    return pixels[round(top * height) : round(bottom * height), round(left * width) : round(right * width)]


def masks(shown: Photo, box: Box, scene: Scene, drawing: Drawing, order: Document | None) -> str:
    """The masks in a part of a photo, outlined and named, as HTML to lie over it."""
    index, place = drawing.index, {} if order is None else places(order)
    label = cut(shown.label, box)
    height, width = label.shape
    line = max(1, round(_LINE * width))
    over = np.zeros((height, width, 4), dtype=np.uint8)
    doubted = {name for wrong in scene.wrong_masks for name in wrong.names}
    marks, placed = "", list[tuple[float, float]]()
    for number, name in shown.names.items():
        mask = label == number
        if name not in index or name in scene.fixed or not mask.any():
            continue
        colour = drawing.colours[name]
        wide = 4 * line if name in doubted else line  # it shows beside the others
        inside = np.asarray(binary_erosion(mask, iterations=wide, border_value=1), dtype=np.bool_)
        over[mask] = (*colour, 255)
        over[inside, 3] = round(255 * _TINT)
        placed.append(_clear(mask, placed))
        marks += _chip(name, colour, index[name], place.get(name), placed[-1])
    source = base64.b64encode(png(Image.fromarray(over))).decode("ascii")
    return f'<img class="over" src="data:image/png;base64,{source}" alt="masks, outlined">{marks}'


def around(photos: Iterable[Photo], fixed: Collection[str]) -> Box:
    """The part of one camera's photos about all masks of what can be taken, not so small that pixels show."""
    found = [
        np.isin(shown.label, [number for number, name in shown.names.items() if name not in fixed])
        for shown in photos
    ]
    spans = [
        np.array(
            [
                np.nonzero(mask.any(axis=axis))[0][[0, -1]] / mask.shape[1 - axis]
                for mask in found
                if mask.any()
            ]
        )
        for axis in (1, 0)
    ]
    if not len(spans[0]):
        return 0.0, 1.0, 0.0, 1.0
    ends = [(float(each[:, 0].min()), float(each[:, 1].max())) for each in spans]
    share = min(max(1.4 * max(last - first for first, last in ends), _LEAST), 1.0)
    starts = [min(max((first + last - share) / 2, 0.0), 1.0 - share) for first, last in ends]
    return starts[0], starts[0] + share, starts[1], starts[1] + share


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
        f"<span>{escape(shorten(name))}</span></span>"
    )
