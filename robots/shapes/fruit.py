"""Fruit and balls: solids of revolution with the mass of their volume, most fruit just floating in water."""

from collections.abc import Sequence

import numpy as np

from topple.robots.shapes.materials import FRUIT
from topple.robots.shapes.vessel import circle, closed_surface, rings
from topple.robots.world.bodies import Body, Color
from topple.topology.base.arrays import FloatArray

SIDES = 18  # of every circle: a 7 cm orange is round within 0.6 mm


def ball(name: str = "ball", *, diameter: float = 0.065) -> Body:
    """A tennis ball of a diameter in [m]; 58 g."""
    return _upright_solid(name, _egg(diameter / 2, diameter / 2), "ball", (0.8, 0.9, 0.2, 1.0), mass=0.058)


def orange(name: str = "orange", *, diameter: float = 0.073) -> Body:
    """An orange of a diameter in [m]; 0.19 kg."""
    return _upright_solid(name, _egg(diameter / 2, diameter / 2), "orange", (0.95, 0.55, 0.1, 1.0))


def apple(name: str = "apple", *, diameter: float = 0.075) -> Body:
    """An apple of a diameter in [m], flattened at both ends; 0.19 kg."""
    r = diameter / 2
    profile = [(0.42 * r, -0.86 * r), (0.80 * r, -0.62 * r), (0.97 * r, -0.15 * r), (r, 0.1 * r)]
    profile += [(0.93 * r, 0.5 * r), (0.70 * r, 0.78 * r), (0.35 * r, 0.86 * r)]
    return _upright_solid(name, profile, "apple", (0.7, 0.12, 0.1, 1.0))


def plum(name: str = "plum", *, diameter: float = 0.05) -> Body:
    """A plum of a diameter in [m], a tenth longer than wide; 70 g."""
    return _lying_solid(name, _egg(diameter / 2, 1.1 * diameter / 2), "plum", (0.35, 0.1, 0.3, 1.0))


def lemon(name: str = "lemon", *, diameter: float = 0.055, length: float = 0.075) -> Body:
    """A lemon, lying along x: diameter and length in [m]; 0.11 kg."""
    r, half = diameter / 2, length / 2
    side = [(0.13 * r, -1.0), (0.30 * r, -0.90), (0.62 * r, -0.74), (0.90 * r, -0.40), (r, 0.0)]
    profile = [(radius, z * half) for radius, z in side]
    profile += [(radius, -z) for radius, z in reversed(profile[:-1])]
    return _lying_solid(name, profile, "lemon", (0.95, 0.85, 0.15, 1.0))


def strawberry(name: str = "strawberry", *, diameter: float = 0.038, length: float = 0.045) -> Body:
    """A strawberry, lying along x: diameter and length in [m]; 25 g."""
    r = diameter / 2
    profile = [(0.12 * r, 0.0), (0.45 * r, 0.15 * length), (0.85 * r, 0.5 * length), (r, 0.75 * length)]
    profile += [(0.85 * r, 0.93 * length), (0.45 * r, length)]
    return _lying_solid(name, profile, "strawberry", (0.85, 0.1, 0.15, 1.0))


def pear(name: str = "pear", *, diameter: float = 0.066, length: float = 0.095) -> Body:
    """A pear, lying along x: diameter and length in [m]; 0.16 kg."""
    r = diameter / 2
    belly = [(0.4 * r, 0.0), (0.8 * r, 0.07 * length), (r, 0.3 * length), (0.85 * r, 0.5 * length)]
    neck = [(0.85 * r, 0.5 * length), (0.5 * r, 0.75 * length), (0.42 * r, 0.93 * length), (0.2 * r, length)]
    stack = [rings(circle(SIDES), half) for half in (belly, neck)]
    whole = _on_its_side(np.concatenate([stack[0], stack[1][1:]]))
    return _fruit(name, whole, [whole[:4], whole[3:5], whole[4:]], "pear", (0.75, 0.8, 0.25, 1.0))


def banana(name: str = "banana", *, length: float = 0.19, thickness: float = 0.036) -> Body:
    """A banana lying on its side, bent in the plane of the table: length and thickness in [m]; 0.13 kg."""
    bend = np.linspace(-0.75, 0.75, 8)  # [rad] along the arc
    radius = length / 2 / np.sin(bend[-1])
    share = np.array([0.28, 0.62, 0.9, 1.0, 1.0, 0.9, 0.6, 0.3])
    ring = np.c_[circle(10), np.zeros(10)]
    stack = np.empty((len(bend), 10, 3))
    for section, angle, scale in zip(stack, bend, share, strict=True):
        outward = np.array([np.sin(angle), np.cos(angle), 0.0])
        r = scale * thickness / 2
        section[:] = radius * outward + r * (ring[:, :1] * outward + ring[:, 1:2] * np.array([0.0, 0.0, 1.0]))
    stack = _set_on_ground(stack)
    pairs = [stack[k : k + 2] for k in range(len(stack) - 1)]
    return _fruit(name, stack, pairs, "banana", (0.95, 0.85, 0.3, 1.0))


def _egg(radius: float, half: float) -> list[tuple[float, float]]:
    """Profile of an ellipsoid of revolution: radius across, half-length along, in [m]."""
    angles = np.radians([-83, -66, -45, -22, 0, 22, 45, 66, 83])
    return [(float(radius * np.cos(a)), float(half * np.sin(a))) for a in angles]


def _upright_solid(
    name: str, profile: Sequence[tuple[float, float]], kind: str, color: Color, mass: float | None = None
) -> Body:
    """A convex solid of revolution that stands on its axis."""
    stack = _set_on_ground(rings(circle(SIDES), profile))
    return _fruit(name, stack, [stack], kind, color, mass)


def _lying_solid(name: str, profile: Sequence[tuple[float, float]], kind: str, color: Color) -> Body:
    """A convex solid of revolution with its axis along x."""
    stack = _on_its_side(rings(circle(SIDES), profile))
    return _fruit(name, stack, [stack], kind, color)


def _on_its_side(stack: FloatArray) -> FloatArray:
    """Turn a stack's axis from z to x and set it down."""
    return _set_on_ground(stack[..., [2, 0, 1]])


def _set_on_ground(stack: FloatArray) -> FloatArray:
    """Centre a stack of rings over its box and set it on z = 0."""
    low, high = stack.min(axis=(0, 1)), stack.max(axis=(0, 1))
    return stack - [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, low[2]]


def _fruit(
    name: str,
    stack: FloatArray,
    parts: Sequence[FloatArray],
    kind: str,
    color: Color,
    mass: float | None = None,
) -> Body:
    surface, corners = closed_surface(stack), [part.reshape(-1, 3) for part in parts]
    return FRUIT.body(name, corners, surface, kind=kind, color=color, mass=mass)
