"""Which thing of a finished arrangement is which of the start, where their names do not say: by shape."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import linear_sum_assignment

from topple.planner.rearranging.registration import register
from topple.planner.rearranging.tolerances import NEARER, SIZES, UNLIKE
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput
from topple.topology.scene.scene import Scene


@dataclass(frozen=True)
class Match:
    """A thing of the start and the one of the goal that it is taken to be.

    Attributes:
        object: Its name at the start.
        goal: Its name in the goal.
        residual: How far their clouds are apart once they are registered [m].
    """

    object: str
    goal: str
    residual: float

    def __str__(self) -> str:
        """In words."""
        return f"{self.object} is taken to be {self.goal} of the goal: {1e3 * self.residual:.1f} mm apart"


def match_objects(start: Scene, goal: Scene, up: FloatArray) -> tuple[Scene, tuple[Match, ...]]:
    """Match what moves in two scenes by shape, and name what is in the goal as at the start.

    Every thing is registered with every one of its size; of all one-to-one matches the one with the least
    residuals is taken (Hungarian method), and of those about as good the one with the shortest ways. Things
    of one shape may stand in for each other.

    Args:
        start: How things lie.
        goal: How they shall lie.
        up: (3,) unit vector against gravity in both.

    Returns:
        The goal with the names of the start, and the matches.

    Raises:
        InvalidInput: One has more things than the other, or a thing is like none that is left.
    """
    here, there = start.movable, goal.movable
    if len(here) != len(there):
        raise InvalidInput(
            f"{len(here)} things move at the start and {len(there)} in the goal: expected as many"
        )
    costs = np.full((len(here), len(there)), np.inf)
    residuals = costs.copy()
    for i, name in enumerate(here):
        for j, other in enumerate(there):
            if np.abs(_block_size(start.clouds[name]) - _block_size(goal.clouds[other])).max() < SIZES:
                fit = register(start.clouds[name], goal.clouds[other], up)
                residuals[i, j], costs[i, j] = fit.residual, fit.residual + NEARER * fit.way
    rows, columns = linear_sum_assignment(np.minimum(costs, 1.0))
    found = [Match(here[i], there[j], float(residuals[i, j])) for i, j in zip(rows, columns, strict=True)]
    for match in found:
        if match.residual > UNLIKE:
            left = np.isfinite(match.residual)
            far = f" ({match.goal} is {1e3 * match.residual:.0f} mm off)" if left else ""
            raise InvalidInput(f"nothing that is left in the goal has the shape of {match.object}{far}")
    return _rename(goal, {match.goal: match.object for match in found}), tuple(found)


def _block_size(cloud: FloatArray) -> FloatArray:
    """(3,) edges of a solid block that spreads as a cloud does, shortest first [m], however turned."""
    return np.sqrt(12 * np.linalg.eigvalsh(np.cov(cloud.T)).clip(0))


def _rename(scene: Scene, names: Mapping[str, str]) -> Scene:
    """A scene with other names."""

    def name_of(name: str) -> str:
        return names.get(name, name)

    return Scene(
        {name_of(name): cloud for name, cloud in scene.clouds.items()},
        sorted(map(name_of, scene.fixed)),
        scene.up,
        scene.viewpoints if len(scene.viewpoints) else None,
        [replace(one, names={k: name_of(name) for k, name in one.names.items()}) for one in scene.images],
        assumptions=scene.assumptions,
        masses={name_of(name): mass for name, mass in scene.masses.items()},
        friction={name_of(name): value for name, value in scene.friction.items()},
        models={name_of(name): fit for name, fit in scene.models.items()},
        matter=scene.matter,
        centres={name_of(name): centre for name, centre in scene.centres.items()},
    )
