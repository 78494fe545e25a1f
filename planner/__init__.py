"""What to do: dependency graph, safe order, grasps, motions, plans, runs and the command line."""

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from topple.planner.dependency import Dependency, DependencyGraph, dependencies
    from topple.planner.errors import NoSafePlan
    from topple.planner.grasp.rank import rank_grasps
    from topple.planner.order import Order, order
    from topple.planner.plan import plan
    from topple.planner.run import run

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


class _Package(ModuleType):
    """A package in which `order`, `plan` and `run` stay functions after their modules were imported."""

    def __setattr__(self, name: str, value: object) -> None:
        if not (name in _HOME and isinstance(value, ModuleType)):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package
