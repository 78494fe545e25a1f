"""Arrangements with a point: things over, in, around, through, across each other, and hung."""

from collections.abc import Mapping
from functools import partial

import numpy as np
from scipy.spatial.transform import Rotation

from topple.benchmarks.truth.built import goods
from topple.benchmarks.truth.resting import GAP, Lay, Layout, RestingScene, of_a_kind
from topple.robots import shapes
from topple.robots.shapes.vessel import circle, rings, sectors
from topple.robots.world.bodies import Body
from topple.topology.base.arrays import FloatArray

Size = tuple[float, float, float]


def designed(seed: int) -> tuple[str, RestingScene]:
    """One of `KINDS`, often with things beside it: `topple.benchmarks.truth.resting.of_a_kind`."""
    return of_a_kind({kind: partial(_with_things_beside, lay) for kind, lay in KINDS.items()}, seed, 46)


def leaning(seed: int) -> tuple[str, RestingScene]:
    """Boards that lean on something, often with things beside it; their friction holds at such tilts."""
    return of_a_kind({"leaning": partial(_with_things_beside, _leaning)}, seed, 77)


def _with_things_beside(lay: Lay, layout: Layout) -> None:
    lay(layout)
    for k in range(int(layout.rng.integers(0, 3))):
        angle = layout.number(0, 2 * np.pi)
        layout.drop(goods(f"{k}x", layout.rng), 0.2 * np.array([np.cos(angle), np.sin(angle)]), 0.02)


def _block(size: Size, at: Size) -> FloatArray:
    signs = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    return signs * size + at


def _ring(name: str, inner: float, outer: float, height: float) -> Body:
    """A flat ring around z that stands on z = 0."""
    stack = rings(circle(16), [(outer, 0.0), (outer, height), (inner, height), (inner, 0.0)])
    return Body.of(name, sectors(stack, (0, 1, 2, 3)), kind="ring")


def _frame(name: str, x: float, y: float, z: float, wall: float) -> Body:
    """Four walls without floor or lid: inner extents x, y."""
    parts = [
        *(_block((x + 2 * wall, wall, z), (0, side * (y + wall) / 2, z / 2)) for side in (-1, 1)),
        *(_block((wall, y, z), (side * (x + wall) / 2, 0, z / 2)) for side in (-1, 1)),
    ]
    return Body.of(name, parts, kind="frame")


def _hook(name: str, wide: float, drop: float, deep: float, thick: float) -> Body:
    """A strap bent over an edge: a roof (wide across) and two sides that hang down from z = 0."""
    sides = [_block((thick, deep, drop), (s * (wide + thick) / 2, 0, -drop / 2)) for s in (-1, 1)]
    roof = _block((wide + 2 * thick, deep, thick), (0, 0, thick / 2))
    return Body.of(name, [roof, *sides], kind="strap")


def _peg(name: str, height: float, radius: float) -> Body:
    """An upright peg on a foot."""
    stack = rings(circle(16), [(radius, 0.012), (radius, height)])
    return Body.of(name, [_block((0.11, 0.11, 0.012), (0, 0, 0.006)), stack.reshape(-1, 3)], kind="peg")


def _stand(name: str, height: float, reach: float) -> Body:
    """A post on a heavy foot with an arm to +x that rises to its end, to hang things on."""
    foot, post = _block((0.14, 0.14, 0.02), (0, 0, 0.01)), _block((0.02, 0.02, height), (0, 0, height / 2))
    arm = _block((reach, 0.012, 0.012), (reach / 2, 0, height))
    tip = _block((0.01, 0.012, 0.03), (reach + 0.005, 0, height + 0.009))
    return Body.of(name, [foot, post, arm, tip], kind="stand", density=2000.0)


def _handled(name: str, radius: float, height: float) -> Body:
    """A cup whose handle is a loop to +x."""
    stack = rings(
        circle(16), [(radius, 0.0), (radius, height), (radius - 0.004, height), (radius - 0.004, 0)]
    )
    floor = rings(circle(16), [(radius, 0.0), (radius, 0.004)]).reshape(-1, 3)
    grip, loop = 0.008, 0.6 * height
    parts = [
        *sectors(stack, (0, 1, 2, 3)),
        floor,
        *(_block((0.04, grip, grip), (radius + 0.015, 0, height / 2 + s * loop / 2)) for s in (-1, 1)),
        _block((grip, grip, loop), (radius + 0.035, 0, height / 2)),
    ]
    return Body.of(name, parts, kind="mug")


def _over(layout: Layout) -> None:
    """A vessel upside down over something, which may fill it or not."""
    upside = Rotation.from_euler("x", np.pi)
    low = layout.number(0.015, 0.035)
    kind = int(layout.rng.integers(3))
    if kind == 0:
        layout.put(shapes.box("cookie", (layout.number(0.03, 0.06), 0.04, low)), (0, 0, 0))
        layout.put(shapes.bowl("bowl", diameter=layout.number(0.13, 0.16)), (0, 0, 0.0605), upside)
    elif kind == 1:
        layout.put(shapes.ball("ball", diameter=layout.number(0.035, 0.05)), (0, 0, 0))
        layout.put(shapes.cup("cup", diameter=0.085, height=0.095), (0, 0, 0.0955), upside)
    else:
        size = layout.number(0.08, 0.11), layout.number(0.06, 0.09), layout.number(0.03, 0.08)
        layout.put(shapes.box("box", size), (0, 0, 0))
        lid = shapes.tray("lid", (size[0] + 0.018, size[1] + 0.018, 0.025), wall=0.005)
        layout.put(lid, (0, 0, size[2] + 0.0055), upside)


def _in(layout: Layout) -> None:
    """Things in a vessel, a lid on it or not; bowls in bowls; a rod that stands in a hollow box."""
    kind = int(layout.rng.integers(4))
    if kind == 0:
        layout.put(shapes.bowl("bowl", diameter=layout.number(0.15, 0.2), height=0.07), (0, 0, 0))
        for k in range(int(layout.rng.integers(1, 4))):
            layout.drop(shapes.ball(f"ball_{k}", diameter=layout.number(0.03, 0.05)), (0, 0), 0.01)
        if layout.rng.random() < 0.6:
            layout.drop(shapes.plate("lid", diameter=0.22), (0, 0), 0.0, 0.0)
    elif kind == 1:
        layout.put(shapes.tray("basket", (layout.number(0.16, 0.22), 0.15, 0.09)), (0, 0, 0))
        for k in range(int(layout.rng.integers(2, 6))):
            layout.drop(goods(str(k), layout.rng), (0, 0), 0.02)
    elif kind == 2:
        for k in range(int(layout.rng.integers(2, 5))):
            layout.put(shapes.bowl(f"bowl_{k}", diameter=0.15), (0, 0, 0.016 * k))
        if layout.rng.random() < 0.5:
            layout.drop(shapes.lemon("lemon"), (0, 0), 0.005)
    else:
        layout.put(shapes.tray("hollow", (0.08, 0.08, layout.number(0.08, 0.12))), (0, 0, 0))
        turn = Rotation.from_euler("yz", [np.pi / 2 - 0.25, layout.number(0, 6)])
        layout.put(shapes.bar("rod", (layout.number(0.14, 0.2), 0.02, 0.02)), (0, 0, 0.13), turn)
        layout.stay.remove("rod")


def _around(layout: Layout) -> None:
    """A ring or a frame around something that it does not touch, and what may lie across both."""
    if layout.rng.random() < 0.5:
        layout.put(shapes.can("can", diameter=0.06, height=layout.number(0.05, 0.11)), (0, 0, 0))
        inner = layout.number(0.04, 0.05)
        layout.put(_ring("ring", inner, inner + 0.015, layout.number(0.015, 0.04)), (0, 0, 0))
    else:
        layout.put(shapes.cup("cup", height=layout.number(0.07, 0.1)), (0, 0, 0))
        layout.put(_frame("frame", 0.12, 0.11, layout.number(0.03, 0.11), 0.012), (0, 0, 0))
    if layout.rng.random() < 0.4:
        layout.drop(shapes.bar("bar", (0.2, 0.03, 0.02)), (0, 0), 0.01, 0.0)


def _through(layout: Layout) -> None:
    """Rings on a peg; a bar through a frame that stands on its side."""
    if layout.rng.random() < 0.6:
        layout.put(_peg("peg", layout.number(0.1, 0.16), 0.012), (0, 0, 0))
        top = 0.0125
        for k in range(int(layout.rng.integers(1, 5))):
            height = layout.number(0.012, 0.03)
            ring = _ring(f"ring_{k}", layout.number(0.016, 0.022), layout.number(0.035, 0.05), height)
            layout.put(ring, (0, 0, top))
            top += height + GAP
    else:
        turn, high = Rotation.from_euler("x", np.pi / 2), layout.number(0.06, 0.09)
        layout.put(_frame("frame", 0.1, high, 0.05, 0.012), (0, 0.025, high / 2 + 0.0125), turn)
        along = Rotation.from_euler("z", np.pi / 2)
        layout.put(shapes.bar("bar", (0.2, 0.04, layout.number(0.02, 0.03))), (0, 0, 0.013), along)
        layout.stay.remove("bar")


def _across(layout: Layout) -> None:
    """A plank across piers with something under it, a slab on posts, a bar across a bowl."""
    kind = int(layout.rng.integers(3))
    if kind == 0:
        high, span = layout.number(0.06, 0.1), layout.number(0.07, 0.11)
        for name, side in (("pier_a", -1), ("pier_b", 1)):
            layout.put(shapes.box(name, (0.04, 0.07, high)), (side * span, 0, 0))
        layout.put(shapes.box("plank", (2 * span + 0.05, 0.07, 0.018)), (0, 0, high + GAP))
        if layout.rng.random() < 0.7:
            layout.put(shapes.can("under", diameter=0.05, height=high * layout.number(0.4, 0.9)), (0, 0, 0))
        for k in range(int(layout.rng.integers(0, 3))):
            x = (2 * k - 1) * layout.number(0.2, 0.8) * span
            layout.put(shapes.box(f"load_{k}", (0.04, 0.04, 0.05)), (x, 0, high + 0.018 + 2 * GAP))
    elif kind == 1:
        high, x, y = layout.number(0.05, 0.1), layout.number(0.05, 0.08), layout.number(0.04, 0.06)
        places = [(-x, -y), (x, -y), (x, y), (-x, y)]
        for k, (px, py) in enumerate(places):
            layout.put(shapes.box(f"post_{k}", (0.025, 0.025, high)), (px, py, 0))
        layout.put(shapes.box("slab", (2 * x + 0.04, 2 * y + 0.04, 0.015)), (0, 0, high + GAP))
        if layout.rng.random() < 0.6:
            layout.drop(goods("top", layout.rng), (0, 0), 0.01, 0.0)
    else:
        layout.put(shapes.bowl("bowl", diameter=layout.number(0.13, 0.16)), (0, 0, 0))
        layout.drop(shapes.ball("ball", diameter=layout.number(0.03, 0.045)), (0, 0), 0.01)
        layout.drop(shapes.bar("bar", (0.22, 0.025, 0.015)), (0, 0), 0.01, 0.0)
        if layout.rng.random() < 0.4:
            layout.drop(shapes.spoon("spoon"), (0, 0), 0.01, 0.0)


def _hung(layout: Layout) -> None:
    """A cup on an arm by its handle, rings on an arm, a strap over a box."""
    kind = int(layout.rng.integers(3))
    fixed = bool(layout.rng.random() < 0.5)
    if kind == 0:
        layout.put(_stand("stand", 0.22, 0.09), (0, 0, 0), fixed=fixed)
        radius, high = layout.number(0.03, 0.04), layout.number(0.07, 0.09)
        # the handle points up: its loop goes over the arm, the cup hangs below
        turn = Rotation.from_euler("z", np.pi / 2) * Rotation.from_euler("y", -np.pi / 2)
        cup = _handled("mug", radius, high)
        low = 0.22 + 0.006 + GAP - (radius + 0.031)
        layout.put(cup, np.array([0.06, 0, low]) - turn.apply([0, 0, high / 2]), turn)
    elif kind == 1:
        layout.put(_stand("stand", 0.2, 0.1), (0, 0, 0), fixed=fixed)
        turn = Rotation.from_euler("y", np.pi / 2)
        for k in range(int(layout.rng.integers(1, 3))):
            inner, height = layout.number(0.03, 0.05), 0.015
            z = 0.2 + 0.006 - inner + GAP + 0.002
            layout.put(_ring(f"ring_{k}", inner, inner + 0.012, height), (0.025 + 0.03 * k, 0, z), turn)
    else:
        wide, high = layout.number(0.05, 0.09), layout.number(0.07, 0.12)
        layout.put(shapes.box("box", (wide, 0.14, high)), (0, 0, 0))
        strap = _hook("strap", wide + 0.006, high * layout.number(0.3, 0.7), layout.number(0.05, 0.1), 0.008)
        layout.put(strap, (0, layout.number(-0.02, 0.02), high + GAP))
        if layout.rng.random() < 0.4:
            layout.put(shapes.box("load", (0.04, 0.04, 0.03)), (0, 0, high + 0.0085 + GAP))


def _balanced(layout: Layout) -> None:
    """A plank past its pier's edge that a weight holds down; a tower whose blocks are set aside."""
    if layout.rng.random() < 0.5:
        pier = 0.07, 0.08, layout.number(0.05, 0.1)
        layout.put(shapes.box("pier", pier), (0, 0, 0))
        aside = layout.number(0.03, 0.06)
        layout.put(shapes.box("plank", (0.26, 0.05, 0.02)), (aside, 0, pier[2] + GAP))
        layout.put(shapes.box("weight", (0.05, 0.05, 0.07)), (aside - 0.1, 0, pier[2] + 0.02 + 2 * GAP))
    else:
        top, middle, half = 0.0, np.zeros(2), 0.05
        for k in range(int(layout.rng.integers(3, 7))):
            size = layout.rng.uniform([0.05, 0.05, 0.03], [0.11, 0.11, 0.07])
            middle = middle + (layout.rng.uniform(-0.4, 0.4, 2) * half if k else 0.0)
            turn = Rotation.from_euler("z", layout.number(0, np.pi))
            layout.put(shapes.box(f"block_{k}", tuple(size)), (*middle, top), turn)
            top, half = top + float(size[2]) + GAP, float(size[:2].min()) / 2


def _between(layout: Layout) -> None:
    """Books between two bookends; cards that lean on each other."""
    if layout.rng.random() < 0.6:
        x = -0.06
        layout.put(shapes.box("end_a", (0.05, 0.1, 0.09)), (x - 0.025, 0, 0))
        for k in range(int(layout.rng.integers(2, 6))):
            thick = layout.number(0.015, 0.03)
            size = thick, layout.number(0.09, 0.13), layout.number(0.11, 0.16)
            layout.put(shapes.box(f"book_{k}", size), (x + thick / 2 + GAP, 0, 0))
            x += thick + GAP
        layout.put(shapes.box("end_b", (0.05, 0.1, 0.09)), (x + 0.025 + GAP, 0, 0))
    else:
        thick, high, tilt = 0.012, layout.number(0.09, 0.12), layout.number(0.2, 0.35)
        reach = high * np.sin(tilt) + thick * np.cos(tilt)
        for side in (-1, 1):
            turn = Rotation.from_euler("y", -side * tilt)
            foot = np.array([side * reach, 0, 1e-4]) - turn.apply([side * thick / 2, 0, 0])
            layout.put(shapes.box(f"card_{'lr'[side > 0]}", (thick, 0.08, high)), foot, turn)
        if layout.rng.random() < 0.5:
            roof = high * np.cos(tilt) + thick * np.sin(tilt) + 1e-3
            layout.put(shapes.box("roof", (0.1, 0.08, 0.012)), (0, 0, roof))


def _leaning(layout: Layout) -> None:
    """Boards and bars against a box, a can or a wall, from one side or two, sometimes with a load on top."""
    high = layout.number(0.08, 0.2)
    wall = (
        shapes.box("wall", (layout.number(0.05, 0.1), layout.number(0.08, 0.14), high)),
        shapes.can("wall", diameter=layout.number(0.06, 0.09), height=high),
        shapes.box("wall", (layout.number(0.03, 0.05), layout.number(0.12, 0.2), high)),
    )[int(layout.rng.integers(3))]
    layout.put(wall, (0, 0, 0))
    aside = float(np.concatenate(wall.parts)[:, 0].max()) + GAP
    for side in (1, -1)[: int(layout.rng.integers(1, 3))]:
        size = layout.rng.uniform([0.01, 0.03, 0.1], [0.03, 0.1, 0.24])
        tilt = layout.number(0.2, 0.87)
        touches = min(size[2], high / np.cos(tilt))  # so far up it meets the wall, or the wall's edge
        x = aside + size[0] / 2 * np.cos(tilt) + touches * np.sin(tilt)
        place = side * x, layout.number(-0.02, 0.02), size[0] / 2 * np.sin(tilt) + GAP
        turn = Rotation.from_euler("y", -side * tilt)
        layout.put(shapes.box(f"board_{'lr'[side > 0]}", tuple(size)), place, turn)
    if layout.rng.random() < 0.4:
        layout.drop(shapes.box("load", (0.04, 0.04, 0.03)), (0, 0), 0.005, 0.0)


KINDS: Mapping[str, Lay] = {
    "over": _over,
    "in": _in,
    "around": _around,
    "through": _through,
    "across": _across,
    "hung": _hung,
    "balanced": _balanced,
    "between": _between,
}
"""Each as likely as the others."""
