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
from topple.topology.photo import Photo
from topple.topology.scene import Scene

_TINT = 0.22
"""Share of an object's colour within its mask: enough to tell masks apart, and the photo stays a photo."""
_LINE = 0.003
"""Width of an outline, as a share of the photo's."""
_PLACES = 300
"""Places of a mask that are tried for its name."""
_LEAST = 0.5
"""Share of the photo's width and height that is shown at least."""


def photo(
    scene: Scene,
    colours: Mapping[str, Colour],
    index: Mapping[str, int],
    places: Mapping[str, int],
    taken: Photo | None = None,
) -> str:
    """Show what a scene was made of: a photo with its masks.

    Args:
        scene: The scene; its first colour image is shown.
        colours: Object -> its colour on the page.
        index: Object -> its number in the viewer.
        places: Object -> its place in the order, from 1.
        taken: A photo that was taken for people; shown in place of the scene's own.

    Returns:
        HTML; empty where there is no photo.
    """
    shown = taken or _first(scene)
    if shown is None:
        return ""
    names = {n: name for n, name in shown.names.items() if name in index and name not in scene.fixed}
    masks = np.isin(shown.label, list(names))
    rows, columns = _around(masks) if taken is None else (slice(None), slice(None))
    label, pixels = shown.label[rows, columns], shown.rgb[rows, columns].astype(np.float64)
    height, width = label.shape
    line = max(1, round(_LINE * width))
    doubted = {name for wrong in scene.wrong_masks for name in wrong.names}
    marks, placed = "", list[tuple[float, float]]()
    for number, name in names.items():
        mask, colour = label == number, np.array(colours[name], dtype=np.float64)
        if not mask.any():
            continue
        pixels[mask] += (colour - pixels[mask]) * _TINT
        wide = 4 * line if name in doubted else line  # it shows beside the others
        inside = np.asarray(binary_erosion(mask, iterations=wide, border_value=1), dtype=np.bool_)
        pixels[mask & ~inside] = colour
        at = _clear(mask, placed)
        placed.append(at)
        marks += _chip(name, colours[name], index[name], places.get(name), at)
    source = base64.b64encode(jpeg(pixels.clip(0, 255).astype(np.uint8))).decode("ascii")
    told = ", and before it the place in the order" if places else ""
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
            names = {
                int(number): image.name_of(int(number)) for number in np.unique(image.label) if number > 0
            }
            return Photo(image.rgb, image.label, names)
    return None


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


def _clear(mask: BoolArray, taken: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """The place [%] deepest in a mask where no other name stands; below it where there is none."""
    height, width = mask.shape
    depth = np.asarray(distance_transform_edt(np.pad(mask, 1)))[1:-1, 1:-1]
    best = np.argsort(-depth, axis=None)[: int(mask.sum())]
    rows, columns = np.divmod(best[:: max(1, len(best) // _PLACES)], width)
    places = [(100 * float(x) / width, 100 * float(y) / height) for x, y in zip(columns, rows, strict=True)]
    for place in places:
        if _is_free(place, taken):
            return place
    x, y = places[0]
    while not _is_free((x, y), taken) and y < 92:
        y += 2
    return x, y


def _is_free(place: tuple[float, float], taken: Sequence[tuple[float, float]]) -> bool:
    """Whether a name there covers no other one; names are a fifth of the width and a row of text."""
    x, y = place
    return 10 < x < 90 and not any(abs(x - u) < 20 and abs(y - v) < 6.5 for u, v in taken)


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
