"""The colours of the pages and pictures: relations as in the paper's Figure 6, objects apart from them."""

import math
import re
from collections import Counter
from collections.abc import Collection, Iterable

import numpy as np

from topple.topology.sixim.table import Relation

Colour = tuple[int, int, int]
"""Red, green, blue, 0..255."""

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
    "lying": (94, 108, 60),
    "contained": (0, 128, 128),
    "blocking": (142, 68, 173),
    "counterweight": (121, 85, 72),
}
"""One colour for each reason a dependency can have, as it is said."""

FIXED_COLOUR: Colour = (158, 156, 148)
"""Tables and shelves: grey, because nobody takes them away."""

_GOLDEN_TURN = 0.61803398875
_LIGHTNESS = (0.62, 0.50, 0.70)
_CHROMA = 0.105
_HUES = {
    "red": 0.08,
    "orange": 0.16,
    "yellow": 0.28,
    "green": 0.40,
    "blue": 0.72,
    "purple": 0.84,
    "pink": 0.97,
}
"""Turns of the hue that a word in a name stands for: a cube called green is drawn green."""


def object_colours(names: Iterable[str], fixed: Collection[str] = ()) -> dict[str, Colour]:
    """Give every object a colour of its own, the same in every picture of the same scene.

    Args:
        names: Object names in the scene's order.
        fixed: Names drawn in grey.

    Returns:
        Name -> colour. Hues step by the golden ratio, so that neighbours in the list never look alike;
        chroma stays below that of the relation colours, so that lines stand out from clouds. Where a word
        of the name is a colour, it has that hue.
    """
    every = tuple(names)
    words = {name: word for name in every if name not in fixed and (word := _colour_word(name))}
    taken = [_HUES[word] for word in words.values()]
    colours: dict[str, Colour] = {}
    said = Counter[str]()
    turn = 0
    for name in every:
        if name in fixed:
            colours[name] = FIXED_COLOUR
        elif name in words:
            word = words[name]
            colours[name] = _oklch(_LIGHTNESS[said[word] % 3], _CHROMA, _HUES[word])
            said[word] += 1
        else:
            while any(_alike(_hue(turn), hue) for hue in taken):
                turn += 1
            colours[name] = _oklch(_LIGHTNESS[turn % 3], _CHROMA, _hue(turn))
            turn += 1
    return colours


def _colour_word(name: str) -> str:
    """The first word of a name that is a colour, empty where none is."""
    return next((word for word in re.findall("[a-z]+", name.lower()) if word in _HUES), "")


def _hue(turn: int) -> float:
    """The hue of an object whose name says no colour."""
    return (0.17 + turn * _GOLDEN_TURN) % 1.0


def _alike(one: float, other: float) -> bool:
    """Whether two hues look the same: under a twentieth of a turn; all words in use leave some."""
    return abs((one - other + 0.5) % 1.0 - 0.5) < 0.05


def _oklch(lightness: float, chroma: float, hue: float) -> Colour:
    """A colour of the OKLab space, in which equal numbers look equally light and strong.

    The two matrices are those of B. Ottosson, "A perceptual color space for image processing" (2020).
    """
    a, b = chroma * math.cos(2 * math.pi * hue), chroma * math.sin(2 * math.pi * hue)
    long = (lightness + 0.3963377774 * a + 0.2158037573 * b) ** 3
    medium = (lightness - 0.1055613458 * a - 0.0638541728 * b) ** 3
    short = (lightness - 0.0894841775 * a - 1.2914855480 * b) ** 3
    return (
        _encoded(4.0767416621 * long - 3.3077115913 * medium + 0.2309699292 * short),
        _encoded(-1.2684380046 * long + 2.6097574011 * medium - 0.3413193965 * short),
        _encoded(-0.0041960863 * long - 0.7034186147 * medium + 1.7076147010 * short),
    )


def _encoded(linear: float) -> int:
    """A linear light value as an sRGB byte."""
    value = min(max(linear, 0.0), 1.0)
    return round(255 * (12.92 * value if value <= 0.0031308 else 1.055 * value ** (1 / 2.4) - 0.055))


def css(colour: Colour) -> str:
    """The colour as CSS writes it, `#rrggbb`."""
    return "#{:02x}{:02x}{:02x}".format(*colour)


def ink_on(colour: Colour) -> Colour:
    """Black or white, whichever is easier to read on a colour (relative luminance of WCAG 2)."""
    linear = [
        part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4
        for part in np.divide(colour, 255)
    ]
    return (255, 255, 255) if float(np.dot(linear, (0.2126, 0.7152, 0.0722))) < 0.179 else (0, 0, 0)


def relation_colour(relation: str) -> Colour:
    """Colour of a relation's line; grey for a name this version does not know."""
    return RELATION_COLOURS.get(relation, RELATION_COLOURS[Relation.DISJOINT])


def reason_colour(reason: str) -> Colour:
    """Colour of a dependency's arrow; grey for a reason this version does not know."""
    return REASON_COLOURS.get(reason, FIXED_COLOUR)
