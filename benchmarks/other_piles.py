"""Piles of a second generator, unlike those of `topple.robots.scenarios`, which topple was developed on.

Other kinds (scanned models of a folder, and shapes by formula: pebbles, tubes, brackets, wedges, bottles,
bolts, jacks), other masses (densities spread over a decade), and another way to lie: things fall from up to
8 cm over a disc, turned anyhow, instead of being let go just above the middle of the pile. The target is any
that carries something, not the one that carries most.
"""

import json
from collections.abc import Callable
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from topple.benchmarks.body_files import body_from_files
from topple.robots.scenarios.scenario import Scenario, Unlucky, contacts, drop, settle, settled
from topple.robots.shapes.vessel import circle, rings, sectors
from topple.robots.world.bodies import Body, Color
from topple.robots.world.physical_world import PhysicalWorld
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput

NAME = "other pile"
LONGEST = 0.26  # [m] of a model: longer ones reach out of the cameras' view
HEAVIEST = 1.2  # [kg] of a model: what hands hold beside its middle
SCANNED = 0.6  # share of things that are models where there are any
DISC = 0.12  # [m] radius of the disc that things fall on
HEIGHT = (0.01, 0.08)  # [m] they fall
AS_STORED = 0.3  # share that falls upright, the others are turned anyhow
DENSITIES = (150.0, 1500.0)  # [kg/m3] foam to hard plastic, evenly over the logarithm
COLORS: tuple[Color, ...] = (
    (0.25, 0.45, 0.40, 1.0), (0.75, 0.45, 0.20, 1.0), (0.45, 0.35, 0.60, 1.0), (0.70, 0.70, 0.35, 1.0),
    (0.35, 0.50, 0.75, 1.0), (0.65, 0.30, 0.35, 1.0), (0.50, 0.55, 0.50, 1.0), (0.80, 0.75, 0.65, 1.0),
)  # fmt: skip

Parts = list[FloatArray]


def other_pile(seed: int = 0, meshes: Path | None = None) -> Scenario:
    """Make a scene of five to nine things.

    Args:
        seed: Any number; the same one gives the same scene of the same models.
        meshes: Holds models, a folder each with `collision.obj`, at any depth; None: shapes by formula alone.

    Returns:
        The scenario: things named `KIND_N`; the target is one that carries something.

    Raises:
        InvalidInput: If the folder holds no model that an arm could take.
    """
    models = () if meshes is None else models_in(meshes)
    return settled(NAME, seed, lambda world, rng: _layout(world, rng, models))


@cache
def models_in(folder: Path) -> tuple[Path, ...]:
    """Folders of models that an arm could take, by name.

    Args:
        folder: Where they are, at any depth.

    Returns:
        Folders with a `collision.obj` whose body is neither too long nor, by its `meta.json`, too heavy.

    Raises:
        InvalidInput: There is none.
    """
    found = tuple(path.parent for path in sorted(folder.rglob("collision.obj")) if _is_fit(path.parent))
    if not found:
        raise InvalidInput(
            f"{folder} holds no model below {LONGEST:g} m and {HEAVIEST:g} kg: expected folders with "
            "collision.obj"
        )
    return found


def _is_fit(folder: Path) -> bool:
    meta = folder / "meta.json"
    mass = json.loads(meta.read_text(encoding="utf-8")).get("mass_kg") if meta.is_file() else None
    body = body_from_files(folder)
    return max((body.upper - body.lower).tolist()) <= LONGEST and (mass or 0.0) <= HEAVIEST


def _layout(
    world: PhysicalWorld, rng: np.random.Generator, models: tuple[Path, ...]
) -> tuple[str, tuple[str, ...]]:
    for number in range(int(rng.integers(5, 10))):
        body = _thing(number, rng, models).colored(COLORS[number % len(COLORS)])
        away, angle = DISC * np.sqrt(rng.random()), rng.uniform(0, 2 * np.pi)
        level = Rotation.from_euler("z", rng.uniform(0, 2 * np.pi))
        turn = level if rng.random() < AS_STORED else Rotation.from_quat(rng.normal(size=4))
        drop(world, body, away * np.cos(angle), away * np.sin(angle), turn, clearance=rng.uniform(*HEIGHT))
        settle(world, 3.0)
    settle(world)
    carrying = _carrying(world)
    if not carrying:
        raise Unlucky("nothing lies on anything")
    target = str(rng.choice(carrying))
    return f"free {target}", (target,)


def _thing(number: int, rng: np.random.Generator, models: tuple[Path, ...]) -> Body:
    if models and rng.random() < SCANNED:
        folder = models[int(rng.integers(len(models)))]
        plain = folder.name.lstrip("0123456789_") or folder.name
        return body_from_files(folder, f"{plain}_{number}")
    kind = str(rng.choice(list(SHAPES)))
    density = float(np.exp(rng.uniform(*np.log(DENSITIES))))
    return Body.of(f"{kind}_{number}", SHAPES[kind](rng), density=density, kind=kind)


def _carrying(world: PhysicalWorld) -> list[str]:
    """Objects that touch one whose centre of mass is higher."""
    height = {
        name: float((world.pose(name) @ np.append(world.body(name).centre_of_mass, 1.0))[2])
        for name in world.movable
    }
    pairs = [sorted(pair, key=lambda name: height[name]) for pair in contacts(world) if pair <= height.keys()]
    return sorted({lower for lower, _ in pairs})


def _block(size: tuple[float, float, float], at: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> FloatArray:
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    return corners * size + at


def _turned(profile: list[tuple[float, float]], sides: int = 20) -> Parts:
    """Slices of a body of revolution: radius and height [m], from below."""
    stack = rings(circle(sides), profile)
    return [np.concatenate([low, high]) for low, high in pairwise(stack)]


def _pebble(rng: np.random.Generator) -> Parts:
    """A superellipsoid, between a ball and a box."""
    half, power = rng.uniform([0.018, 0.018, 0.01], [0.045, 0.035, 0.03]), rng.uniform(0.35, 1.0)
    directions = rng.normal(size=(400, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return [half * np.sign(directions) * np.abs(directions) ** power]


def _tube(rng: np.random.Generator) -> Parts:
    outer, length, wall = rng.uniform(0.018, 0.035), rng.uniform(0.05, 0.16), rng.uniform(0.003, 0.006)
    profile = [(outer - wall, 0.0), (outer, 0.0), (outer, length), (outer - wall, length)]
    return sectors(rings(circle(16), profile), range(4))


def _bracket(rng: np.random.Generator) -> Parts:
    long, short, wide = rng.uniform([0.08, 0.05, 0.025], [0.16, 0.1, 0.05])
    thick = rng.uniform(0.008, 0.02)
    foot = _block((long, wide, thick), (0.0, 0.0, thick / 2))
    return [foot, _block((thick, wide, short), (-long / 2 + thick / 2, 0.0, thick + short / 2))]


def _wedge(rng: np.random.Generator) -> Parts:
    long, wide, high = rng.uniform([0.07, 0.03, 0.03], [0.14, 0.07, 0.06])
    return [np.array([[x, y, 0.0] for x in (0, long) for y in (0, wide)] + [[0, 0, high], [0, wide, high]])]


def _bottle(rng: np.random.Generator) -> Parts:
    radius, high = rng.uniform(0.02, 0.035), rng.uniform(0.1, 0.19)
    neck, shoulder = rng.uniform(0.3, 0.5) * radius, rng.uniform(0.5, 0.75) * high
    return _turned([(radius, 0.0), (radius, shoulder), (neck, 0.85 * high), (neck, high)])


def _bolt(rng: np.random.Generator) -> Parts:
    shaft, long = rng.uniform(0.008, 0.014), rng.uniform(0.06, 0.14)
    head = rings(circle(6), [(2 * shaft, 0.0), (2 * shaft, 1.4 * shaft)]).reshape(-1, 3)
    return [head, *_turned([(shaft, 1.4 * shaft), (shaft, long)], 12)]


def _jack(rng: np.random.Generator) -> Parts:
    """Three bars across each other, of which some end in the air however it lies."""
    long, thick = rng.uniform(0.06, 0.12), rng.uniform(0.012, 0.02)
    half = (long - thick) / 4
    arms = [_block((long, thick, thick))]
    for axis in (1, 2):
        for side in (-1.0, 1.0):
            size, at = [thick] * 3, [0.0] * 3
            size[axis], at[axis] = 2 * half, side * (thick / 2 + half)
            arms.append(_block((size[0], size[1], size[2]), (at[0], at[1], at[2])))
    return arms


SHAPES: dict[str, Callable[[np.random.Generator], Parts]] = {
    "pebble": _pebble,
    "tube": _tube,
    "bracket": _bracket,
    "wedge": _wedge,
    "bottle": _bottle,
    "bolt": _bolt,
    "jack": _jack,
}
"""Shapes by formula, equally often."""
