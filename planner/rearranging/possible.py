"""Whether a finished arrangement can be one: bodies are not in each other, and rest on something."""

import numpy as np

from topple.planner.rearranging.tolerances import DEEP, DEEP_SHARE
from topple.topology.base.errors import InvalidInput
from topple.topology.geometry.sides import beyond, sides_of
from topple.topology.situation.situation import Situation
from topple.topology.sixim.table import Relation


def check_possible(goal: Situation) -> None:
    """Refuse an arrangement that no bodies can have.

    Args:
        goal: How things shall lie.

    Raises:
        InvalidInput: A thing hangs in the air, or two are in each other: which, and where.
    """
    touched = {name for contact in goal.statics.contacts for name in (contact.a, contact.b)}
    for name in goal.movable:
        if name not in touched and goal.scene.fixed:
            low = float((goal.scene.clouds[name] @ goal.up).min())
            raise InvalidInput(
                f"{name} hangs in the air in the goal, its lowest point at {low:.3f} m along up: "
                "expected something below it that it touches"
            )
    if goal.statics.sight is not None:
        return  # from cameras hulls are guessed, and may well overlap
    for pair in goal.relations.near.values():
        if pair.relation is Relation.CROSS and {pair.a, pair.b} <= set(goal.movable):
            if (depth := max(_depth(pair.a, pair.b, goal), _depth(pair.b, pair.a, goal))) > DEEP:
                raise InvalidInput(
                    f"{pair.a} and {pair.b} are in each other in the goal, by {100 * depth:.0f} cm: "
                    "expected an arrangement in which they only touch"
                )


def _depth(inner: str, outer: str, goal: Situation) -> float:
    """How deep [m] a share of the points of one cloud is in the convex parts of another body."""
    cloud, deep = goal.scene.clouds[inner], 0.0
    for part in goal.solids[outer]:
        if (sides := sides_of(part)) is not None:
            deep = max(deep, -float(np.quantile(beyond(sides, cloud), DEEP_SHARE)))
    return deep
