from itertools import pairwise

from topple.planner import Dependency, DependencyGraph, arrange


def highest(situation, targets, **_):  # whatever is higher goes first
    tops = {name: max(situation.scene.clouds[name], key=lambda p: p[2]) for name in situation.movable}
    by_height = sorted(tops, key=lambda name: -tops[name][2])
    waits = [Dependency(a, b, "blocking", 0.5) for a, b in pairwise(by_height)]
    return arrange(DependencyGraph(tuple(tops), tuple(waits)), targets, tops)
