"""What to do: dependency graph, safe order, grasps, motions, plans, runs and the command line."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from topple.planner.building.build import BuildOrder, Hold, build_order
    from topple.planner.decide.arrange import Order, arrange
    from topple.planner.decide.dependency import Dependency, DependencyGraph, dependencies
    from topple.planner.errors import NoSafePlan
    from topple.planner.execution.demo import demo
    from topple.planner.execution.look import Observer
    from topple.planner.execution.loop import ClosedLoop, RunLimits
    from topple.planner.execution.run import run
    from topple.planner.formats.plan_format import Plan
    from topple.planner.grasp.foreign import ForeignGrasps, grasps_from_array, read_grasps
    from topple.planner.grasp.rank import rank_all, rank_grasps
    from topple.planner.planning.next_view import next_view
    from topple.planner.planning.order import order
    from topple.planner.planning.plan import plan
    from topple.planner.rearranging.arrangement import Arrangement
    from topple.planner.rearranging.rearrange import Rearrangement, rearrange
    from topple.planner.rearranging.task import Alike, Described, Rearranging
    from topple.planner.report.plan_page import plan_page
    from topple.planner.report.run_page import run_page

__all__ = [
    "Alike",
    "Arrangement",
    "BuildOrder",
    "ClosedLoop",
    "Dependency",
    "DependencyGraph",
    "Described",
    "ForeignGrasps",
    "Hold",
    "NoSafePlan",
    "Observer",
    "Order",
    "Plan",
    "Rearrangement",
    "Rearranging",
    "RunLimits",
    "arrange",
    "build_order",
    "demo",
    "dependencies",
    "grasps_from_array",
    "next_view",
    "order",
    "plan",
    "plan_page",
    "rank_all",
    "rank_grasps",
    "read_grasps",
    "rearrange",
    "run",
    "run_page",
]

_HOME = {
    "Alike": "rearranging.task",
    "Arrangement": "rearranging.arrangement",
    "Described": "rearranging.task",
    "Rearranging": "rearranging.task",
    "BuildOrder": "building.build",
    "Hold": "building.build",
    "build_order": "building.build",
    "ClosedLoop": "execution.loop",
    "Dependency": "decide.dependency",
    "DependencyGraph": "decide.dependency",
    "ForeignGrasps": "grasp.foreign",
    "NoSafePlan": "errors",
    "Observer": "execution.look",
    "Order": "decide.arrange",
    "Plan": "formats.plan_format",
    "Rearrangement": "rearranging.rearrange",
    "RunLimits": "execution.loop",
    "arrange": "decide.arrange",
    "demo": "execution.demo",
    "dependencies": "decide.dependency",
    "grasps_from_array": "grasp.foreign",
    "next_view": "planning.next_view",
    "order": "planning.order",
    "plan": "planning.plan",
    "plan_page": "report.plan_page",
    "rank_all": "grasp.rank",
    "rank_grasps": "grasp.rank",
    "read_grasps": "grasp.foreign",
    "rearrange": "rearranging.rearrange",
    "run": "execution.run",
    "run_page": "report.run_page",
}


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used: `topple --help` must not wait for pybullet."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
    globals()[name] = value
    return value
