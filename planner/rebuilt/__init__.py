"""Worlds rebuilt in simulation from what was seen of a scene at rest."""
