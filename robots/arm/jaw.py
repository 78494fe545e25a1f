"""Two fingers that close on an object: their states, what they fill, how they take, what is said of them."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from topple.robots.arm.gripper import FINGERS, Gripper, ToolState
from topple.robots.arm.tolerances import CLOSED_ON_NOTHING, FINGER_SLABS, GRIPPED, PRESS, TRIAL_SHARE
from topple.robots.collision.prisms import Prism, prisms
from topple.topology.base.arrays import FloatArray

if TYPE_CHECKING:
    from topple.robots.driver import Driver

Bodies = Callable[[float], list[tuple[str, FloatArray]]]
"""Convex bodies (V, 3) of the hand in the tool frame [m], with their links, at an opening [m]."""


@dataclass(frozen=True, eq=False)
class ParallelJaw(Gripper):
    """Two fingers that close on an object and hold it by friction.

    Attributes:
        joints: Joints that move the fingers, as named in the URDF.
        links: Links of the fingers: they may touch what is held.
        openings: (k,) increasing pad distances in [m]; the last one is fully open.
        joint_values: (k, len(joints)) joint values at those openings.
        force: Largest closing force it holds continuously in [N].
        pad_size: Pad extent along the tool's x and z axes in [m].
        friction: Friction coefficient of the pads against common goods.
        speed: Closing speed in [m/s], both pads together.
        give: Mean lever of the friction about a pad's normal in [m]: rubber of 3 MPa that 40 N press on a
            side of 30 mm radius gives way for 6.7 mm around (Hertz), and 3 pi / 16 of that is the lever.
        arc: (k,) how far along the tool's z the pads are at those openings in [m]: a linkage swings them
            forward as they close. None where they slide straight.
    """

    joints: tuple[str, ...]
    links: tuple[str, ...]
    openings: FloatArray
    joint_values: FloatArray
    force: float
    pad_size: tuple[float, float]
    friction: float
    speed: float = 0.1
    give: float = 0.004
    arc: FloatArray | None = None

    tool: ClassVar[str] = FINGERS
    share: ClassVar[float] = TRIAL_SHARE[0]
    """Of its opening, what the largest cube takes that it surely holds."""

    @property
    def touching(self) -> tuple[str, ...]:
        """Links that touch what is held."""
        return self.links

    @property
    def jaw(self) -> "ParallelJaw":
        """Itself."""
        return self

    @property
    def max_opening(self) -> float:
        """Largest distance between the pads in [m]."""
        return float(self.openings[-1])

    @property
    def limits(self) -> ToolState:
        """Fully open."""
        return ToolState(self.max_opening)

    @property
    def widest(self) -> float:
        """Side [m] of the largest cube that it surely takes."""
        return self.share * self.max_opening

    @property
    def grip(self) -> float:
        """Force with which it holds [N]."""
        return PRESS * self.force

    def ahead(self, opening: float) -> float:
        """How far along the tool's z the pads are at a distance of theirs, both in [m]."""
        return 0.0 if self.arc is None else float(np.interp(opening, self.openings, self.arc))

    def pads(self, width: float) -> FloatArray:
        """Middle of the pads (4, 4) in the tool frame at a distance of theirs [m]."""
        pose = np.eye(4)
        pose[2, 3] = self.ahead(width)
        return pose

    def closing_region(self, opening: float) -> FloatArray:
        """Extents (3,) in the tool frame of what is between its pads at a distance of theirs [m]."""
        return np.array([self.pad_size[0], opening, self.pad_size[1]])

    def lever(self, joint: str) -> float:
        """Way of one pad for the way of a joint, over the stroke: 1 for a slide, in [m/rad] for a hinge."""
        column = self.joint_values[:, self.joints.index(joint)]
        return float((self.openings[-1] - self.openings[0]) / 2.0 / abs(column[-1] - column[0]))

    def values(self, state: ToolState) -> dict[str, float]:
        """Joint values at a pad distance; beyond the ends of the stroke it stays at the end."""
        columns = self.joint_values.T
        return {
            name: float(np.interp(state.opening, self.openings, column))
            for name, column in zip(self.joints, columns, strict=True)
        }

    def opening(self, values: Mapping[str, float]) -> float:
        """The pad distance in [m] at measured joint values: the mean of what each joint says."""
        found: list[float] = []
        for name, column in zip(self.joints, self.joint_values.T, strict=True):
            order = np.argsort(column)
            found.append(float(np.interp(values[name], column[order], self.openings[order])))
        return float(np.mean(found))

    def prisms(self, bodies: Bodies, clearance: float) -> tuple[tuple[Prism, ...], tuple[Prism, ...], float]:
        """Measure what the hand fills about its pads, as a search for grasps sees it.

        Args:
            bodies: The hand's bodies at an opening.
            clearance: What the fingers keep to the sides of what they come in beside [m].

        Returns:
            Prisms of the finger on the +y side, y from its pad's face, cut in slabs along z because it tapers
            towards the tip; those of all else; z of the tips [m].
        """
        # pads that swing are farthest from the palm as they are shut, and nearest to it as they are open
        shut = self.pads(0.0)[:3, 3]
        nearest = shut if self.arc is None else np.array([0.0, 0.0, float(self.arc.min())])
        parts = [(link, part - (shut if link in self.links else nearest)) for link, part in bodies(0.0)]
        sides = [[part for link, part in parts if link == wanted] for wanted in self.links]
        finger = max(sides, key=lambda some: float(np.vstack(some)[:, 1].mean()))
        tip = max(float(part[:, 2].max()) for part in finger)
        palm = [prism for link, part in parts if link not in self.links for prism in prisms(part, ())]
        return tuple(prism for part in finger for prism in prisms(part, FINGER_SLABS)), tuple(palm), tip

    def take(self, robot: "Driver", name: str) -> str | None:
        """Close on an object; a sentence where nothing is held."""
        opening = robot.close(self.grip)
        robot.wait(GRIPPED)
        if opening < CLOSED_ON_NOTHING or not robot.holding:
            on = "on nothing" if opening < CLOSED_ON_NOTHING else f"without holding {name}"
            return f"the fingers closed {on}."
        return None

    def data(self) -> dict[str, Any]:
        """Describe the tool for a plan."""
        jaw: dict[str, Any] = {
            "joints": list(self.joints), "links": list(self.links), "openings": self.openings.tolist(),
            "joint_values": self.joint_values.tolist(), "force": self.force, "pad_size": self.pad_size,
            "friction": self.friction,
        }  # fmt: skip
        return {"jaw": jaw if self.arc is None else {**jaw, "arc": self.arc.tolist()}}

    def facts(self) -> dict[str, Any]:
        """Describe the tool for `topple robot --json`."""
        return {
            "kind": "jaw",
            "hinged": False,
            "joints": list(self.joints),
            "opening": [float(self.openings[0]), self.max_opening],
            "pads": list(self.pad_size),
            "force": self.force,
        }

    def __str__(self) -> str:
        """In words."""
        low, high = 1e3 * self.openings[0], 1e3 * self.max_opening
        pads = " x ".join(f"{1e3 * value:.0f}" for value in self.pad_size)
        return f"a jaw that opens {low:.0f} to {high:.0f} mm, pads {pads} mm, {self.force:.0f} N"
