"""What to do: dependency graph, safe order, grasps, motions, plans, runs and the command line."""

from typing import TYPE_CHECKING

from topple.topology.base.public_names import lazy_names

if TYPE_CHECKING:
    from topple.planner.building.build import BuildOrder, build_order
    from topple.planner.decide.arrange import Order, arrange
    from topple.planner.decide.dependency import Dependency, DependencyGraph, dependencies
    from topple.planner.decide.hold import Hold
    from topple.planner.errors import NoSafePlan
    from topple.planner.execution.demo import demo
    from topple.planner.execution.look import Look, Observer, Perception
    from topple.planner.execution.loop import ClosedLoop
    from topple.planner.execution.run import run
    from topple.planner.execution.selection import RunLimits
    from topple.planner.formats.run_record import RunRecord
    from topple.planner.grasp.foreign import ForeignGrasps, grasps_from_array, read_grasps
    from topple.planner.grasp.rank import rank_all, rank_grasps
    from topple.planner.planning.next_view import next_view
    from topple.planner.planning.order import order, order_all
    from topple.planner.planning.plan import plan, plan_all
    from topple.planner.planning.plan_format import Plan
    from topple.planner.planning.two_handed import plan_two_handed
    from topple.planner.rearranging.arrangement import Arrangement
    from topple.planner.rearranging.rearrange import Rearrangement, rearrange
    from topple.planner.rearranging.task import ArrangementTask, DescribedTask, RelatedTask, SameShapesTask
    from topple.planner.report.check_page import check_page
    from topple.planner.report.plan_page import plan_page
    from topple.planner.report.run_page import run_page
    from topple.planner.report.show import show_page
    from topple.planner.stability.check import ObjectCheck, StabilityCheck, check

__all__ = [
    "Arrangement",
    "ArrangementTask",
    "BuildOrder",
    "ClosedLoop",
    "Dependency",
    "DependencyGraph",
    "DescribedTask",
    "ForeignGrasps",
    "Hold",
    "Look",
    "NoSafePlan",
    "ObjectCheck",
    "Observer",
    "Order",
    "Perception",
    "Plan",
    "Rearrangement",
    "RelatedTask",
    "RunLimits",
    "RunRecord",
    "SameShapesTask",
    "StabilityCheck",
    "arrange",
    "build_order",
    "check",
    "check_page",
    "demo",
    "dependencies",
    "grasps_from_array",
    "next_view",
    "order",
    "order_all",
    "plan",
    "plan_all",
    "plan_page",
    "plan_two_handed",
    "rank_all",
    "rank_grasps",
    "read_grasps",
    "rearrange",
    "run",
    "run_page",
    "show_page",
]

__getattr__, __dir__ = lazy_names(
    __name__,
    {
        "building.build": "BuildOrder build_order",
        "stability.check": "ObjectCheck StabilityCheck check",
        "decide.arrange": "Order arrange",
        "decide.dependency": "Dependency DependencyGraph dependencies",
        "decide.hold": "Hold",
        "errors": "NoSafePlan",
        "execution.demo": "demo",
        "execution.look": "Look Observer Perception",
        "execution.loop": "ClosedLoop",
        "execution.selection": "RunLimits",
        "execution.run": "run",
        "planning.plan_format": "Plan",
        "formats.run_record": "RunRecord",
        "grasp.foreign": "ForeignGrasps grasps_from_array read_grasps",
        "grasp.rank": "rank_all rank_grasps",
        "planning.next_view": "next_view",
        "planning.order": "order order_all",
        "planning.plan": "plan plan_all",
        "planning.two_handed": "plan_two_handed",
        "rearranging.arrangement": "Arrangement",
        "rearranging.rearrange": "Rearrangement rearrange",
        "rearranging.task": "SameShapesTask DescribedTask ArrangementTask RelatedTask",
        "report.plan_page": "plan_page",
        "report.check_page": "check_page",
        "report.run_page": "run_page",
        "report.show": "show_page",
    },
)
