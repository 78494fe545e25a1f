"""Plans handed on: to task planners, behaviour trees, MoveIt, and graph viewers."""

from collections.abc import Callable

from topple.planner.export.behavior_tree import behavior_tree
from topple.planner.export.graph import dot, graphml
from topple.planner.export.moveit import moveit_scene
from topple.planner.export.pddl import pddl
from topple.planner.planning.plan_format import Plan
from topple.topology.base.plugins import Table

EXPORTERS: Table[Callable[[Plan], str | bytes]] = Table(
    "topple.exporters",
    "format",
    {
        "dot": "topple.planner.export.graph:dot",
        "graphml": "topple.planner.export.graph:graphml",
        "pddl": "topple.planner.export.pddl:pddl",
        "bt": "topple.planner.export.behavior_tree:behavior_tree",
        "moveit": "topple.planner.export.moveit:moveit_scene",
        "ros2": "topple.planner.export.ros2:recording",
    },
)
"""By name: a plan to what is written in a file, text or bytes; other packages add theirs."""


def export(plan: Plan, to: str) -> str | bytes:
    """Write a plan in another program's format.

    Args:
        plan: The plan.
        to: One of the names in `EXPORTERS`.

    Returns:
        The text of the file, or its bytes where the format is no text; for pddl the domain and, after a
        line `;; problem`, the problem.

    Raises:
        InvalidInput: There is no such format; the message lists those there are.
    """
    return EXPORTERS[to](plan)


__all__ = ["EXPORTERS", "behavior_tree", "dot", "export", "graphml", "moveit_scene", "pddl"]
