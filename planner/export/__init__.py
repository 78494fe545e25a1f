"""Plans handed on: to task planners, behaviour trees, MoveIt, and graph viewers."""

from collections.abc import Callable, Mapping

from topple.planner.export.behavior_tree import behavior_tree
from topple.planner.export.graph import dot, graphml
from topple.planner.export.moveit import moveit_scene
from topple.planner.export.pddl import pddl
from topple.planner.formats.plan_format import Plan, plan_to_json
from topple.topology.errors import InvalidInput
from topple.topology.values import FrozenDict

EXPORTERS: Mapping[str, Callable[[Plan], str]] = FrozenDict(
    {
        "json": lambda plan: plan_to_json(plan).decode("utf-8"),
        "dot": dot,
        "graphml": graphml,
        "pddl": pddl,
        "bt": behavior_tree,
        "moveit": moveit_scene,
    }
)
"""By name: a plan to the text of a file."""


def export(plan: Plan, to: str) -> str:
    """Write a plan in another program's format.

    Args:
        plan: The plan.
        to: One of the keys of `EXPORTERS`.

    Returns:
        The text of the file; for pddl the domain and, after a line `;; problem`, the problem.

    Raises:
        InvalidInput: There is no such format; the message lists those there are.
    """
    if to not in EXPORTERS:
        raise InvalidInput(f"cannot export to {to!r}: expected {', '.join(EXPORTERS)}")
    return EXPORTERS[to](plan)


__all__ = ["EXPORTERS", "behavior_tree", "dot", "export", "graphml", "moveit_scene", "pddl"]
