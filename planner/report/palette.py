"""The colours of the pages and pictures: relations as in the paper's Figure 6, objects apart from them."""

import colorsys
from collections.abc import Collection, Iterable

from topple.topology.relation import Relation

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
    "supported": (88, 96, 105),
    "leaning": (202, 103, 2),
    "contained": (0, 128, 128),
    "blocking": (142, 68, 173),
    "counterweight": (121, 85, 72),
}
"""One colour for each reason a dependency can have."""

FIXED_COLOUR: Colour = (158, 156, 148)
"""Tables and shelves: grey, because nobody takes them away."""

_GOLDEN_TURN = 0.61803398875
_LIGHTNESS = (0.58, 0.44, 0.68)


def object_colours(names: Iterable[str], fixed: Collection[str] = ()) -> dict[str, Colour]:
    """Give every object a colour of its own, the same in every picture of the same scene.

    Args:
        names: Object names in the scene's order.
        fixed: Names drawn in grey.

    Returns:
        Name -> colour. Hues step by the golden ratio, so that neighbours in the list never look alike;
        saturation stays below that of the relation colours, so that lines stand out from clouds.
    """
    colours: dict[str, Colour] = {}
    turn = 0
    for name in names:
        if name in fixed:
            colours[name] = FIXED_COLOUR
            continue
        hue = (0.09 + turn * _GOLDEN_TURN) % 1.0
        red, green, blue = colorsys.hls_to_rgb(hue, _LIGHTNESS[turn % 3], 0.48)
        colours[name] = (round(red * 255), round(green * 255), round(blue * 255))
        turn += 1
    return colours


def css(colour: Colour) -> str:
    """The colour as CSS writes it, `#rrggbb`."""
    return "#{:02x}{:02x}{:02x}".format(*colour)


def relation_colour(relation: str) -> Colour:
    """Colour of a relation's line; grey for a name this version does not know."""
    return RELATION_COLOURS.get(relation, RELATION_COLOURS[Relation.DISJOINT])


def reason_colour(reason: str) -> Colour:
    """Colour of a dependency's arrow; grey for a reason this version does not know."""
    return REASON_COLOURS.get(reason, FIXED_COLOUR)
