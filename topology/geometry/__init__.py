"""Geometry of clouds that knows nothing of relations: hulls, planes, round bodies, outlines."""
