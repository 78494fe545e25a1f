"""A hinged jaw: one finger turns against a fixed one, as on small teaching arms."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from topple.robots.arm.jaw import Bodies, ParallelJaw
from topple.robots.arm.tolerances import BESIDE, FINGER_SLABS, HINGED_OPENINGS, OVER_FACE, SWUNG, TRIAL_SHARE
from topple.robots.collision.convex import section
from topple.robots.collision.prisms import Prism, prisms
from topple.topology.base.arrays import FloatArray


@dataclass(frozen=True, eq=False)
class HingedJaw(ParallelJaw):
    """A finger that turns against one that is fixed to the palm.

    The fixed finger is stood beside the object, and the other one closes the rest. The tool frame lies on the
    fixed finger's face, in the middle of where both hold, y towards the other finger. `openings` are the
    distances of the moving finger from that face, where it comes nearest to it, and `joint_values` the angles
    they are reached at [rad].
    """

    share: ClassVar[float] = TRIAL_SHARE[1]

    def pads(self, width: float) -> FloatArray:
        """Middle of the pads (4, 4) in the tool frame, the fixed one a little beside what is between them."""
        pose = np.eye(4)
        pose[1, 3] = width / 2.0 + BESIDE
        return pose

    def prisms(self, bodies: Bodies, clearance: float) -> tuple[tuple[Prism, ...], tuple[Prism, ...], float]:
        """Measure what the hand fills about the middle of its pads at any opening; see `ParallelJaw.prisms`.

        The search knows fingers that mirror each other. The fixed finger and the turned one are each taken
        for both, at several openings: more room is asked for than such a hand needs.
        """
        moving, fixed = self.links
        finger, palm = list[Prism](), list[Prism]()
        for link, part in bodies(self.max_opening):
            for prism in [] if link == moving else prisms(part, FINGER_SLABS):
                low, high = prism.y
                if link == fixed and high <= OVER_FACE:
                    finger.append(Prism(prism.x, (max(-high, 0.0), -low), prism.front))
                else:
                    palm.append(Prism(prism.x, (low - self.max_opening / 2.0 - BESIDE, high), prism.front))
        # the hand is that much off the middle on the way in
        return (*finger, *self._swung(bodies, clearance - BESIDE)), tuple(palm), self.pad_size[1] / 2.0

    def _swung(self, bodies: Bodies, aside: float) -> list[Prism]:
        """Prisms of all that the moving finger ever fills, y from its face where that is nearest."""
        swung = list[FloatArray]()
        for opening in np.linspace(self.openings[0], self.max_opening, HINGED_OPENINGS).tolist():
            swung += [part - [0.0, opening, 0.0] for link, part in bodies(opening) if link == self.links[0]]
        tip = max(float(part[:, 2].max()) for part in swung)
        found = list[Prism]()
        for front in np.arange(tip, tip - SWUNG[0], -SWUNG[1]).tolist():
            cuts = [section(part, z) for part in swung for z in (front - 1e-6, front - SWUNG[1])]
            cuts += [part[(part[:, 2] <= front) & (part[:, 2] >= front - SWUNG[1])] for part in swung]
            points = np.concatenate(cuts)
            (x0, y0), (x1, y1) = points[:, :2].min(axis=0).tolist(), points[:, :2].max(axis=0).tolist()
            found.append(Prism((x0, x1), (y0, y1 + aside), front))
        return found

    def data(self) -> dict[str, Any]:
        """Describe the tool for a plan."""
        return {"jaw": {**super().data()["jaw"], "beside": BESIDE}}

    def facts(self) -> dict[str, Any]:
        """Describe the tool for `topple robot --json`."""
        return {**super().facts(), "hinged": True}

    def __str__(self) -> str:
        """In words."""
        return super().__str__().replace("a jaw", "a hinged jaw")
