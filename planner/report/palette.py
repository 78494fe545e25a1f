"""The colours of the pages and pictures: relations as in the paper's Figure 6, objects apart from them."""

import colorsys
import re
from collections import Counter
from collections.abc import Collection, Iterable

import numpy as np

from topple.topology.sixim.table import Relation

Colour = tuple[int, int, int]  # red, green, blue, 0..255

RELATION_COLOURS: dict[str, Colour] = {
    Relation.TOUCH: (214, 39, 40),
    Relation.CROSS: (0, 168, 181),
    Relation.WITHIN: (26, 150, 65),
    Relation.PARTIAL_WITHIN: (43, 105, 214),
    Relation.CONTAIN: (194, 51, 158),
    Relation.PARTIAL_CONTAIN: (204, 148, 0),
    Relation.DISJOINT: (140, 140, 136),
}
"""Red touch, cyan cross, green within, blue partial within, magenta contain, yellow partial contain
(paper section 4.2, Figure 6), each darkened until it reads on a light page and on a dark one."""

REASON_COLOURS: dict[str, Colour] = {
    "supported": (118, 127, 138),
    "leaning": (202, 103, 2),
    "contained": (0, 128, 128),
    "blocking": (142, 68, 173),
    "counterweight": (121, 85, 72),
    "measured": (183, 28, 28),
}
"""One colour for each reason a dependency can have, as it is said."""

FIXED_COLOUR: Colour = (158, 156, 148)  # tables and shelves: grey, because nobody takes them away

_GOLDEN_TURN = 0.61803398875
_LIGHTNESS = (0.5, 0.38, 0.62)
_SATURATION = 0.42
_ALIKE = 0.05  # turns between hues that look the same; all words in use leave some
_GREY = 0.2  # share of its brightest channel by which the channels of a grey differ at most
_BLACK, _WHITE = 0.25, 0.6  # lightness of what is called black at most, and white at least
_HUES = {
    "red": 0.0,
    "orange": 0.08,
    "yellow": 0.15,
    "green": 0.36,
    "teal": 0.49,
    "blue": 0.61,
    "purple": 0.77,
    "pink": 0.92,
}
"""Turns of the hue that a word in a name stands for: a cube called green is drawn green."""


def object_colours(names: Iterable[str], fixed: Collection[str] = ()) -> dict[str, Colour]:
    """Give every object a colour of its own, the same in every picture of the same scene.

    Args:
        names: Object names in the scene's order.
        fixed: Names drawn in grey.

    Returns:
        Name -> colour. Hues step by the golden ratio, so that neighbours in the list never look alike; they
        are less saturated than those of relations, so that lines stand out. Where a word of the name is a
        colour, it has that hue.
    """
    every = tuple(names)
    said_of = {name: [w for w in re.findall("[a-z]+", name.lower()) if w in _HUES] for name in every}
    words = {name: found[0] for name, found in said_of.items() if found and name not in fixed}
    taken, turn, said = [_HUES[word] for word in words.values()], 0, Counter[str]()
    colours: dict[str, Colour] = {}
    for name in every:
        if name in fixed:
            colours[name] = FIXED_COLOUR
        elif word := words.get(name):
            colours[name] = _paint(said[word], _HUES[word])
            said[word] += 1
        else:
            while any(abs((_hue(turn) - hue + 0.5) % 1.0 - 0.5) < _ALIKE for hue in taken):
                turn += 1
            colours[name] = _paint(turn, _hue(turn))
            turn += 1
    return colours


def _hue(turn: int) -> float:
    """The hue of an object whose name says no colour."""
    return (0.06 + turn * _GOLDEN_TURN) % 1.0


def _paint(number: int, hue: float) -> Colour:
    """A colour of muted strength; three in turn differ in lightness."""
    red, green, blue = colorsys.hls_to_rgb(hue, _LIGHTNESS[number % 3], _SATURATION)
    return round(255 * red), round(255 * green), round(255 * blue)


def colour_word(colour: Colour) -> str:
    """Say in a word which colour something has: the name of a hue, or black, grey, white or brown."""
    hue, light, _ = colorsys.rgb_to_hls(*np.divide(colour, 255).tolist())
    if max(colour) - min(colour) < _GREY * max(colour) or max(colour) < 255 * _BLACK:
        return "black" if light < _BLACK else "white" if light > _WHITE else "grey"
    word = min(_HUES, key=lambda name: abs((hue - _HUES[name] + 0.5) % 1.0 - 0.5))
    pale = max(colour) - min(colour) < 2 * _GREY * max(colour) and light < 0.5
    return "brown" if word in ("red", "orange") and pale else word


def css(colour: Colour) -> str:
    """The colour as CSS writes it, `#rrggbb`."""
    return "#{:02x}{:02x}{:02x}".format(*colour)


def ink_on(colour: Colour) -> Colour:
    """Black or white, whichever is easier to read on a colour (relative luminance of WCAG 2)."""
    part = np.divide(colour, 255)
    linear = np.where(part <= 0.04045, part / 12.92, ((part + 0.055) / 1.055) ** 2.4)
    return (255, 255, 255) if float(np.dot(linear, (0.2126, 0.7152, 0.0722))) < 0.179 else (0, 0, 0)


def relation_colour(relation: str) -> Colour:
    """Colour of a relation's line; grey for a name this version does not know."""
    return RELATION_COLOURS.get(relation, RELATION_COLOURS[Relation.DISJOINT])


def reason_colour(reason: str) -> Colour:
    """Colour of a dependency's arrow; grey for a reason this version does not know."""
    return REASON_COLOURS.get(reason, FIXED_COLOUR)
