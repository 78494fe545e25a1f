import numpy as np

from topple.topology import PairRelation, Relation
from topple.topology.relations.relate import box_distance
from topple.topology.sixim.fast.rule import PlainRule


class Boxes(PlainRule):
    def relate(self, a, b):  # of two clouds, prepared once: name, lower, upper, columns (3, N)
        gap = box_distance(a, b)
        met = Relation.TOUCH if gap <= self.deviation else Relation.DISJOINT
        return PairRelation(a.name, b.name, met, counts=np.zeros((2, 3), int), distance=gap)


def boxes(scene, deviation):  # [m], None where it is not given
    return Boxes(deviation or 0.002)
