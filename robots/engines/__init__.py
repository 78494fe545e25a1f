"""The physics engines that a world can be played on, by name."""

from collections.abc import Collection, Generator
from contextlib import contextmanager
from contextvars import ContextVar
from importlib.util import find_spec
from typing import TYPE_CHECKING

from topple.topology.base.errors import InvalidInput

if TYPE_CHECKING:
    from topple.robots.arm.arm import Arm
    from topple.robots.driver import Fixture
    from topple.robots.world.acting_arm import ActingArm
    from topple.robots.world.physical_world import PhysicalWorld
    from topple.topology.base.arrays import FloatArray

__all__ = [
    "BULLET", "DEFAULT_ENGINE", "ENGINES", "INSTALLED", "MUJOCO",
    "arm_in", "fixture_in", "new_world", "playing_on", "rehearsal_world",
]  # fmt: skip

BULLET, MUJOCO = ENGINES = ("bullet", "mujoco")

_MODULES = {BULLET: "pybullet", MUJOCO: "mujoco"}

INSTALLED = tuple(engine for engine in ENGINES if find_spec(_MODULES[engine]) is not None)
"""Those that can play here; none of them is needed to relate, to order or to rank."""

DEFAULT_ENGINE = INSTALLED[0] if INSTALLED else BULLET
"""What plays where nothing is said: PyBullet; MuJoCo where it alone is installed."""

_CHOSEN: ContextVar[str] = ContextVar("engine", default=DEFAULT_ENGINE)


@contextmanager
def playing_on(engine: str) -> Generator[None]:
    """Make worlds on an engine, within the block.

    Args:
        engine: One of `ENGINES`.

    Raises:
        InvalidInput: There is no such engine.
    """
    if engine not in ENGINES:
        raise InvalidInput(f"no engine {engine!r}: expected {' or '.join(ENGINES)}")
    token = _CHOSEN.set(engine)
    try:
        yield
    finally:
        _CHOSEN.reset(token)


def new_world() -> "PhysicalWorld":
    """An empty world on the engine of `playing_on`; on `DEFAULT_ENGINE` without one.

    Raises:
        NotInstalled: The engine is not installed.

    Examples:
        >>> with new_world() as world:
        ...     world.names
        ()
    """
    return _world_of(_CHOSEN.get())


def rehearsal_world() -> "PhysicalWorld":
    """An empty world in which a plan tries something beforehand.

    It is one of `DEFAULT_ENGINE`, whatever plays the world that is planned for: both play the same plan.

    Raises:
        NotInstalled: The engine is not installed.
    """
    return _world_of(DEFAULT_ENGINE)


def _world_of(engine: str) -> "PhysicalWorld":
    if engine == MUJOCO:
        from topple.robots.mujoco.world import MujocoWorld

        return MujocoWorld()
    from topple.robots.world.world import World

    return World()


def arm_in(
    world: "PhysicalWorld",
    arm: "Arm",
    pose_base_to_world: "FloatArray",
    beside: "ActingArm | None" = None,
    q: "FloatArray | None" = None,
) -> "ActingArm":
    """Put an arm into a world and return what drives it.

    Args:
        world: A world of `new_world`.
        arm: The arm.
        pose_base_to_world: (4, 4) where it stands.
        beside: Another arm that is in the world already.
        q: (n,) joint values it has there; the arm's home, if not given.

    Raises:
        InvalidInput: It is no such world, or its engine does not simulate two arms.

    Examples:
        >>> with new_world() as world:
        ...     arm_in(world, robot("panda"), np.eye(4)).holding
        False
    """
    if getattr(world, "engine", None) == MUJOCO:
        from topple.robots.mujoco.acting import MujocoArm
        from topple.robots.mujoco.world import MujocoWorld

        if beside is not None:
            raise InvalidInput(f"two arms act in a world on {BULLET} alone, found one on {MUJOCO}")
        assert isinstance(world, MujocoWorld)
        return MujocoArm(world, arm, pose_base_to_world, q)
    from topple.robots.world.simulated_arm import SimulatedArm
    from topple.robots.world.world import in_bullet

    other = beside if isinstance(beside, SimulatedArm) else None
    return SimulatedArm(in_bullet(world), arm, pose_base_to_world, q, beside=other)


def fixture_in(world: "PhysicalWorld", names: "Collection[str]") -> "Fixture | None":
    """Clamp bodies of a world where they are; None where none are named.

    Args:
        world: A world of `new_world`.
        names: Names of bodies.
    """
    from topple.robots.world.clamps import Clamps

    return Clamps(world, names) if names else None
