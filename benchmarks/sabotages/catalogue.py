"""Ways to spoil a plan: each changes its document, or the scene it is checked with, and is to be noticed."""

from inspect import isfunction
from types import FunctionType, ModuleType

from topple.benchmarks.sabotages import (
    actions,
    carried,
    grasps,
    hand,
    motions,
    orders,
    places,
    premises,
    scenes,
    unreadable,
)


def _all_of(*modules: ModuleType) -> tuple[FunctionType, ...]:
    return tuple(
        found
        for module in modules
        for found in vars(module).values()
        if isfunction(found) and found.__module__ == module.__name__
    )


SPOILT = _all_of(actions, hand, grasps, places, carried, motions, orders, premises)
"""What verification has to refute."""
UNREADABLE = _all_of(unreadable)
"""What reading has to refuse by path."""
OTHER_SCENES = _all_of(scenes)
