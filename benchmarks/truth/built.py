"""Scenes as in warehouses: bins of mixed goods, walls of unlike bricks, slabs that lean on each other."""

import numpy as np
from scipy.spatial.transform import Rotation

from topple.benchmarks.truth.resting import GAP, Layout, RestingScene, of_a_kind
from topple.robots import shapes
from topple.robots.world.bodies import Body


def built(seed: int) -> tuple[str, RestingScene]:
    """A bin, a wall or slabs: `topple.benchmarks.truth.resting.of_a_kind`."""
    return of_a_kind({"bin": _bin, "wall": _wall, "slabs": _slabs}, seed, 44)


def goods(name: str, rng: np.random.Generator) -> Body:
    """One of the things that bins hold."""
    kind = str(rng.choice(["box", "flat", "can", "ball", "cup", "bowl", "rod", "tile", "bottle"]))
    makers = {
        "box": lambda: shapes.box(f"box_{name}", tuple(rng.uniform(0.04, 0.1, 3))),
        "flat": lambda: shapes.box(f"flat_{name}", (*rng.uniform(0.08, 0.15, 2), rng.uniform(0.02, 0.04))),
        "can": lambda: shapes.can(
            f"can_{name}", diameter=rng.uniform(0.05, 0.08), height=rng.uniform(0.05, 0.1)
        ),
        "ball": lambda: shapes.ball(f"ball_{name}", diameter=rng.uniform(0.04, 0.07)),
        "cup": lambda: shapes.cup(
            f"cup_{name}", diameter=rng.uniform(0.07, 0.09), height=rng.uniform(0.07, 0.1)
        ),
        "bowl": lambda: shapes.bowl(
            f"bowl_{name}", diameter=rng.uniform(0.11, 0.15), height=rng.uniform(0.045, 0.06)
        ),
        "rod": lambda: shapes.bar(f"rod_{name}", (rng.uniform(0.12, 0.2), 0.02, 0.02)),
        "tile": lambda: shapes.box(f"tile_{name}", (*rng.uniform(0.06, 0.1, 2), 0.012)),
        "bottle": lambda: shapes.bottle(f"bottle_{name}"),
    }
    return makers[kind]()


def _bin(layout: Layout) -> None:
    """Things dropped into a bin that stands fast."""
    x, y, z = layout.number(0.26, 0.36), layout.number(0.2, 0.28), layout.number(0.06, 0.12)
    layout.put(shapes.tray("bin", (x, y, z), wall=0.008), (0, 0, 0), fixed=True)
    for k in range(int(layout.rng.integers(3, 7))):
        layout.drop(goods(str(k), layout.rng), (0, 0), 0.05)


def _wall(layout: Layout) -> None:
    """Courses of boxes, flat and standing ones, with gaps; and what lies on top and leans in front."""
    rng, top = layout.rng, 0.0
    depth, number = layout.number(0.05, 0.09), 0
    for course in range(int(rng.integers(2, 4))):
        height, x = layout.number(0.03, 0.07), layout.number(-0.16, -0.1) + 0.03 * course
        while x < 0.13 - 0.03 * course:
            width = layout.number(0.05, 0.13)
            if course == 0 or rng.random() < 0.85:
                body = shapes.box(f"box_{number}", (width, depth * layout.number(0.8, 1.1), height))
                layout.put(body, (x + width / 2, layout.number(-0.006, 0.006), top + GAP))
                number += 1
            x += width + (layout.number(0.002, 0.03) if rng.random() < 0.4 else 0.001)
        top += height + GAP
    layout.world.settle(2.0)
    layout.stay.clear()  # what was laid over a gap may tip: it lies as it falls
    for k in range(int(rng.integers(1, 4))):
        layout.drop(goods(f"{k}x", rng), (0, layout.number(-0.02, 0.08)), 0.06)


def _slabs(layout: Layout) -> None:
    """Slabs that lean in a row on something that stands, each on the one before."""
    rng = layout.rng
    high, fixed = layout.number(0.12, 0.18), bool(rng.random() < 0.4)
    stop = shapes.box("stop", (0.05, 0.16, high), density=900.0)
    layout.put(stop, (-0.1, 0, 0), fixed=fixed)
    x = -0.1 + 0.025 + GAP
    for k in range(int(rng.integers(2, 6))):
        thick, long, tilt = layout.number(0.012, 0.035), layout.number(0.1, 0.17), layout.number(0.12, 0.4)
        slab = shapes.box(f"slab_{k}", (thick, layout.number(0.08, 0.14), long))
        foot = x + thick / 2 + min(long, high) * np.sin(tilt)
        layout.put(slab, (foot, layout.number(-0.02, 0.02), 1e-3), Rotation.from_euler("y", -tilt))
        layout.world.settle(1.0)
        x = foot - min(long, high) * np.sin(tilt) + 0.8 * thick + GAP
    layout.stay.clear()
    for k in range(int(rng.integers(0, 3))):
        layout.drop(goods(f"{k}x", rng), (-0.05, 0), 0.07)
