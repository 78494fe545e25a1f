"""Collision checking, motion planning, certificates and trajectories."""
