"""Orders by a support tree and its reverse levels, as a peer of topple's dependency graph.

After Panda, Hafez and Jawahar, "Learning support order for manipulation in clutter" (IROS 2013): each object
hangs in a tree under what supports it, from below, from the side or by containing it. Its level is how many
supports are below it, and objects are taken from the highest level down. Nothing else is asked: neither
equilibrium nor the way of a lift, and there are no groups.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import networkx as nx
import numpy as np

from topple.planner.decide.arrange import Order, arrange
from topple.planner.decide.dependency import Dependency, DependencyGraph, Reason
from topple.planner.planning.tolerances import SURE
from topple.topology.bodies.solids import up_of
from topple.topology.rule.features import support_features
from topple.topology.situation import Situation
from topple.topology.sixim.table import Relation

if TYPE_CHECKING:
    from topple.topology.scene import Scene


def support_tree(scene: "Scene | Situation", targets: Sequence[str], /, **_: Any) -> Order:
    """Order objects by the reverse levels of their support tree.

    Args:
        scene: The scene, with `up`, or the situation it was read as; its relations are not asked.
        targets: Names to free.
        **_: What other orderers take.

    Returns:
        The targets and all above them in the tree, the highest level first, of one level the highest object.
    """
    seen = Situation.of(scene).scene
    up = up_of(seen)
    heights = {name: float((cloud @ up).mean()) for name, cloud in seen.clouds.items()}
    tree: nx.DiGraph[str] = nx.DiGraph()  # from each supporter to what it supports
    tree.add_nodes_from(seen.movable)
    waits: list[Dependency] = []
    for (a, b), relation in support_features(seen).items():
        if relation is Relation.DISJOINT or {a, b} <= seen.fixed:
            continue
        if relation in (Relation.WITHIN, Relation.CONTAIN):
            upper, lower = (a, b) if relation is Relation.WITHIN else (b, a)
            reason = Reason.CONTAINED
        else:
            upper, lower = (a, b) if heights[a] > heights[b] else (b, a)
            reason = Reason.SUPPORTED
        if upper in seen.movable and lower in seen.movable:
            tree.add_edge(lower, upper)
            waits.append(Dependency(upper, lower, reason, SURE))
    tops = {name: seen.clouds[name][int(np.argmax(seen.clouds[name] @ up))] for name in seen.movable}
    found = arrange(DependencyGraph(tuple(seen.movable), tuple(waits)), targets, tops)
    if found.groups or found.unresolved:
        return found  # containment both ways: no tree, and no levels
    level: dict[str, int] = {}
    for name in nx.topological_sort(tree):
        level[name] = 1 + max((level[below] for below in tree.predecessors(name)), default=0)
    by_level = sorted(found.order, key=lambda name: (-level[name], -float(tops[name] @ up)))
    told = tuple(f"{name} is on level {level[name]} of the support tree" for name in by_level)
    return replace(found, order=tuple(by_level), explanation=told)
