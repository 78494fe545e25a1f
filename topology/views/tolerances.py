"""Thresholds of views, each with its unit and reason, by the module that asks them."""

import numpy as np

# -- free_space

WIDTH = float(np.radians(1.0))
"""A line of sight speaks for directions this close [rad]: the spacing of a thinned surface from 50 cm."""

MARGIN = 0.012
"""A place is seen to be empty where the surface behind it is this much [m] further off."""

WITNESSES = 3
"""Lines of sight that must agree: at an outline one neighbour alone may belong to the background."""

BORDER = 3
"""Pixels that the border of a mask may be off: three times what a good segmentation's wanders by."""

PATCH = 9
"""Pixels along the side of the patch that a surface is continued from: a few of noise are averaged out."""

NARROW = 0.3
"""[pixels^2] added to a patch's spread, so that one of a single row has no slope across it."""

OFF = 0.004
"""[m] at a metre and nearer, beyond with its square, that a pixel lies off its mask's surface when it is
another's: above a depth camera's noise."""

CLOSER = 0.5
"""Share of that distance at which it must lie from the other's, at most: flying pixels are of neither."""

OFF_BORDERS = 0.025
"""Share of the pixels at borders from which masks are mended: of exact masks flying pixels come to 2.0 % at
most (54 pictures), of 67 recorded ones drawn by hand to 1.1 %, of masks a pixel off to 3.5 to 6 %."""
