"""Orders by a support tree and its reverse levels, as a peer of topple's dependency graph.

After Panda, Hafez and Jawahar, "Learning support order for manipulation in clutter" (IROS 2013): each object
hangs in a tree under what supports it, from below, from the side or by containing it. Its level is how many
supports are below it, and objects are taken from the highest level down. Nothing else is asked: neither
equilibrium nor the way of a lift, and there are no groups.
"""

import networkx as nx

from topple.benchmarks.contrasts.features import support_features
from topple.topology.bodies.solids import up_of
from topple.topology.scene.scene import Scene
from topple.topology.sixim.table import Relation


def support_tree(scene: Scene) -> tuple[frozenset[tuple[str, str]], tuple[str, ...]]:
    """Order objects by the reverse levels of their support tree.

    Args:
        scene: The scene, with `up`.

    Returns:
        (upper, lower) of what hangs in the tree; all objects, the highest level first, of one level the
        highest one.
    """
    up = up_of(scene)
    heights = {name: float((cloud @ up).mean()) for name, cloud in scene.clouds.items()}
    tree: nx.DiGraph[str] = nx.DiGraph()  # from what is above to what carries it
    tree.add_nodes_from(scene.movable)
    for (a, b), relation in support_features(scene).items():
        if relation is Relation.DISJOINT or not {a, b} <= set(scene.movable):
            continue
        inner = {Relation.WITHIN: a, Relation.CONTAIN: b}.get(relation, max(a, b, key=heights.__getitem__))
        tree.add_edge(inner, b if inner == a else a)
    tops = {name: float((scene.clouds[name] @ up).max()) for name in scene.movable}
    rings = [ring for ring in nx.strongly_connected_components(tree) if len(ring) > 1]
    level = dict.fromkeys(tree, 0)
    if not rings:  # else containment both ways: no tree, and no levels
        for name in reversed(list(nx.topological_sort(tree))):
            level[name] = 1 + max((level[below] for below in tree.successors(name)), default=0)
    order = sorted(scene.movable, key=lambda name: (-level[name], -tops[name]))
    return frozenset(tree.edges), tuple(order)
