"""Piles of others: 30 boxes let go at once in three layers, of which one is to be freed.

As N47IN/ClutterNav (no licence file: its numbers, none of its code) makes its random piles at commit adf2214:
ten boxes a layer, each edge 5 to 10 cm, upright, 1 kg, anywhere within 15 cm of the middle along x and y,
bottoms 12.5, 22.5 and 32.5 cm over a table, so that some begin in one another; 50 steps of a 240th of a
second after each layer. Friction of a box is 0.5, of the table 1, and the engine multiplies them. The target
is any of the boxes. They rest until nothing moves within four seconds, or a minute is over: what slides by
itself would count against every removal.

Three orders are made of the whole surfaces of the pile at rest and carried out by ideal lifts, straight up
and rigid, each from the same start: topple's, the highest top first until the target's turn has come, and
the target at once. Counted are removals, and what a removal moves or turns by more than the limits of
`topple demo`, at each removal anew. Unlike their lift, which lets a box vanish, this one drags along what
lies on it.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from topple.benchmarks.guesses import top_height
from topple.benchmarks.piles import Pile, observe
from topple.benchmarks.row import Progress, Row
from topple.benchmarks.scores import share
from topple.planner.planning.order import order
from topple.planner.simulate.lift import lift, move_between
from topple.planner.simulate.lifts import set_friction
from topple.robots.shapes import box
from topple.robots.world.world import World
from topple.topology.base.arrays import FloatArray, IntArray

SCENES, QUICK = 40, 4
LAYERS, EACH, EDGES, APART, LOWEST, RISE = 3, 10, (0.05, 0.10), 0.15, 0.125, 0.10  # as above, in [m]
STEPS = 50  # after each layer
WAIT, WAITS, STILL = 960, 15, 0.1  # steps, how often, and the share of the limits that counts as moving
FRICTIONS = 0.25, 0.5  # of two boxes, and of a box and the table
HEIGHT, ONCE = "height first", "the target at once"


def rows(quick: bool, seed: int, progress: Progress) -> list[dict[str, Any]]:
    """Measure.

    Args:
        quick: Four piles.
        seed: Of the first pile, in thousands.
        progress: Called before each pile.
    """
    removed, moved, wrong = np.zeros(3, dtype=int), np.zeros(3, dtype=int), list[str]()
    piles = range(1000 * seed, 1000 * seed + (QUICK if quick else SCENES))
    for number in piles:
        progress(f"pile {number}")
        taken, touched = _counts(number)
        removed, moved = removed + taken, moved + touched
        if touched[0] > touched.min() or taken[0] > taken[1]:
            wrong.append(f"pile {number}: removals {taken}, moved {touched}")
    what = f"piles in which topple moves no more than {HEIGHT} or {ONCE}, and removes no more than the former"
    found = [share(what, len(piles) - len(wrong), len(piles), "100", counted=True, wrong=wrong)]
    for what, (ours, *theirs) in (("removals", removed), ("moved that were to stay", moved)):
        found += [
            Row(f"{what}, {len(piles)} piles", int(ours), "", name, int(value))
            for name, value in zip((HEIGHT, ONCE), theirs, strict=True)
        ]
    return [row.to_json() for row in found]


def make_pile(seed: int) -> tuple[Pile, str]:
    """Let the boxes go, and draw what is to be freed.

    Args:
        seed: Of sizes, places and the target.

    Returns:
        The pile at rest, without what fell off the table, and the target's name.
    """
    rng = np.random.default_rng(seed)
    with World() as world:
        world.add_table(size=(0.8, 0.8))
        for layer in range(LAYERS):
            for k in range(EACH):
                pose = np.eye(4)
                pose[:3, 3] = *rng.uniform(-APART, APART, 2), LOWEST + RISE * layer
                size = tuple(rng.uniform(*EDGES, 3).tolist())
                world.add(box(f"box_{EACH * layer + k}", size, mass=1.0), pose)
            set_friction(world, *FRICTIONS)
            world.step(STEPS)
        pile = Pile.of(world)
    for _ in range(WAITS):
        with pile.world() as world:
            set_friction(world, *FRICTIONS)
            before = world.poses()
            world.step(WAIT)
            pile = Pile.of(world)
            if all(share < STILL for share in _shares(world, before)):
                break
    return pile, str(rng.choice([body.name for body in pile.bodies]))


def _counts(seed: int) -> tuple[IntArray, IntArray]:
    """Removals, and how many others these move: of topple's order, height first, and the target at once."""
    pile, target = make_pile(seed)
    scene = observe(pile, 0, seed)
    highest = top_height(scene).order
    orders = order(scene, [target]).order, highest[: highest.index(target) + 1], (target,)
    moved: list[int] = []
    for names in orders:
        with pile.world() as world:
            set_friction(world, *FRICTIONS)
            moved.append(sum(_take(world, name) for name in names))
    return np.array([len(names) for names in orders]), np.array(moved)


def _take(world: World, name: str) -> int:
    """Lift and take away; how many others that moves."""
    before = world.poses()
    lift(world, name)
    world.remove(name)
    world.settle()
    return sum(share > 1.0 for share in _shares(world, before))


def _shares(world: World, before: Mapping[str, FloatArray]) -> list[float]:
    """How far each has moved or turned, in shares of the limits."""
    return [move_between(world, name, before[name], pose).share for name, pose in world.poses().items()]
