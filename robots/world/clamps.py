"""A fixture: what keeps bodies of a world where they are, as a vice does, until it lets go of them."""

from collections.abc import Collection

from topple.robots.world.physical_world import PhysicalWorld
from topple.topology.base.errors import UnknownObject


class Clamps:
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
        self._let_go = {name: world.clamp(name) for name in sorted(names)}

    @property
    def clamped(self) -> frozenset[str]:
        """Names of the objects they keep."""
        return frozenset(self._let_go)

    def release(self, name: str) -> None:
        """Let go of a body; of one that they do not keep, nothing happens."""
        if name in self._let_go:
            self._let_go.pop(name)()
