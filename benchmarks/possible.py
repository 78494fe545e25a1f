"""What perfect knowledge would allow: does any order of ideal lifts free a target and disturb nothing?

A pile in which things hold each other may have none. No order, ours or another, frees its target then by
lifting one thing after the other straight up; what a bench finds is to be read beside that.
"""

import numpy as np

from topple.planner.execution.judge import LIMITS
from topple.planner.simulate.lifts import take_away
from topple.robots.world.world import World

TRIES = 300
"""Lifts after which the search gives up: of six things there are at most 192 to try."""

PARKED = 3.0
"""[m] from the middle of the table, where what was taken lies on the floor."""


def freeing_order(world: World, target: str) -> tuple[str, ...] | None:
    """An order of lifts, straight up and rigid, none of which moves anything else.

    Args:
        world: A world at rest, its true bodies and poses; left as it was.
        target: What is to be freed.

    Returns:
        Names, the target last; None where no such order was found.
    """
    return _Search(world, target).beyond(())


class _Search:
    """Depth first, each set of taken things once."""

    def __init__(self, world: World, target: str) -> None:
        self.world, self.target = world, target
        self.seen: set[frozenset[str]] = set()
        self.lifts = 0

    def beyond(self, taken: tuple[str, ...]) -> tuple[str, ...] | None:
        """The order that goes on from what was taken."""
        if frozenset(taken) in self.seen:
            return None
        self.seen.add(frozenset(taken))
        left = [name for name in self.world.movable if name not in taken]
        left.sort(key=lambda name: (name != self.target, -self.world.pose(name)[2, 3]))
        for name in left:
            self.lifts += 1
            if self.lifts > TRIES:
                return None
            moves = take_away(self.world, name)
            rest = [moves[other] for other in left if other != name]
            if any(move.beyond(LIMITS.distance, np.degrees(LIMITS.angle)) for move in rest):
                continue
            if name == self.target:
                return (*taken, name)
            kept = self.world.snapshot()
            self._park(name, len(taken))
            found = self.beyond((*taken, name))
            self.world.restore(kept)
            if found is not None:
                return found
        return None

    def _park(self, name: str, place: int) -> None:
        pose = np.eye(4)
        pose[:3, 3] = PARKED + 0.5 * place, PARKED, 0.2
        self.world.place(name, pose)
        self.world.settle()
