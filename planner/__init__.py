"""What to do: dependency graph, safe order, grasps, motions, plans, runs and the command line."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from topple.planner.dependency import Dependency, DependencyGraph, dependencies
    from topple.planner.errors import NoSafePlan
    from topple.planner.grasp.rank import rank_grasps
    from topple.planner.order import Order, order
    from topple.planner.plan import plan

__all__ = [
    "Dependency",
    "DependencyGraph",
    "NoSafePlan",
    "Order",
    "dependencies",
    "order",
    "plan",
    "rank_grasps",
    "run",
]

_HOME = {
    "Dependency": "dependency",
    "DependencyGraph": "dependency",
    "NoSafePlan": "errors",
    "Order": "order",
    "dependencies": "dependency",
    "order": "order",
    "plan": "plan",
    "rank_grasps": "grasp.rank",
    "run": "run",
}


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used: `topple --help` must not wait for pybullet."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"topple.planner.{_HOME[name]}"), name)
    globals()[name] = value
    return value
