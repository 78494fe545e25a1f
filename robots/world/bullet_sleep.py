"""What rests in a world on PyBullet sleeps while an arm passes by, and wakes as it is touched."""

from collections.abc import Collection, Iterable
from typing import Any

from topple.robots.engine import pybullet
from topple.robots.world.physical_world import PhysicalWorld
from topple.robots.world.tolerances import ASLEEP_AFTER, ASLEEP_EACH


class Sleep:
    """Which bodies of a world sleep: resting contacts are nine tenths of what its steps cost.

    Bullet's own rule would put to sleep what moves at less than 0.8 m/s. What sleeps stays where it is, with
    its contacts; awake again it goes on as if no time had passed.

    Args:
        world: The world.
        client: PyBullet's number of its simulation.
    """

    def __init__(self, world: PhysicalWorld, client: int) -> None:
        self._world, self._client = world, client
        self._asleep: set[int] = set()
        self._handled: frozenset[int] = frozenset()
        self._steps = 0

    def after_step(self, handled: Collection[int]) -> None:
        """Wake everything where something that sleeps is touched; else let sleep what has rested for long.

        Args:
            handled: PyBullet's numbers of the bodies that robots touch or hold.
        """
        if not self._apart(handled):
            self.wake()
            return
        same = self._handled == handled
        self._steps, self._handled = self._steps + 1 if same else 0, frozenset(handled)
        if self._steps % ASLEEP_EACH:
            return
        ids = self._world.ids
        others = [name for name in self._world.movable if ids[name] not in self._asleep.union(handled)]
        if not self._world.at_rest(others):
            self._steps = 0
        elif self._steps * self._world.time_step >= ASLEEP_AFTER:
            resting = {ids[name] for name in others}
            self._asleep |= resting
            self._set(resting, pybullet.ACTIVATION_STATE_SLEEP)

    def wake(self) -> None:
        """Wake everything."""
        self._set(self._asleep, pybullet.ACTIVATION_STATE_DISABLE_SLEEPING)
        self._asleep, self._steps = set(), 0

    def _apart(self, handled: Collection[int]) -> bool:
        """Whether what is handled, or fell from the hand, touches nothing that could be moved."""
        movable = {self._world.ids[name] for name in self._world.movable}
        awake = movable.difference(self._asleep) if self._asleep else movable.intersection(handled)
        if not awake.issuperset(movable.intersection(handled)):
            return False
        for number in awake:
            points: Any = pybullet.getContactPoints(bodyA=number, physicsClientId=self._client)
            if any(point[2] in movable and point[2] not in awake for point in points):
                return False
        return True

    def _set(self, numbers: Iterable[int], state: int) -> None:
        for number in numbers:
            pybullet.changeDynamics(number, -1, activationState=state, physicsClientId=self._client)
