"""A step towards a goal, where the arm stands before it, and who says in which order to take things."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from topple.planner.beliefs import Beliefs
from topple.planner.dependency import Dependency
from topple.planner.order import Order
from topple.planner.pick_place.transfer import Transfer
from topple.robots.arm import Arm
from topple.topology.arrays import FloatArray
from topple.topology.relate import Relations
from topple.topology.scene import Scene
from topple.topology.statics import Statics

FREE, REMOVE, PLACE = "free", "remove", "place"
"""free: take a target clear, put it down; remove: take away what is in the way; place: as the goal says."""


@dataclass(frozen=True, eq=False)
class NextStep:
    """A step that can be done now.

    Attributes:
        transfer: What the arm does.
        action: One of free, remove, place.
        reason: Why this object and why now.
        order: The order the step was chosen from.
        against: Doubtful dependencies that the step goes against.
    """

    transfer: Transfer
    action: str
    reason: str
    order: Order
    against: tuple[Dependency, ...] = ()


@dataclass(frozen=True, eq=False)
class Station:
    """The arm as it stands before a step.

    Attributes:
        arm: The arm.
        pose_base_to_world: (4, 4) where it stands.
        q: (n,) its joint values [rad].
    """

    arm: Arm
    pose_base_to_world: FloatArray
    q: FloatArray


class Orderer(Protocol):
    """Whoever says in which order to free targets: `topple.planner.order.order`, or a rule of thumb."""

    def __call__(
        self,
        scene: Scene,
        targets: Sequence[str],
        *,
        relations: Relations,
        seed: int,
        statics: Statics | None = None,
        beliefs: Beliefs | None = None,
    ) -> Order:
        """The order, as `topple.planner.order.order` gives it."""
        ...
