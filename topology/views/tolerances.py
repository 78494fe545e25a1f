"""Thresholds of views, each with its unit and reason, by the module that asks them."""

import numpy as np

# -- free_space

WIDTH = float(np.radians(1.0))
"""A line of sight speaks for directions this close [rad]: the spacing of a thinned surface from 50 cm."""

MARGIN = 0.012
"""A place is seen to be empty where the surface behind it is this much [m] further off."""

WITNESSES = 3
"""Lines of sight that must agree: at an outline one neighbour alone may belong to the background."""
