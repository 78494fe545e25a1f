"""A suction cup: its stroke, what its lip holds, how it takes and what is said of it."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from topple.robots.arm.gripper import SUCTION, Gripper, ToolState
from topple.robots.arm.tolerances import CUP_FRICTION, GRIPPED, LIP_TOUCH
from topple.topology.base.arrays import FloatArray

if TYPE_CHECKING:
    from topple.robots.driver import Driver


def vacuum_load(
    pull: float, shear: float, bending: float, twist: float, *, force: float, radius: float, friction: float
) -> float:
    """Share of what holds a cup's lip that a load on it takes: at 1 it lets go.

    The vacuum presses the lip on. What pulls takes from that; what shears needs as much of it as friction
    takes to bear it, as in the theoretical holding force m (g + a / mu) of Schmalz ("The Vacuum System and
    its Components", load cases I to III); a moment takes as much as its pull on the lip's edge.

    Args:
        pull: Along the axis, away from the cup in [N]; negative presses.
        shear: Across the axis in [N].
        bending: Moment across the axis in [N m].
        twist: Moment about the axis in [N m].
        force: Of the vacuum on the lip's area in [N].
        radius: Of the lip in [m].
        friction: Coefficient between lip and surface.
    """
    return (pull + math.hypot(shear, twist / radius) / friction + bending / radius) / force


def lip_plane(ring: FloatArray, heights: FloatArray) -> tuple[FloatArray, float]:
    """How a lip lies on a surface: what a planner asks of clouds, and a simulated cup of what it meets.

    Args:
        ring: (k, 2) places around the lip in [m], k >= 3, the lip's centre at the origin.
        heights: (k,) of the surface there in [m].

    Returns:
        (3,) the plane a x + b y + c [m] that a bellows follows, and the largest distance of the surface from
        it [m], which the lip has to bridge.
    """
    rows = np.column_stack([ring, np.ones(len(ring))])
    plane: FloatArray = np.linalg.lstsq(rows, heights, rcond=None)[0].astype(np.float64)
    return plane, float(np.abs(rows @ plane - heights).max())


@dataclass(frozen=True)
class SuctionCup(Gripper):
    """A vacuum cup: holds where its whole lip seals, and below its force limit.

    Attributes:
        link: Link of the cup: it may touch what is held.
        joint: Prismatic joint that pushes the cup out of the palm, or None if the cup stands fixed.
        stroke: Travel of that joint in [m].
        radius: Lip radius in [m].
        max_force: Pull at which it lets go in [N]: vacuum times lip area.
        lip_depth: How much unevenness under the lip the rubber bridges in [m].
        speed: Speed of the stroke in [m/s].
        friction: Coefficient between its lip and what it takes.
        retracts: Whether a drive draws it in on the way; a sprung plunger stands out unless it is pressed.
    """

    link: str
    joint: str | None
    stroke: float
    radius: float
    max_force: float
    lip_depth: float = 0.002
    speed: float = 0.2
    retracts: bool = True
    friction: float = CUP_FRICTION

    tool: ClassVar[str] = SUCTION
    touch: ClassVar[float] = LIP_TOUCH
    presses: ClassVar[bool] = True

    @property
    def touching(self) -> tuple[str, ...]:
        """Links that touch what is held."""
        return (self.link,)

    @property
    def cup(self) -> "SuctionCup":
        """Itself."""
        return self

    @property
    def limits(self) -> ToolState:
        """Pushed out."""
        return ToolState(cup_extension=self.stroke)

    @property
    def stowed(self) -> float:
        """How far it stands out on the way in [m]."""
        return 0.0 if self.retracts else self.stroke

    def values(self, state: ToolState) -> dict[str, float]:
        """Joint values at an extension, clipped to the stroke."""
        return {} if self.joint is None else {self.joint: float(np.clip(state.cup_extension, 0, self.stroke))}

    def take(self, robot: "Driver", name: str) -> str | None:
        """Switch the vacuum on; a sentence where the lip does not seal."""
        robot.wait(GRIPPED)
        return None if robot.suck() else f"the cup found no seal on {name}."

    def data(self) -> dict[str, Any]:
        """Describe the tool for a plan."""
        kept = ("link", "joint", "stroke", "radius", "lip_depth", "friction")
        return {"cup": {**{key: getattr(self, key) for key in kept}, "force": self.max_force}}

    def facts(self) -> dict[str, Any]:
        """Describe the tool for `topple robot --json`."""
        return {"kind": "cup", "radius": self.radius, "stroke": self.stroke, "force": self.max_force}

    def __str__(self) -> str:
        """In words."""
        return f"a cup of radius {1e3 * self.radius:.0f} mm that holds {self.max_force:.0f} N"
