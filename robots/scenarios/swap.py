"""Two objects that stand in each other's places, and a third beside them: exchange the two."""

from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from topple.robots.scenarios.scenario import Scenario, lay, pose_at, to_copy
from topple.robots.shapes import box, can, mug
from topple.robots.world.bodies import Body
from topple.robots.world.physical_world import PhysicalWorld
from topple.topology.base.arrays import FloatArray

THINGS = (
    lambda: box("box", (0.10, 0.06, 0.08), color=(0.30, 0.50, 0.72, 1.0)),
    lambda: can("can"),
    lambda: mug("mug"),
)
APART = (0.22, 0.30)  # [m] between the two


def swap(seed: int = 0) -> Scenario:
    """Make the scene: a box, a can and a mug, of which two shall change places.

    Args:
        seed: Any number.

    Returns:
        The scenario: `box`, `can` and `mug`; each of the two has to stand where the other one does.
    """
    return to_copy("swap", seed, _lay_out)


def _lay_out(
    world: PhysicalWorld, finished: PhysicalWorld, rng: np.random.Generator
) -> tuple[str, tuple[str, ...]]:
    bodies = [THINGS[k]() for k in rng.permutation(len(THINGS))]
    middle = np.array([rng.uniform(-0.05, 0.03), rng.uniform(-0.05, 0.05)])
    angle, half = rng.uniform(np.pi / 4, 3 * np.pi / 4), rng.uniform(*APART) / 2
    out = half * np.array([np.cos(angle), np.sin(angle)])
    aside = middle + rng.choice([-1, 1]) * rng.uniform(0.16, 0.2) * np.array([np.sin(angle), -np.cos(angle)])
    places = [middle + out, middle - out, aside]
    headings = rng.uniform(0, 2 * np.pi, 3)
    lay(world, _at(bodies, places, headings))
    turned = np.append(rng.uniform(0, 2 * np.pi, 2), headings[2])
    lay(finished, _at(bodies, [places[1], places[0], places[2]], turned))
    names = bodies[0].name, bodies[1].name
    return ", ".join(f"{name} on table" for name in names), names


def _at(bodies: Sequence[Body], places: Sequence[FloatArray], headings: FloatArray) -> dict[Body, FloatArray]:
    """Poses (4, 4) of things that stand on the table."""
    return {
        body: pose_at(float(place[0]), float(place[1]), 0.0, Rotation.from_euler("z", float(heading)))
        for body, place, heading in zip(bodies, places, headings, strict=True)
    }
