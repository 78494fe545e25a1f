"""What a grasp's score is made of: terms in 0..1 that multiply, and the chance that its weight is held."""

from collections.abc import Mapping

import numpy as np

from topple.planner.grasp.grasp import GraspKind

WEIGHTS = {"antipodality": 0.3, "balance": 0.3, "clearance": 0.15, "depth": 0.15, "upright": 0.1}
"""Exponents of a pinch's terms: one that is nil spoils the grasp alone."""

HOLD = "hold"
"""The term that says how surely the weight is held."""


def score_of(kind: GraspKind, terms: Mapping[str, float]) -> float:
    """Put the terms of a grasp together.

    Args:
        kind: How it takes hold.
        terms: As `topple.planner.grasp.grasp.Grasp.terms` has them.

    Returns:
        The score, 0..1.
    """
    held = terms.get(HOLD, 1.0)
    if kind == GraspKind.SUCTION:  # a leak or a long lever spoils it alone
        ease = (0.5 + 0.5 * terms["upright"]) * (0.8 + 0.2 * terms["clearance"])
        return terms["seal"] * terms["balance"] * ease * held
    return float(np.prod([terms[name] ** weight for name, weight in WEIGHTS.items()])) * held
