"""How often what is told of pairs and of supports is true: counted, not guessed.

Evidence of a kind (two surfaces apart that cameras saw apart, a touch by so much of the deviation, ...) is as
good as it was on settled piles, where the simulation knows what touches and what carries. What was counted,
and of which piles, stands in `confidence.json`; `python -m topple.benchmarks.confidence` counts anew.
"""

import json
from bisect import bisect_right
from collections.abc import Mapping
from functools import cache
from importlib.resources import files

import numpy as np
from scipy.optimize import isotonic_regression

from topple.topology.base.arrays import FloatArray
from topple.topology.base.values import Word

EDGES: Mapping[str, tuple[float, ...]] = {
    "apart": (2.0, 4.0, 8.0, 16.0),
    "apart unseen": (0.005, 0.01, 0.02, 0.04),
    "touch": (0.25, 0.5, 0.75),
    "inside": (0.03, 0.1, 0.3),
    "carries": (0.001, 0.003, 0.006),
    "carries unseen": (0.005, 0.02),
}
"""Where the measure of a kind of evidence is cut: gaps in deviations or, of what was not seen and of what
carries, in [m]; the share of a cloud that lies inside. Other kinds have no measure."""

RISING = ("apart", "apart unseen", "inside")
"""Kinds of which a larger measure is better evidence; of the others a smaller one is."""


class Evidence(Word):
    """Kinds of evidence that are counted apart."""

    APART = "apart"
    APART_UNSEEN = "apart unseen"
    TOUCH = "touch"
    INSIDE = "inside"
    FLOATS = "floats otherwise"
    MEETS = "meets between points"
    CARRIES = "carries"
    CARRIES_UNSEEN = "carries unseen"


def confidence(evidence: Evidence, cameras: int, measure: float = 0.0) -> float:
    """How often evidence of a kind told the truth.

    Args:
        evidence: Its kind.
        cameras: How many looked; 0 where clouds are whole surfaces.
        measure: What tells strong evidence from weak, see `EDGES`.

    Returns:
        The share, 0..1.
    """
    return _counted_shares()[view_of(cameras)][evidence][bin_of(evidence, measure)]


def bin_of(evidence: Evidence, measure: float) -> int:
    """Number of the bin of a measure."""
    return bisect_right(EDGES.get(evidence, ()), measure)


def is_best(evidence: Evidence, cameras: int, measure: float) -> bool:
    """Whether evidence of a kind in `RISING` is believed no more for a greater measure: see `confidence`."""
    shares = _counted_shares()[view_of(cameras)][evidence]
    return shares[bin_of(evidence, measure)] == shares[-1]


def view_of(cameras: int) -> str:
    """Name of what was seen: whole surfaces, or by one camera or several."""
    return ("whole", "one")[cameras] if cameras < 2 else "several"


@cache
def _counted_shares() -> Mapping[str, Mapping[str, tuple[float, ...]]]:
    """Shares by view, kind and bin."""
    told = json.loads(files("topple.topology.sixim").joinpath("confidence.json").read_text(encoding="utf-8"))
    return {
        view: {kind: _shares(np.array(bins, dtype=float), kind in RISING) for kind, bins in kinds.items()}
        for view, kinds in told["counted"].items()
    }


def _shares(cases: FloatArray, rising: bool) -> tuple[float, ...]:
    # Better evidence is never believed less, and half a case of either sort is added: none is 0 or 1.
    right, total = cases[:, 0] + 0.5, cases.sum(axis=1) + 1.0
    return tuple(isotonic_regression(right / total, weights=total, increasing=rising).x.tolist())
