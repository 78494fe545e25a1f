"""Worlds rebuilt from what was seen, in which things are lifted and let go."""
