"""A fixture: what keeps bodies of a world where they are, as a vice does, until it lets go of them."""

from abc import ABC, abstractmethod
from collections.abc import Collection
from typing import Generic, TypeVar

from topple.robots.world.physical_world import PhysicalWorld
from topple.topology.base.errors import UnknownObject

Grip = TypeVar("Grip")
"""What an engine needs to let go of a body again."""


class Clamps(ABC, Generic[Grip]):
    """Clamps on some bodies of a world; a `topple.robots.driver.Fixture`.

    Args:
        world: The world.
        names: The bodies, as they are now.

    Raises:
        UnknownObject: There is no such body that can move.
    """

    def __init__(self, world: PhysicalWorld, names: Collection[str]) -> None:
        for name in sorted(names):
            if name not in world.movable:
                raise UnknownObject(name, world.movable)
        self._grips = {name: self._clamp(name) for name in sorted(names)}

    @property
    def clamped(self) -> frozenset[str]:
        """What they keep."""
        return frozenset(self._grips)

    def release(self, name: str) -> None:
        """Let go of a body; of one that they do not keep, nothing happens."""
        if name in self._grips:
            self._let_go(name, self._grips.pop(name))

    @abstractmethod
    def _clamp(self, name: str) -> Grip:
        """Keep a body where it is."""

    @abstractmethod
    def _let_go(self, name: str, grip: Grip) -> None:
        """Keep it no longer."""
