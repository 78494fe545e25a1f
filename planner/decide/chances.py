"""How likely taking one object moves another: what was found of a pair, weighed by how often it was true.

The chance of a pair is the logistic function of a weighted sum of its `SIGNS`. The weights are fitted, by
maximum likelihood, to scenes that were simulated, for each view, and no score is reported on these
scenes. `chances.json` holds them; `python -m topple.benchmarks.chances` fits them anew.

Of one kind there are too few to weigh: two that lean on each other, neither of which rests on the other, and
each of which falls without the other. Several cameras are believed of it, one is not: of the pairs of which
three cameras say it 2 of 2 (pictures) and 7 of 10 (clouds) hold each other, of one camera's 2 of 15.
"""

from collections.abc import Mapping
from functools import cache
from importlib.resources import files

import msgspec
import numpy as np
from scipy.special import expit

from topple.planner.decide.disturbance import Disturbance, Pair
from topple.planner.decide.tolerances import HOLD_EACH_OTHER, RESTS
from topple.topology.base.arrays import FloatArray
from topple.topology.scene.scene import Scene
from topple.topology.sixim.confidence import view_of
from topple.topology.views.tolerances import OFF_BORDERS

SIGNS = (
    "always", "meets", "falls", "hangs over", "seen over", "seen broadly", "hung over", "unheld", "upward",
    "hooked", "depth", "bottom", "top", "tilted"
)  # fmt: skip
"""What is weighed of a pair: 1; what the two questions say; the logarithms of the areas in plan by which the
one hangs over the other, with hidden sides where it is broad, as seen, and as seen where it is broad, and by
which the other hangs over it, in cm² and one more; the share of its weight that nothing carries without the
other; how much the contact's normal points upward, and that times the logarithm of the area by which the
other is seen to hang over it; by how many times 2 cm they lie in each other, up to 1.5; by how many times 5
cm bottom and top are higher, up to 2; how much of it was seen in a face neither level nor upright."""


def signs(asked: Mapping[Pair, Disturbance]) -> FloatArray:
    """Turn the disturbances of pairs into the signs that chances are weighed by.

    Args:
        asked: What was found of each.

    Returns:
        (pair, sign) as `SIGNS` has them, pairs as they were given.
    """
    rows: list[tuple[float, ...]] = []
    for (first, then), each in asked.items():
        (hung, hooked, _), upward = _areas(asked.get((then, first))), max(each.up or 0.0, 0.0)
        higher = np.clip(np.array(each.ahead) / 0.05, -2.0, 2.0)
        rows.append(
            (1.0, each.meets, each.falls, *_areas(each), hung, each.unheld, upward, upward * hooked,
             min(each.depth / 0.02, 1.5), *higher, each.tilted)
        )  # fmt: skip
    return np.array(rows, dtype=float).reshape(-1, len(SIGNS))


def _areas(found: Disturbance | None) -> list[float]:
    """By what areas a thing hangs over another, as `SIGNS` have them."""
    over, seen = (None, None) if found is None else (found.over, found.seen)
    areas = (over.broad if over else 0.0, seen.area if seen else 0.0, seen.broad if seen else 0.0)
    return [float(np.log1p(area / 1e-4)) for area in areas]


def chances(asked: Mapping[Pair, Disturbance], view: str) -> dict[Pair, float]:
    """How likely taking `then` moves `first`, of pairs of which something was found.

    Args:
        asked: What was found of each.
        view: Of the scene, by `seen_by`.

    Returns:
        (first, then) -> 0..1, before any simulation.
    """
    found = dict(zip(asked, expit(signs(asked) @ weights()[view]).tolist(), strict=True))
    if view.startswith(view_of(2)):
        found |= {pair: max(found[pair], HOLD_EACH_OTHER) for pair in asked if _hold_each_other(*pair, asked)}
    return found


def _hold_each_other(a: str, b: str, asked: Mapping[Pair, Disturbance]) -> bool:
    leans = abs(asked[a, b].up or 0.0) <= RESTS
    return leans and all(pair in asked and asked[pair].falls for pair in ((a, b), (b, a)))


def seen_by(scene: Scene) -> str:
    """Name the kind of view: none that hid a side, one camera or several, and what is known of it."""
    view = view_of(len(scene.viewpoints))
    if not scene.images:
        return view if not len(scene.viewpoints) else f"{view}, clouds"
    off = np.mean([image.borders.off for image in scene.images])
    return f"{view}, masks off" if off > OFF_BORDERS else view


class _Kept(msgspec.Struct):
    weights: dict[str, tuple[float, ...]]


@cache
def weights() -> Mapping[str, tuple[float, ...]]:
    """View -> the weight of each of `SIGNS`."""
    kept = files("topple.planner.decide").joinpath("chances.json").read_bytes()
    return msgspec.json.decode(kept, type=_Kept).weights
