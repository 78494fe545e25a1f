"""Thresholds of building, each with its unit and reason, by the module that asks them."""

# -- prefixes

MOST_STATES = 4000
"""Partial arrangements looked at until fewest holds are no longer proven: all there are of twelve objects."""
