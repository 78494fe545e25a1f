"""Shelves of others: what is told to go first in the can shelves of a published rearrangement study.

Rui1223/uniform_object_rearrangement (Wang, Miao, Bekris, ICRA 2022) has 14 instances of 6 to 12 cans, 6 cm
wide and 25 cm high, in a bay 50 cm deep, 150 cm wide and 50 cm high that is open at the front. `--data DIR`
reads `DIR/examples/N/K/instance_info.txt` of its checkout. Three cameras look in from the front, so pictures
end on the board on top. Each can that is seen is asked for: first goes what stands in the strip before it,
and before each of these what stands before that. Cans on the edge of a strip are not counted, nor are those
that wait for one. Beside it, sorting by height: all are of one height, so nothing goes first.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from topple.benchmarks.row import Progress
from topple.benchmarks.scores import share
from topple.planner import order
from topple.robots import Body, Camera, new_world
from topple.robots.shapes import box, can
from topple.topology import Situation
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput
from topple.topology.scene.scene import Scene

DEEP, WIDE, HIGH, BOARD, FRONT = 0.50, 1.50, 0.50, 0.005, 0.84  # [m] of the bay; x of its open side
ACROSS, TALL = 0.06, 0.25  # [m] of a can
EDGE = 0.004  # [m] of overlap of two strips within which it is not clear whether one can passes the other
EYES = ((-0.6, 0.6, 0.55), (-0.6, -0.6, 0.55), (-0.45, 0.1, 0.9))  # [m] from the middle of the front edge
LOOK_AT = (0.2, 0.0, 0.12)  # [m]


def rows(quick: bool, seed: int, progress: Progress, data: Path | None = None) -> list[dict[str, Any]]:
    """Measure.

    Args:
        quick: Every third instance alone.
        seed: Of the cameras' noise.
        progress: Called before each instance.
        data: A checkout.

    Raises:
        InvalidInput: There is no instance in it.
    """
    found = sorted(data.glob("examples/*/*/instance_info.txt")) if data is not None else []
    if not found:
        raise InvalidInput("cans needs --data DIR: a checkout of Rui1223/uniform_object_rearrangement")
    right: list[bool] = []
    plain: list[bool] = []
    wrong: list[str] = []
    for path in found[:: 3 if quick else 1]:
        progress("/".join(path.parts[-3:-1]))
        fields = [line.split() for line in path.read_text("utf-8").splitlines()]
        at = np.array(
            [[float(x) - FRONT, float(y)] for x, y, _ in (each for each in fields if len(each) == 3)]
        )
        for target, (first, told) in _orders_of(at, seed).items():
            right.append(first == told)
            plain.append(not first)
            if first != told:
                wrong.append(
                    f"{path.parts[-3]}/{path.parts[-2]} {target}: {sorted(told)}, not {sorted(first)}"
                )
    what = "cans before which goes what stands before them, and nothing else"
    plainly = "by height", sum(plain), len(plain)
    row = share(what, sum(right), len(right), against=plainly, counted=True, wrong=wrong[:12])
    return [row.to_json()]


def _orders_of(at: FloatArray, seed: int) -> Mapping[str, tuple[set[str], set[str]]]:
    """Can -> what has to go before it, and what is told to, of cans at places (N, 2) in the bay [m]."""
    names = [f"can_{number}" for number in range(len(at))]
    with new_world() as world:
        world.add_table(size=(1.2, 2.0), centre=(-0.2, 0.0))
        world.add(_bay(), _pose(DEEP / 2, 0.0, 0.0), fixed=True)
        for name, (x, y) in zip(names, at.tolist(), strict=True):
            world.add(can(name, diameter=ACROSS, height=TALL), _pose(x, y, BOARD))
        world.settle(3.0)
        rng = np.random.default_rng(seed)
        middle = float(at[:, 1].mean())
        aside = np.array([0.0, middle, 0.0])
        cameras = [Camera.looking_at(tuple(eye + aside), tuple(LOOK_AT + aside)) for eye in np.array(EYES)]
        images = [camera.look(world, rng) for camera in cameras]
        scene = Scene.from_images(images, fixed=tuple(sorted(world.fixed)), up=(0.0, 0.0, 1.0))
    apart = np.abs(at[:, None, 1] - at[None, :, 1]) - ACROSS
    before = (at[:, None, 0] > at[None, :, 0]) & (apart < 0.0)
    doubtful = np.any(np.abs(apart) < EDGE, axis=1)
    situation = Situation(scene)
    found: dict[str, tuple[set[str], set[str]]] = {}
    for number, name in enumerate(names):
        needed, border = set[int](), [number]
        while border:
            more = set(np.flatnonzero(before[border.pop()]).tolist()) - needed
            needed |= more
            border += more
        if name in scene.clouds and not doubtful[[number, *needed]].any():
            told = set(order(situation, [name]).order) - {name}
            found[name] = ({names[each] for each in needed}, told)
    return found


def _bay() -> Body:
    """Bottom, top, back and sides; the middle of the bottom's underside is the origin."""
    slabs = [((DEEP, WIDE, BOARD), (0.0, 0.0, level * (HIGH + BOARD))) for level in (0.0, 1.0)]
    slabs += [((BOARD, WIDE, HIGH), (DEEP / 2, 0.0, BOARD))]
    slabs += [((DEEP, BOARD, HIGH), (0.0, side * WIDE / 2, BOARD)) for side in (-1.0, 1.0)]
    parts = [box("slab", size).parts[0] + np.array(place) for size, place in slabs]
    return Body.of("bay", parts, density=600.0, kind="shelf")


def _pose(x: float, y: float, z: float) -> FloatArray:
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose
