"""A moving picture of an order: what is taken rises, fades and is gone, one object after the other."""

import io
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from topple.planner.report.drawing import Drawing, DrawnObject
from topple.planner.report.figure import FINE, caption
from topple.planner.report.limits import LIMITS
from topple.planner.report.pen import PAPER
from topple.planner.report.raster import Projection, render_clouds
from topple.planner.report.view import Document, Documented, document
from topple.planner.report.words import order_in_words
from topple.topology.errors import InvalidInput
from topple.topology.scene import Scene

if TYPE_CHECKING:
    from PIL import Image

SIZE = (640, 480)
"""Width and height [px], without the line of words below."""
RISE = 6
"""Pictures in which an object rises and is gone."""
HIGH = 0.9
"""How far it rises, in radii of the scene."""
WAITS = (1400, 70, 2200)
"""How long a picture stands: before something is taken, while it rises, and at the end [ms]."""
COLOURS = 128
"""In the picture's palette."""


def order_gif(
    scene: Scene, order: Documented | Document, progress: Callable[[str], None] | None = None
) -> bytes:
    """Animate an order.

    Args:
        scene: The scene.
        order: What `order` found in it, or the JSON document of that.
        progress: Called with a line before each object is drawn.

    Returns:
        The bytes of a GIF that runs for ever: before each object is taken, which one and why.

    Raises:
        InvalidInput: The order takes nothing.
    """
    told = order_in_words(document(order))
    drawing = Drawing.of(scene, LIMITS.picture_points)
    if not told:
        raise InvalidInput("the order takes nothing, so there is nothing to animate: give a target")
    pictures: list[Image.Image] = []
    waits: list[int] = []
    left = list(drawing.objects)
    fine = Projection(drawing, SIZE[0] * FINE, SIZE[1] * FINE)
    coarse = Projection(drawing, *SIZE)
    for place, (name, why) in enumerate(told, start=1):
        taken = next((drawn for drawn in left if drawn.name == name), None)
        if taken is None:
            continue
        words = f"{place}. {name}: {why}"
        if progress is not None:
            progress(f"drawing how {name} is taken: {place} of {len(told)}")
        pictures.append(_picture(drawing, left, fine, words))
        waits.append(WAITS[0])
        left.remove(taken)
        for frame in range(1, RISE):
            lifted = _lifted(taken, drawing.up * HIGH * drawing.radius * (frame / RISE) ** 2)
            pictures.append(_picture(drawing, [*left, lifted], coarse, words))
            waits.append(WAITS[1])
    pictures.append(_picture(drawing, left, fine, "Done."))
    waits.append(WAITS[2])
    first, *others = (picture.quantize(COLOURS) for picture in pictures)
    buffer = io.BytesIO()
    first.save(buffer, "GIF", save_all=True, append_images=others, duration=waits, loop=0, optimize=True)
    return buffer.getvalue()


def _lifted(drawn: DrawnObject, way: "np.ndarray[tuple[int, ...], np.dtype[np.float64]]") -> DrawnObject:
    return replace(drawn, points=drawn.points + way, top=drawn.top + way, centre=drawn.centre + way)


def _picture(
    drawing: Drawing, objects: list[DrawnObject], projection: Projection, words: str
) -> "Image.Image":
    from PIL import Image

    shown = replace(drawing, objects=tuple(objects))
    view = (
        Image.fromarray(render_clouds(shown, projection, PAPER)) if objects else Image.new("RGB", SIZE, PAPER)
    )
    return caption(view.resize(SIZE, Image.Resampling.LANCZOS), words)
