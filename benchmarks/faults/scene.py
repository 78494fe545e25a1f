"""A small scene to break things in: one box on another, and a block that stands beside them."""

import numpy as np
from scipy.spatial.transform import Rotation

from topple.robots.scenarios.scenario import Scenario, pose_at, settle, settled
from topple.robots.shapes import box
from topple.robots.world.bodies import Body
from topple.robots.world.physical_world import PhysicalWorld

LOWER, UPPER, ASIDE = "lower", "upper", "aside"


def small_scene(seed: int, robot: str = "panda") -> Scenario:
    """Make the scene: `upper` stands on `lower`, `aside` a hand's width or two from them.

    Args:
        seed: Any number.
        robot: The arm; one with a cup gets boxes that no jaw spans, to be taken from above by the cup.

    Returns:
        The scenario; its goal is to free `lower`, which takes two actions.
    """
    wide = "suction" in robot

    def layout(world: PhysicalWorld, rng: np.random.Generator) -> tuple[str, tuple[str, ...]]:
        x, y = rng.uniform(-0.05, 0.05, 2)
        lower, upper, aside = _bodies(rng, wide)
        height = float(np.ptp(np.concatenate(lower.parts)[:, 2]))
        turns = [Rotation.from_euler("z", angle) for angle in rng.uniform(0.0, np.pi, 3)]
        away = rng.uniform(0.0, 2.0 * np.pi)
        beside = rng.uniform(0.14, 0.18) + (0.06 if wide else 0.0)
        world.add(lower, pose_at(x, y, 0.0005, turns[0]))
        world.add(upper, pose_at(x, y, height + 0.001, turns[1]))
        world.add(aside, pose_at(x + beside * np.cos(away), y + beside * np.sin(away), 0.0005, turns[2]))
        settle(world)
        return f"free {LOWER}", (LOWER,)

    return settled(f"faults-{robot}", seed, layout, robot=robot)


def _bodies(rng: np.random.Generator, wide: bool) -> tuple[Body, Body, Body]:
    """Lower, upper and aside; wide ones span 10 cm and more."""
    least, most = (0.10, 0.13) if wide else (0.05, 0.065)
    a, b = rng.uniform(least, most, 2)
    c, d = rng.uniform(0.9 * least, 0.85 * most, 2)
    low, high, tall = rng.uniform([0.05, 0.04, 0.05], [0.07, 0.06, 0.10])
    return (
        box(LOWER, (a, b, low), density=300.0, color=(0.30, 0.50, 0.72, 1.0)),
        box(UPPER, (c, d, high), density=300.0, color=(0.78, 0.33, 0.25, 1.0)),
        box(ASIDE, (0.045, 0.05, tall), density=300.0, color=(0.42, 0.62, 0.33, 1.0)),
    )
