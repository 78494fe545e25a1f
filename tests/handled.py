"""A stand-in for a transfer, with what the judge of a run asks about it."""

import numpy as np

from topple.planner.placement.placement import Placement


class Handled:
    """A transfer of one object, in which nothing rides, to where it is already."""

    def __init__(self, name: str) -> None:
        self.object = name
        self.riding = ()
        self.placement = Placement(np.eye(4), 1.0)
