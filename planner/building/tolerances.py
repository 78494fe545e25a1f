"""Thresholds of building, each with its unit and reason, by the module that asks them."""

# -- prefixes

MOST_STATES = 4000
"""Partial arrangements looked at until fewest holds are no longer proven: all there are of twelve objects."""

# -- standing

OFF_CENTRE = 0.008
"""[m] by which masses may be aside of where they seem to be: half a centimetre that a shape leaves open, and
the 3 mm beyond the last support that statics concedes."""
