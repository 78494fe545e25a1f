"""Six scenes that everybody knows, of parts 5 to 16 cm long, taken apart by four arms.

Clouds are points on the whole surface of each part, with 0.3 mm of noise. A plan counts that frees the
target, which lies at the bottom, and passes its check; what the others fail of is named. Then whether a cup
seals on flat things, whatever the noise.
"""

from collections.abc import Mapping
from itertools import product
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from topple.benchmarks.row import Progress, Row
from topple.benchmarks.truth.geometry import surface
from topple.planner.errors import NoSafePlan
from topple.planner.grasp.candidates import grasp_candidates
from topple.planner.grasp.suction import CupShape, cup_shape
from topple.planner.planning.plan import plan
from topple.robots.catalog import names, robot
from topple.topology.base.arrays import FloatArray
from topple.topology.scene.scene import Scene

POINTS, TABLE_POINTS = 1500, 20000
"""On each part, and on a table of 1.2 x 1.2 m."""

NOISE = 3e-4
"""[m] of the points: that of a good scanner."""

HELD = 22
"""Of the 24 are to be planned and to verify."""

LEAN = 20
"""[degrees] by which the book leans."""


def box(edges: tuple[float, float, float], x: float, y: float, bottom: float) -> FloatArray:
    """(8, 3) corners of a box of some edges [cm], its underside's middle at a place [cm]."""
    corners = np.array([[i, j, k] for i in (-0.5, 0.5) for j in (-0.5, 0.5) for k in (0.0, 1.0)])
    return np.array(corners * edges + [x, y, bottom])


def disc(diameter: float, height: float, bottom: float) -> FloatArray:
    """(96, 3) corners of a disc [cm] about the vertical."""
    turns = np.linspace(0, 2 * np.pi, 48, endpoint=False)
    ring = np.column_stack([np.cos(turns), np.sin(turns)]) * diameter / 2
    return np.vstack([np.column_stack([ring, np.full(48, z)]) for z in (bottom, bottom + height)])


def leaning(edges: tuple[float, float, float]) -> FloatArray:
    """(8, 3) corners of a box whose upper edge leans against the plane x = 0."""
    turned = Rotation.from_euler("y", -LEAN, degrees=True).apply(box(edges, 0, 0, 0))
    return np.array(turned - [turned[:, 0].min(), 0, turned[:, 2].min()])


SCENES: dict[str, tuple[dict[str, FloatArray], str]] = {
    "pyramid": (
        {
            f"cube {row} {k}": box((5, 5, 5), 0, 5.2 * (k + row / 2 - 1), 5 * row)
            for row in range(3)
            for k in range(3 - row)
        },
        "cube 0 1",
    ),
    "slab on posts": (
        {f"post {x} {y}": box((3, 3, 10), 6 * x, 2 * y, 0) for x in (-1, 1) for y in (-1, 1)}
        | {"slab": box((16, 7, 2), 0, 0, 10)},
        "post 1 1",
    ),
    "discs": ({f"disc {k}": disc(7 - k, 2.5, 2.5 * k) for k in range(3)}, "disc 0"),
    "leaning book": ({"block": box((7, 9, 16), -3.5, 0, 0), "book": leaning((2.5, 12, 16))}, "block"),
    "bridges": (
        {f"pier {k} {y}": box((5, 4, 8), 0, 5 * y, 10 * k) for k in range(2) for y in (-1, 1)}
        | {f"deck {k}": box((5, 16, 2), 0, 0, 8 + 10 * k) for k in range(2)},
        "pier 0 1",
    ),
    "planks": (
        {
            f"plank {k} {s}": box(
                (16, 4, 2) if k % 2 else (4, 16, 2), 5 * s * (1 - k % 2), 5 * s * (k % 2), 2 * k
            )
            for k in range(3)
            for s in (-1, 1)
        },
        "plank 0 1",
    ),
}
"""The parts of each [cm], and what is freed."""


FLAT = {
    "disc of 90 mm": disc(9, 2, 0),
    "box of 130 x 90 x 50 mm": box((13, 9, 5), 0, 0, 0),
    "board of 130 x 90 x 10 mm": box((13, 9, 1), 0, 0, 0),
}
"""What a cup is to seal on, whatever the noise [cm]."""

SEEDS = 50
"""Of noise on each."""


def scene_of(parts: Mapping[str, FloatArray], seed: int) -> Scene:
    """Parts [cm] as clouds on a table of 1.2 x 1.2 m."""
    rng = np.random.default_rng(seed)
    clouds = {name: surface((part / 100,), POINTS, rng) for name, part in parts.items()}
    clouds["table"] = surface((box((120, 120, 2), 0, 0, -2) / 100,), TABLE_POINTS, rng)
    noisy = {name: cloud + rng.normal(0, NOISE, cloud.shape) for name, cloud in clouds.items()}
    return Scene(noisy, fixed=["table"], up=(0, 0, 1))


def trial(name: str, arm: str, seed: int) -> str:
    """Free the target of a scene by an arm; what that fails of, empty where the plan verifies."""
    parts, target = SCENES[name]
    scene = scene_of(parts, seed)
    try:
        found = plan(scene, [target], arm, seed=seed).verify(scene)
    except NoSafePlan as error:
        return str(error)
    return ", ".join(residual.name for residual in found.residuals if not residual.ok)


def seals(name: str, seed: int, cup: CupShape) -> bool:
    """Whether a cup is found to hold a flat thing."""
    return bool(grasp_candidates(name, scene_of({name: FLAT[name]}, seed), tools=[cup]))


def rows(quick: bool, seed: int, progress: Progress) -> list[dict[str, Any]]:
    """Measure.

    Args:
        quick: Two scenes, and five seeds of noise.
        seed: Of the points and of every search; the first of noise.
        progress: Called before each plan.
    """
    wrong, tried = list[str](), 0
    for name, arm in product(list(SCENES)[: 2 if quick else None], names()[:4]):
        progress(f"{name}, {arm}: planning and verifying")
        words, tried = trial(name, arm, seed), tried + 1
        wrong += [f"{name}, {arm}: {words}"] if words else []
    held, what = tried - len(wrong), "targets freed from below by plans that verify"
    bar = None if quick else f">= {HELD}"
    found = [Row(what, float(held), "plans", bar=bar, tried=tried, held=held, wrong=tuple(wrong))]
    cup, seeds = cup_shape(robot("panda-suction")), range(seed, seed + (5 if quick else SEEDS))
    for name in FLAT:
        progress(f"a cup on a {name}")
        held = sum(seals(name, one, cup) for one in seeds)
        share = 100 * held / len(seeds)
        found.append(Row(f"a cup seals on a {name}", share, "%", bar=">= 100", tried=len(seeds), held=held))
    return [row.to_json() for row in found]
