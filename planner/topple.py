"""The front door: this file is installed as `topple/__init__.py`, above the three packages.

`import topple` then gives the calls that most programs need: `topple.order(topple.load_scene("scene.npz"))`.
Each is imported when it is first used, so that neither `import topple` nor `topple --help` waits for numpy.
Where Gymnasium was imported before, its environments are there as well: `gymnasium.make("topple/Pile-v0")`.
"""

from importlib import import_module
from importlib.metadata import version
from sys import modules
from typing import TYPE_CHECKING, Any

from topple.topology.base.public_names import lazy_names

if TYPE_CHECKING:
    from topple.planner import (
        NoSafePlan,
        Order,
        Plan,
        RunRecord,
        StabilityCheck,
        build_order,
        check,
        next_view,
        order,
        plan,
        rank_grasps,
        rearrange,
        run,
    )
    from topple.robots import robot, scene_from_world
    from topple.topology import (
        InvalidInput,
        Relations,
        Scene,
        ToppleError,
        load_scene,
        relate,
        scene_from_rgbd,
    )

    __version__: str

__all__ = [
    "InvalidInput",
    "NoSafePlan",
    "Order",
    "Plan",
    "Relations",
    "RunRecord",
    "Scene",
    "StabilityCheck",
    "ToppleError",
    "__version__",
    "build_order",
    "check",
    "load_scene",
    "next_view",
    "order",
    "plan",
    "rank_grasps",
    "rearrange",
    "relate",
    "robot",
    "run",
    "scene_from_rgbd",
    "scene_from_world",
]

_find, __dir__ = lazy_names(
    __name__,
    {
        "topology": "InvalidInput Relations Scene ToppleError load_scene relate scene_from_rgbd",
        "robots": "robot scene_from_world",
        "planner": "NoSafePlan Order Plan RunRecord StabilityCheck build_order check next_view order plan "
        "rank_grasps "
        "rearrange run",
    },
)


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used."""
    if name == "__version__":
        from topple.topology.base.errors import DISTRIBUTION

        return version(DISTRIBUTION)
    return _find(name)


if "gymnasium" in modules:  # it has no entry points since 1.0: packages of environments register as they load
    import_module("topple.planner.environment")
