"""Where a depth camera puts the pixels at borders: rendered ones beside those of recorded frames."""

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from topple.benchmarks.row import Row
from topple.topology.base.arrays import FloatArray, IntArray

FAR, NEAR = 8, 4
"""[pixel] from a border, between which the surfaces to both sides are seen; they go on straight up to it."""

STEP = 0.03  # [m] least depth step between the two sides: four times what a surface bends by in eight pixels
SLACK = 0.006  # [m] four times a camera's noise
STRAIGHT = 0.02  # [m] by which a surface may rise between `FAR` and `NEAR`
PLACES = (-2, -1, 0, 1, 2, 3)
"""[pixel] across a border: up to 0 in the nearer object's mask."""

KINDS = ("lost", "nearer", "further", "between", "beyond both")


def border_rows(column: str, pictures: Iterable[tuple[FloatArray, IntArray]]) -> list[Row]:
    """Shares of what pixels across borders with a depth step are.

    Args:
        column: What the pictures are.
        pictures: Depth (H, W) in [m] and masks (H, W) of each.
    """
    counts = np.zeros((len(PLACES), len(KINDS)))
    for depth, label in pictures:
        for turn in range(4):
            counts += _counted(np.rot90(depth, turn), np.rot90(label, turn))
    shares = counts / np.maximum(counts.sum(axis=1, keepdims=True), 1.0)
    return [
        Row(f"{place:+d} px: {kind}", float(share), "", column=column)
        for place, row in zip(PLACES, shares, strict=True)
        for kind, share in zip(KINDS, row, strict=True)
    ]


def _counted(depth: FloatArray, label: IntArray) -> FloatArray:
    """(places, kinds) pixels at borders whose nearer object is to the left."""
    rows, columns = np.nonzero((label[:, :-1] != label[:, 1:]) & (label[:, :-1] > 0))
    inside = (columns >= FAR) & (columns + FAR + 1 < label.shape[1])
    rows, columns = rows[inside], columns[inside]
    reach = np.arange(FAR + 1)[:, None]
    left, right = label[rows, columns - reach], label[rows, columns + 1 + reach]  # (FAR + 1, N)
    wide = (left == left[0]).all(axis=0) & (right == right[0]).all(axis=0)
    rows, columns = rows[wide], columns[wide]
    at = np.array([[NEAR], [FAR]])
    front, back = depth[rows, columns - at], depth[rows, columns + 1 + at]  # (2, N)
    straight = (np.abs([front[0] - front[1], back[0] - back[1]]) < STRAIGHT).all(axis=0)
    steps = (np.minimum(front, back).min(axis=0) > 0) & (back[0] - front[0] > STEP) & straight
    rows, columns, front, back = rows[steps], columns[steps], front[:, steps], back[:, steps]
    found = np.zeros((len(PLACES), len(KINDS)))
    for i, place in enumerate(PLACES):
        z = depth[rows, columns + place]
        nearer = front[0] + (front[0] - front[1]) * (NEAR + place) / (FAR - NEAR)
        further = back[0] + (back[0] - back[1]) * (NEAR + 1 - place) / (FAR - NEAR)
        tests = [
            z <= 0,
            np.abs(z - nearer) <= SLACK,
            np.abs(z - further) <= SLACK,
            (z > nearer) & (z < further),
        ]
        kinds = np.select(tests, range(4), default=4)
        found[i] = np.bincount(kinds, minlength=len(KINDS))
    return found


def pictures_of(paths: Iterable[Path]) -> Iterable[tuple[FloatArray, IntArray]]:
    """The first picture of files of given scenes or of recorded frames."""
    for path in paths:
        with np.load(path, allow_pickle=False) as held:
            last = "" if "depth" in held.files else "_0"
            yield held[f"depth{last}"].astype(float), held[f"label{last}"].astype(np.int64)
