"""Seeded arrangements that stand: piles, towers, bridges, arches, card houses, balances, nested dishes."""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from topple.benchmarks.piles import Pile, make_pile
from topple.planner.simulate.lifts import set_friction
from topple.robots import shapes
from topple.robots.poses import angle_between
from topple.robots.scenarios.scenario import pose_at
from topple.robots.world.bodies import Body
from topple.robots.world.world import World
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import ToppleError

GAP = 2e-4
"""Gap [m] left between bodies as they are laid out; they settle onto each other."""

CREEP = 0.001
"""What moves more [m] in `WATCHED` seconds does not stand."""

WATCHED = 3.0
ATTEMPTS = 60

Layout = Callable[[World, np.random.Generator], None]


def arrangement(seed: int) -> tuple[str, Pile]:
    """An arrangement of the kind that its seed draws, at rest.

    Args:
        seed: Any number.

    Returns:
        The name of its kind, and the bodies where they stand.

    Raises:
        ToppleError: None of its layouts stands.
    """
    rng = np.random.default_rng([seed, 22])
    kinds = list(KINDS)
    kind = kinds[int(rng.integers(len(kinds)))]
    if (layout := KINDS[kind]) is None:
        return kind, make_pile(seed)
    for _ in range(ATTEMPTS):
        with World() as world:
            world.add_table(size=(0.8, 0.8))
            layout(world, rng)
            set_friction(world, 0.5, 0.6)
            laid = world.poses()
            world.settle(3.0)
            before = world.poses()
            world.step(round(WATCHED / world.time_step))
            after = world.poses()
            fell = max(_moved(laid[name], after[name]) for name in laid) > 10 * CREEP
            if not fell and max(_moved(before[name], after[name]) for name in laid) <= CREEP:
                return kind, Pile(tuple(map(world.body, world.movable)), after)
    raise ToppleError(f"no {kind} of seed {seed} stands in {ATTEMPTS} attempts")


def _moved(a: FloatArray, b: FloatArray) -> float:
    """[m] on a lever of a decimetre."""
    return float(np.linalg.norm((b - a)[:3, 3])) + 0.1 * angle_between(a, b)


def _at(place: ArrayLike, turn: Rotation | None = None) -> FloatArray:
    x, y, z = np.asarray(place, dtype=np.float64).tolist()
    return pose_at(x, y, z, turn)


def _yaw(angle: float) -> Rotation:
    return Rotation.from_euler("z", angle)


def _tower(world: World, rng: np.random.Generator) -> None:
    """Boxes and cans on each other, each aside by up to what just carries it."""
    top, middle = 0.0, rng.uniform(-0.05, 0.05, 2)
    half = 0.06
    for k in range(int(rng.integers(3, 8))):
        size = rng.uniform([0.05, 0.05, 0.03], [0.12, 0.12, 0.08])
        middle = middle + (rng.uniform(-0.45, 0.45, 2) * half if k else 0.0)
        if rng.random() < 0.25:
            body = shapes.can(f"can_{k}", diameter=float(size[:2].min()), height=float(size[2]))
        else:
            body = shapes.box(f"box_{k}", tuple(size))
        world.add(body, _at([*middle, top], _yaw(rng.uniform(0, np.pi))))
        top, half = top + float(size[2]) + GAP, float(size[:2].min()) / 2


def _bridge(world: World, rng: np.random.Generator) -> None:
    """Piers of one height, planks across them, and loads on those."""
    height, width, top = rng.uniform(0.05, 0.09), rng.uniform(0.05, 0.08), 0.0
    span = rng.uniform(0.07, 0.1)
    for story in range(int(rng.integers(1, 3))):
        places = (-span, span) if rng.random() < 0.5 else (-span, 0.0, span)
        for k, x in enumerate(places):
            body = shapes.box(f"pier_{story}{k}", (0.04, width, height))
            world.add(body, pose_at(x + rng.uniform(-0.004, 0.004), rng.uniform(-0.004, 0.004), top))
        plank = shapes.box(f"plank_{story}", (2 * span + 0.05, width, 0.02))
        world.add(plank, pose_at(0, 0, top + height + GAP))
        top += height + 0.02 + 2 * GAP
    for k in range(int(rng.integers(0, 3))):
        load = shapes.box(f"load_{k}", (0.04, 0.04, rng.uniform(0.03, 0.06)))
        world.add(load, pose_at(rng.uniform(-0.6, 0.0) * span if k else 0.6 * span, 0, top))


def _arch(world: World, rng: np.random.Generator) -> None:
    """Wedges round half a circle, the keystone last, between two blocks that keep its feet together."""
    stones, inner = int(rng.choice([3, 5, 7])), rng.uniform(0.05, 0.08)
    outer, depth = inner * rng.uniform(1.45, 1.7), rng.uniform(0.05, 0.08)
    edges = np.linspace(0.0, np.pi, stones + 1)
    for k in range(stones):
        angles = edges[[k, k + 1]] + np.array([1e-3, -1e-3])
        ring = [(r * np.cos(a), r * np.sin(a)) for r in (inner, outer) for a in angles]
        corners = np.array([[x, y, z] for x, z in ring for y in (-depth / 2, depth / 2)])
        middle = corners.mean(axis=0)
        world.add(Body.of(f"stone_{k}", [corners - middle], kind="stone"), _at(middle))
    for k, side in enumerate((-1, 1)):
        weight = shapes.box(f"foot_{k}", (0.06, depth, rng.uniform(0.05, 0.08)))
        world.add(weight, pose_at(side * (outer + 0.03 + GAP), 0, 0))


def _cards(world: World, rng: np.random.Generator) -> None:
    """Boards leant against each other in pairs, some with a board across them."""
    thick, deep, high = rng.uniform(0.008, 0.014), rng.uniform(0.07, 0.1), rng.uniform(0.09, 0.12)
    tilt, count = rng.uniform(0.2, 0.4), int(rng.integers(1, 3))
    reach = high * np.sin(tilt) + thick * np.cos(tilt)
    for k in range(count):
        for side in (-1, 1):
            turn = Rotation.from_euler("y", -side * tilt)
            corner = np.array([side * thick / 2, 0, 0])  # the foot that stands
            foot = np.array([(2 * k - count + 1) * (reach + 0.02) + side * reach, 0, 1e-4])
            place = foot - turn.apply(corner)
            world.add(shapes.box(f"card_{k}{'lr'[side > 0]}", (thick, deep, high)), _at(place, turn))
    if rng.random() < 0.6:
        roof = high * np.cos(tilt) + thick * np.sin(tilt) + 1e-3
        size = (4 * reach + 0.06, deep, thick) if count == 2 else (0.1, deep, thick)
        world.add(shapes.box("roof", size), pose_at(0, 0, roof))


def _balance(world: World, rng: np.random.Generator) -> None:
    """A plank on a pier, past its edge, and what keeps it there."""
    pier = rng.uniform(0.05, 0.09), rng.uniform(0.06, 0.1), rng.uniform(0.05, 0.12)
    length, aside = rng.uniform(0.22, 0.32), rng.uniform(0.0, 0.05)
    world.add(shapes.box("pier", pier))
    world.add(shapes.box("plank", (length, 0.05, 0.02)), pose_at(aside, 0, pier[2] + GAP))
    top = pier[2] + 0.02 + 2 * GAP
    left, right = aside - length / 2 + 0.025, aside + length / 2 - 0.025
    world.add(shapes.box("weight", (0.05, 0.05, rng.uniform(0.04, 0.1))), pose_at(left, 0, top))
    if rng.random() < 0.6:
        load = (0.04, 0.04, rng.uniform(0.03, 0.08))
        world.add(shapes.box("load", load), pose_at(rng.uniform(0.3, 1.0) * right, 0, top))
    if rng.random() < 0.4:
        world.add(shapes.can("can", diameter=0.05, height=0.08), pose_at(0, 0.15, 0))


def _dishes(world: World, rng: np.random.Generator) -> None:
    """Plates on plates, a bowl in a bowl, and what lies in it."""
    top = 0.0
    for k in range(int(rng.integers(1, 4))):
        plate = shapes.plate(f"plate_{k}", diameter=float(rng.uniform(0.2, 0.22)))
        world.add(plate, _at([*rng.uniform(-0.002, 0.002, 2), top]))
        top += 0.008
    for k in range(int(rng.integers(0, 3))):
        bowl = shapes.bowl(f"bowl_{k}", diameter=0.15, height=0.06)
        world.add(bowl, pose_at(0, 0, top + 0.004 + 0.014 * k))
    if rng.random() < 0.7:
        world.add(shapes.ball("ball", diameter=0.045), pose_at(0.01, 0, top + 0.06))
    if rng.random() < 0.5:
        world.add(shapes.spoon("spoon", length=0.17), pose_at(0.0, 0.19, 0))
    if rng.random() < 0.5:
        world.add(shapes.mug("mug", diameter=0.08, height=0.09), pose_at(0.22, 0, 0))
    world.settle(2.0)


def _leaning(world: World, rng: np.random.Generator) -> None:
    """Books that lean on a box, one on the other."""
    world.add(shapes.box("box", (0.08, 0.12, 0.12)))
    thick, high, tilt = rng.uniform(0.02, 0.035), rng.uniform(0.11, 0.14), rng.uniform(0.15, 0.35)
    x = 0.04 + GAP
    for k in range(int(rng.integers(1, 4))):
        turn = Rotation.from_euler("y", -tilt)
        foot = np.array([x + min(high * np.sin(tilt), 0.12 * np.tan(tilt)), 0, 1e-4])
        world.add(shapes.box(f"book_{k}", (thick, 0.1, high)), _at(foot + np.array([thick / 2, 0, 0]), turn))
        x += thick / np.cos(tilt) + GAP
    if rng.random() < 0.5:
        world.add(shapes.can("can", diameter=0.06, height=0.09), pose_at(0, 0, 0.12 + GAP))


KINDS: dict[str, Layout | None] = {
    "pile": None,
    "tower": _tower,
    "bridge": _bridge,
    "arch": _arch,
    "cards": _cards,
    "balance": _balance,
    "dishes": _dishes,
    "leaning": _leaning,
}
"""Each as likely as the others; a pile is what `make_pile` drops."""
