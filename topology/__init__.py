"""Where things are and how they lie in each other: clouds, hulls, relations, contacts and support."""

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from topple.topology.errors import InvalidInput, ToppleError, UnknownObject
    from topple.topology.hull import Hull
    from topple.topology.image import DepthImage
    from topple.topology.io import load_scene, load_sequence
    from topple.topology.pairs import PairRelation, Relations
    from topple.topology.relate import relate, relate_all
    from topple.topology.relation import Relation, classify
    from topple.topology.scene import Mesh, Scene

__all__ = [
    "DepthImage",
    "Hull",
    "InvalidInput",
    "Mesh",
    "PairRelation",
    "Relation",
    "Relations",
    "Scene",
    "ToppleError",
    "UnknownObject",
    "classify",
    "load_scene",
    "load_sequence",
    "relate",
    "relate_all",
]

_MODULE_OF = {
    "DepthImage": "image",
    "Hull": "hull",
    "InvalidInput": "errors",
    "Mesh": "scene",
    "PairRelation": "pairs",
    "Relation": "relation",
    "Relations": "pairs",
    "Scene": "scene",
    "ToppleError": "errors",
    "UnknownObject": "errors",
    "classify": "relation",
    "load_scene": "io",
    "load_sequence": "io",
    "relate": "relate",
    "relate_all": "relate",
}


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used: `topple --help` must not wait for scipy."""
    if name not in _MODULE_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"{__name__}.{_MODULE_OF[name]}"), name)
    globals()[name] = value
    return value


class _Package(ModuleType):
    """A package in which `relate` stays the function after its module `relate` was imported."""

    def __setattr__(self, name: str, value: object) -> None:
        if not (name in _MODULE_OF and isinstance(value, ModuleType)):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package
