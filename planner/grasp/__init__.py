"""Where to take an object: candidates from its cloud, and other people's grasps ranked."""

from topple.planner.grasp.candidates import grasp_candidates
from topple.planner.grasp.grasp import Grasp
from topple.planner.grasp.hand import HandShape
from topple.robots.collision.prisms import Prism

__all__ = ["Grasp", "HandShape", "Prism", "grasp_candidates"]
