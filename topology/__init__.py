"""Where things are and how they lie in each other: clouds, hulls, relations, contacts and support."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from topple.topology.errors import InvalidInput, NotInstalled, ToppleError, UnknownObject
    from topple.topology.geometry.hull import Hull
    from topple.topology.geometry.thin import thinned
    from topple.topology.image import DepthImage
    from topple.topology.io import load_scene, load_sequence
    from topple.topology.io.assemble import Parts
    from topple.topology.io.coco import scene_from_coco
    from topple.topology.io.objects import scene_from_objects, scene_from_points
    from topple.topology.merging.merge import MergedViews, merge_views
    from topple.topology.pair import PairRelation
    from topple.topology.relations import Relations
    from topple.topology.rule.relate import relate, relate_all
    from topple.topology.scene import Mesh, Scene
    from topple.topology.sixim.table import Relation, classify

__all__ = [
    "DepthImage",
    "Hull",
    "InvalidInput",
    "MergedViews",
    "Mesh",
    "NotInstalled",
    "PairRelation",
    "Parts",
    "Relation",
    "Relations",
    "Scene",
    "ToppleError",
    "UnknownObject",
    "classify",
    "load_scene",
    "load_sequence",
    "merge_views",
    "relate",
    "relate_all",
    "scene_from_coco",
    "scene_from_objects",
    "scene_from_points",
    "thinned",
]

_HOME = {
    "DepthImage": "image",
    "Hull": "geometry.hull",
    "InvalidInput": "errors",
    "MergedViews": "merging.merge",
    "Mesh": "scene",
    "NotInstalled": "errors",
    "PairRelation": "pair",
    "Parts": "io.assemble",
    "Relation": "sixim.table",
    "Relations": "relations",
    "Scene": "scene",
    "ToppleError": "errors",
    "UnknownObject": "errors",
    "classify": "sixim.table",
    "load_scene": "io",
    "load_sequence": "io",
    "merge_views": "merging.merge",
    "relate": "rule.relate",
    "relate_all": "rule.relate",
    "scene_from_coco": "io.coco",
    "scene_from_objects": "io.objects",
    "scene_from_points": "io.objects",
    "thinned": "geometry.thin",
}


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used: `topple --help` must not wait for scipy."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
    globals()[name] = value
    return value
