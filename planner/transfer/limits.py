"""How hard a transfer is looked for, and how fast it moves."""

from dataclasses import dataclass, replace

from topple.planner.grasp.tolerances import GRASP_TOLERANCES
from topple.planner.transfer.tolerances import ALL_GRASPS
from topple.robots.arm.arm import Arm
from topple.robots.arm.home import scale_of
from topple.robots.arm.tolerances import FULL_DOF


@dataclass(frozen=True)
class TransferLimits:
    """How hard to look, and how fast to move.

    Attributes:
        enough: Pinches that brush by nothing after which no more are looked for, while an arm can make one.
        grasps: Best grasps to ask inverse kinematics for; each is tried with the hand turned half as well.
        reached: Reachable grasp states to follow up.
        goals: Placements a motion is planned to at once.
        approach: Straight way in before the grasp [m].
        lift: Straight way out after it [m].
        drop: Straight way down before the release [m].
        fall: How far more a thing may fall where no hand gets down with it [m]: crockery stands it.
        retreat: Straight way out after it [m].
        straight_speed: Of the tool on straight ways [m/s]: lifts at it are known to disturb little.
        speed: Share of the joints' velocity limits for the other motions.
        rounds: Batches of branches before the search for one free motion gives up.
        tilt: Largest tilt of what is carried upright [rad]: a glass filled to nine tenths does not spill.
    """

    enough: float = 24
    grasps: int = 24
    reached: int = 12
    goals: int = 4
    approach: float = GRASP_TOLERANCES.way
    lift: float = 0.10
    drop: float = 0.06
    fall: float = 0.02
    retreat: float = 0.08
    straight_speed: float = 0.08
    speed: float = 0.5
    rounds: int = 500
    tilt: float = 0.15

    def of(self, arm: Arm) -> "TransferLimits":
        """Those of an arm: straight ways as short as a short one has, all grasps for one of few joints."""
        scale = scale_of(arm)
        grasps = ALL_GRASPS if len(arm.joints) < FULL_DOF else 0
        return replace(
            self,
            approach=scale * self.approach,
            lift=scale * self.lift,
            drop=scale * self.drop,
            retreat=scale * self.retreat,
            enough=max(self.enough, grasps),
            grasps=max(self.grasps, grasps),
        )


TRANSFER_LIMITS = TransferLimits()
