"""What a hand can meet around an object, and whose points those are."""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from topple.planner.grasp.tolerances import GRASP_TOLERANCES
from topple.topology.base.arrays import BoolArray, FloatArray, IntArray, bounds, freeze
from topple.topology.bodies.matter import MATTER
from topple.topology.bodies.tops import tops_of
from topple.topology.geometry.thin import voxel_means
from topple.topology.scene.scene import Scene

ITSELF = "its own sides"


@dataclass(frozen=True, eq=False)
class Surroundings:
    """Points of everything else near an object.

    Attributes:
        points: (M, 3) points in the world [m].
        owners: (M,) whose each is: a place in `names`.
        names: The objects.
        floor: Height of the fixed ground under the object along up [m], -inf where nothing is fixed.
    """

    points: FloatArray
    owners: IntArray
    names: tuple[str, ...]
    floor: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "points", freeze(self.points))

    def near(self, place: FloatArray, distance: float) -> "Surroundings":
        """Those within a distance [m] of a place (3,)."""
        close = np.linalg.norm(self.points - place, axis=1) < distance
        return Surroundings(self.points[close], self.owners[close], self.names, self.floor)

    def met(self, which: BoolArray) -> str:
        """Whose points most of some are; "" where there are none."""
        counts = np.bincount(self.owners[which], minlength=1)
        return self.names[int(np.argmax(counts))] if counts.any() else ""


@dataclass
class Dropped:
    """What a search for grasps left out: hand directions at depths of the fingers, and places of a cup.

    Attributes:
        reasons: Why, with counts.
        barring: Objects that left the hand no room, with counts.
    """

    reasons: Counter[str] = field(default_factory=Counter[str])
    barring: Counter[str] = field(default_factory=Counter[str])

    def __post_init__(self) -> None:
        self._narrowest, self._wide = np.inf, ""

    def note(self, reason: str, count: int = 1) -> None:
        """Count what was left out for a reason."""
        if count > 0:
            self.reasons[reason] += count

    def too_wide(self, widths: FloatArray, spare: float, opens: float) -> None:
        """Count what is too wide, and say by the least of all widths.

        Args:
            widths: (N,) [m].
            spare: What a hand wants beside that [m].
            opens: How far it opens [m].
        """
        if len(widths):
            count, self._narrowest = (
                self.reasons.pop(self._wide, 0),
                min(self._narrowest, float(widths.min())),
            )
            self._wide = (
                f"wider than the hand opens: {1e3 * self._narrowest:.0f} mm at the least and "
                f"{1e3 * spare:.0f} mm to spare, of {1e3 * opens:.0f} mm"
            )
            self.note(self._wide, count + len(widths))

    def no_room(self, what: str, beside: str, count: int = 1) -> None:
        """Count what was left out because a part of the hand would meet an object, or `ITSELF`."""
        self.note(f"no room for the {what} beside {beside}", count)
        if count > 0 and beside != ITSELF:
            self.barring[beside] += count


def surroundings(name: str, scene: Scene, up: FloatArray) -> Surroundings:
    """Everything a hand could meet around an object.

    Args:
        name: The object.
        scene: The scene.
        up: (3,) unit vector against gravity.

    Returns:
        The points of the others within reach, and the ground.
    """
    reached = dict(_within_reach(name, scene, (*scene.clouds, MATTER)))
    spacing = GRASP_TOLERANCES.spacing
    near = {other: voxel_means(within, spacing, ahead=0.0) for other, within in reached.items()}
    fixed = {other: within for other, within in reached.items() if other in scene.fixed}
    floor = _ground(name, fixed, scene, up)
    owners = np.repeat(np.arange(len(near)), [len(points) for points in near.values()])
    return Surroundings(np.vstack([np.empty((0, 3)), *near.values()]), owners, tuple(near), floor)


def floor_near(name: str, scene: Scene, up: FloatArray) -> float:
    """Height of the fixed ground around an object along up [m], -inf where nothing is fixed.

    Args:
        name: The object.
        scene: The scene.
        up: (3,) unit vector against gravity.
    """
    return _ground(name, dict(_within_reach(name, scene, scene.fixed)), scene, up)


def _within_reach(name: str, scene: Scene, others: Iterable[str]) -> Iterator[tuple[str, FloatArray]]:
    """Those of some others that have points where a hand at an object could meet them, with these."""
    lower, upper = bounds(scene.clouds[name])
    lower, upper = lower - GRASP_TOLERANCES.reach, upper + GRASP_TOLERANCES.reach
    for other in others:
        cloud = scene.matter if other == MATTER else scene.clouds[other]
        within = np.all((cloud > lower) & (cloud < upper), axis=1)
        if other != name and within.any():
            yield other, cloud[within]


def _ground(name: str, fixed: Mapping[str, FloatArray], scene: Scene, up: FloatArray) -> float:
    """Height of the highest top under an object among what never moves, by its points around [m].

    Where nothing has a top under it, the lowest tenth of what is there; a bench beside it is no ground.
    """
    levels: list[float] = []
    for other, within in fixed.items():
        if (top := tops_of(scene.clouds[other], up).under(scene.clouds[name])) is not None:
            lower, upper = bounds(within)
            beside = top.points[np.all((top.points >= lower) & (top.points <= upper), axis=1)]
            levels.append(float(np.quantile((beside if len(beside) else top.points) @ up, 0.1)))
    uneven = (float(np.quantile(within @ up, 0.1)) for within in fixed.values())
    return max(levels, default=max(uneven, default=-np.inf))
