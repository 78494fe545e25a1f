"""What things are made of: the density and the friction of what nobody weighed or tried."""

from collections.abc import Mapping
from math import sqrt

from topple.topology.scene.tolerances import FRICTION

SURFACE = sqrt(FRICTION)
"""What a surface nobody tried contributes: two of them touch with `FRICTION`."""

SLIPPERIEST, ROUGHEST = 0.0, 10.0
"""Coefficients of a surface that are taken: PyBullet cuts the product of two at 10, and angles, percent and
other units are mostly above."""


def friction_between(friction: Mapping[str, float], a: str, b: str) -> float:
    """Coefficient of friction of two objects that touch.

    The coefficients of their surfaces are multiplied, as PyBullet does (`calculateCombinedFriction` in
    Bullet's btManifoldResult.cpp): what holds in its world holds here with the same numbers.

    Args:
        friction: Coefficient of the surface of each object that has been tried; `SURFACE` for the others.
        a: One object.
        b: The other.

    Returns:
        The coefficient, at most `ROUGHEST`; exactly `FRICTION` where nobody tried either.
    """
    if a not in friction and b not in friction:
        return FRICTION
    return min(friction.get(a, SURFACE) * friction.get(b, SURFACE), ROUGHEST)
