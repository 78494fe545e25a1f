"""RestingScene: bodies at rest on a table, some of which never move; and how layouts come to rest."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from topple.planner.simulate.lift import move_between
from topple.planner.simulate.lifts import set_friction
from topple.robots.poses import angle_between
from topple.robots.world.bodies import Body
from topple.robots.world.physical_world import Physics
from topple.robots.world.world import World
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import ToppleError

TABLE = (0.8, 0.8)  # [m]
PHYSICS = Physics(iterations=150)
"""What lies needs less than what a hand holds: a stack of eight blocks stands with 100."""

GAP = 2e-4  # [m] left between bodies as they are laid out; they settle onto each other
STAYED, STAYED_DEGREES = 0.02, 20.0  # [m] and [deg] that what was put somewhere may settle by
CREEP = 0.001  # [m] what moves more in `WATCHED` seconds is not at rest
WATCHED = 2.0  # [s]
ATTEMPTS = 40
FRICTION = (0.5, 0.6)  # between objects, and with what is fixed
BELOW = -0.05  # [m] what is lower fell off the table


@dataclass(frozen=True, eq=False)
class RestingScene:
    """A scene at rest.

    Attributes:
        bodies: The objects.
        poses: name -> (4, 4) pose_body_to_world.
        fixed: Those that never move, the table aside.
    """

    bodies: tuple[Body, ...]
    poses: dict[str, FloatArray]
    fixed: frozenset[str] = frozenset()

    def world(self, table: tuple[float, float] = TABLE) -> World:
        """The scene on a table of some extents [m], in a world of its own that the caller closes."""
        world = World(PHYSICS)
        world.add_table(size=table)
        for body in self.bodies:
            world.add(body, self.poses[body.name], fixed=body.name in self.fixed)
        set_friction(world, *FRICTION)
        return world


@dataclass
class Layout:
    """A layout in the making.

    Attributes:
        world: Where things are put.
        rng: What draws them.
        stay: Names of what has to end where it was put: the scene is about them.
    """

    world: World
    rng: np.random.Generator
    stay: list[str] = field(default_factory=list[str])

    def put(self, body: Body, place: ArrayLike, turn: Rotation | None = None, *, fixed: bool = False) -> None:
        """Put a body where it belongs, its frame's origin at (3,) a place [m]."""
        pose = np.eye(4)
        pose[:3, 3] = place
        if turn is not None:
            pose[:3, :3] = turn.as_matrix()
        self.world.add(body, pose, fixed=fixed)
        if not fixed:
            self.stay.append(body.name)
        set_friction(self.world, *FRICTION)

    def drop(self, body: Body, middle: ArrayLike, spread: float, tip: float = 0.4) -> None:
        """Let a body go just above what lies there, turned anyhow, and wait."""
        rng = self.rng
        turn = Rotation.from_euler("z", rng.uniform(0, 2 * np.pi))
        if rng.random() < 0.5:
            axis = rng.uniform(0, 2 * np.pi)
            turn = Rotation.from_rotvec(rng.normal(0, tip) * np.array([np.cos(axis), np.sin(axis), 0])) * turn
        place = np.asarray(middle) + rng.normal(0, spread, 2)
        tops = [
            float((part @ pose[:3, :3].T + pose[:3, 3])[:, 2].max())
            for name, pose in self.world.poses().items()
            if name != "table" and np.linalg.norm(pose[:2, 3] - place) < 0.2
            for part in self.world.body(name).parts
        ]
        lowest = float(turn.apply(np.concatenate(body.parts))[:, 2].min())
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = turn.as_matrix(), [*place, max(tops, default=0.0) + 0.005 - lowest]
        self.world.add(body, pose)
        set_friction(self.world, *FRICTION)
        self.world.settle(2.5)

    def number(self, low: float, high: float) -> float:
        """A number drawn evenly."""
        return float(self.rng.uniform(low, high))


Lay = Callable[[Layout], None]


def of_a_kind(kinds: Mapping[str, Lay], seed: int, salt: int) -> tuple[str, RestingScene]:
    """A scene of the kind that a seed draws, each as likely as the others.

    Args:
        kinds: What lays out each kind, by name.
        seed: Any number.
        salt: Of the generator: two of them draw unlike scenes from one seed.

    Returns:
        The name of its kind, and the scene.

    Raises:
        ToppleError: None of its layouts stands.
    """
    kind = list(kinds)[int(np.random.default_rng([seed, salt]).integers(len(kinds)))]
    return kind, come_to_rest(kinds[kind], [seed, salt + 1])


def come_to_rest(lay: Lay, seeds: Sequence[int]) -> RestingScene:
    """Lay out and let come to rest.

    Args:
        lay: Puts bodies into a layout.
        seeds: Of what it draws; each attempt draws anew.

    Returns:
        The scene at rest; what rolled off the table is left out.

    Raises:
        ToppleError: Nothing that was laid out stands.
    """
    for attempt in range(ATTEMPTS):
        with World(PHYSICS) as world:
            world.add_table(size=TABLE)
            layout = Layout(world, np.random.default_rng([*seeds, attempt]))
            lay(layout)
            before = world.poses()
            set_friction(world, *FRICTION)
            world.settle(4.0)
            rest = world.poses()
            world.step(round(WATCHED / world.time_step))
            after = {name: world.pose(name) for name in world.names if name != "table"}
            held = not any(_moved(world, name, before[name], rest[name]) for name in layout.stay)
            names = [name for name, pose in after.items() if pose[2, 3] > BELOW]
            fixed = frozenset(world.fixed) & frozenset(names)
            movable = [name for name in names if name not in fixed]
            creep = max((_crept(rest[name], after[name]) for name in movable), default=0.0)
            if held and creep <= CREEP and len(movable) >= 2:
                return RestingScene(
                    tuple(map(world.body, names)), {name: after[name] for name in names}, fixed
                )
    raise ToppleError(f"nothing of seed {list(seeds)} stands in {ATTEMPTS} attempts")


def _moved(world: World, name: str, before: FloatArray, after: FloatArray) -> bool:
    """Whether a body did not stay where it was put: it may settle by a little."""
    return move_between(world, name, before, after).beyond(STAYED, STAYED_DEGREES)


def _crept(a: FloatArray, b: FloatArray) -> float:
    """[m] on a lever of a decimetre."""
    return float(np.linalg.norm((b - a)[:3, 3])) + 0.1 * angle_between(a, b)
