"""What a policy sees: objects, relations and the dependency graph as arrays, a slot per object."""

from collections.abc import Collection, Mapping, Sequence
from typing import Any

import gymnasium
import numpy as np

from topple.planner.decide.dependency import dependencies
from topple.planner.environment.tolerances import FARTHEST
from topple.topology.base.arrays import bounds
from topple.topology.situation.situation import Situation
from topple.topology.sixim.table import Relation

Observation = dict[str, Any]  # of arrays


def space_of(slots: int, points: int) -> gymnasium.spaces.Dict:
    """The space of observations.

    Args:
        slots: How many objects there may be.
        points: How many points of each cloud are shown; 0 for none.

    Returns:
        `objects` (slots, 6): centre and size of the cloud's box [m]; `target` and `action_mask` (slots,);
        `relations` (slots, slots, 7): which of the seven, in the order of `Relation`, row to column, no one
        for an object that is not seen; `graph` (slots, slots): how sure it is that the row has to go before
        the column; perhaps `clouds` (slots, points, 3) [m].
    """
    box, bits = gymnasium.spaces.Box, gymnasium.spaces.MultiBinary
    spaces: dict[str, gymnasium.Space[Any]] = {
        "objects": box(-FARTHEST, FARTHEST, (slots, 6), np.float32),
        "target": bits(slots),
        "relations": bits((slots, slots, len(Relation))),
        "graph": box(0.0, 1.0, (slots, slots), np.float32),
        "action_mask": bits(slots),
    }
    if points:
        spaces["clouds"] = box(-FARTHEST, FARTHEST, (slots, points, 3), np.float32)
    return gymnasium.spaces.Dict(spaces)


def show(
    situation: Situation | None,
    names: Sequence[str],
    targets: Collection[str],
    takeable: Mapping[str, bool],
    slots: int,
    points: int,
    rng: np.random.Generator,
) -> Observation:
    """Show a situation.

    Args:
        situation: What is seen; None where nothing is left.
        names: The object of each slot, seen or not.
        targets: What the goal is about.
        takeable: Whether each may be taken.
        slots: As in `space_of`.
        points: As in `space_of`.
        rng: Which points are shown.

    Returns:
        An element of the space.
    """
    shown: Observation = {
        "objects": np.zeros((slots, 6), np.float32),
        "target": np.array([name in targets for name in names] + [False] * (slots - len(names)), np.int8),
        "relations": np.zeros((slots, slots, len(Relation)), np.int8),
        "graph": np.zeros((slots, slots), np.float32),
        "action_mask": np.zeros(slots, np.int8),
    }
    if points:
        shown["clouds"] = np.zeros((slots, points, 3), np.float32)
    if situation is None:
        return shown
    clouds = situation.scene.clouds
    slot = {name: row for row, name in enumerate(names) if name in clouds}
    for name, row in slot.items():
        lower, upper = bounds(clouds[name])
        shown["objects"][row] = np.clip([*(lower + upper) / 2, *(upper - lower)], -FARTHEST, FARTHEST)
        shown["action_mask"][row] = takeable[name]
        if points:
            shown["clouds"][row] = np.clip(rng.choice(clouds[name], points), -FARTHEST, FARTHEST)
    number = {relation: index for index, relation in enumerate(Relation)}
    for pair in situation.relations:
        if pair.a in slot and pair.b in slot:
            a, b = slot[pair.a], slot[pair.b]
            shown["relations"][a, b, number[pair.relation]] = 1
            shown["relations"][b, a, number[pair.converse.relation]] = 1
    for edge in dependencies(situation, direct=False).dependencies:
        shown["graph"][slot[edge.first], slot[edge.then]] = edge.confidence
    return shown
