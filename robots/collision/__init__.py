"""Convex parts made ready for collision checks."""
