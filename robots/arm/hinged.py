"""A hinged jaw: one finger turns against a fixed one, as on small teaching arms."""

from dataclasses import dataclass

import numpy as np

from topple.robots.arm.gripper import ParallelJaw
from topple.robots.arm.tolerances import BESIDE
from topple.topology.base.arrays import FloatArray


@dataclass(frozen=True, eq=False)
class HingedJaw(ParallelJaw):
    """A finger that turns against one that is fixed to the palm.

    The fixed finger is stood beside the object, and the other one closes the rest. The tool frame lies on the
    fixed finger's face, in the middle of where both hold, y towards the other finger. `openings` are the
    distances of the moving finger from that face, where it comes nearest to it, and `joint_values` the angles
    they are reached at [rad].
    """

    def pads(self, opening: float) -> FloatArray:
        """Middle of the pads (4, 4) in the tool frame, the fixed one a little beside what is between them."""
        pose = np.eye(4)
        pose[1, 3] = opening / 2.0 + BESIDE
        return pose
