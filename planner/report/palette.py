"""The colours of the pages and pictures: relations as in the paper's Figure 6, objects apart from them."""

import colorsys
import re
from collections import Counter
from collections.abc import Collection, Iterable

import numpy as np

from topple.planner.decide.names import HUES, Colour
from topple.topology.sixim.table import Relation

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
    said_of = {name: [w for w in re.findall("[a-z]+", name.lower()) if w in HUES] for name in every}
    words = {name: found[0] for name, found in said_of.items() if found and name not in fixed}
    taken, turn, said = [HUES[word] for word in words.values()], 0, Counter[str]()
    colours: dict[str, Colour] = {}
    for name in every:
        if name in fixed:
            colours[name] = FIXED_COLOUR
        elif word := words.get(name):
            colours[name] = _paint(said[word], HUES[word])
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
