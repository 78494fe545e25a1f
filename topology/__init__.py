"""Where things are and how they lie in each other: clouds, hulls, relations, contacts and support."""

from typing import TYPE_CHECKING

from topple.topology.base.public_names import lazy_names

if TYPE_CHECKING:
    from topple.topology.base.errors import InvalidInput, NotInstalled, ToppleError, UnknownObject
    from topple.topology.base.workers import WorkerLost, WorkerPool
    from topple.topology.geometry.hull import Hull
    from topple.topology.geometry.thin import thinned
    from topple.topology.io import load_scene, load_sequence
    from topple.topology.io.assemble import Parts
    from topple.topology.io.coco import scene_from_coco
    from topple.topology.io.known_models import with_models
    from topple.topology.io.mjcf import scene_from_mujoco
    from topple.topology.io.objects import scene_from_objects, scene_from_points
    from topple.topology.io.rgbd import scene_from_rgbd
    from topple.topology.io.sam import scene_from_sam
    from topple.topology.merging.merge import MergedViews, merge_views
    from topple.topology.relations.relate import Relations, relate, relate_all
    from topple.topology.scene.mesh import Mesh
    from topple.topology.scene.model_fit import ModelFit
    from topple.topology.scene.scene import Scene
    from topple.topology.situation.situation import Situation
    from topple.topology.sixim.pair import PairRelation
    from topple.topology.sixim.table import Relation, classify
    from topple.topology.views.image import DepthImage

__all__ = [
    "DepthImage",
    "Hull",
    "InvalidInput",
    "MergedViews",
    "Mesh",
    "ModelFit",
    "NotInstalled",
    "PairRelation",
    "Parts",
    "Relation",
    "Relations",
    "Scene",
    "Situation",
    "ToppleError",
    "UnknownObject",
    "WorkerLost",
    "WorkerPool",
    "classify",
    "load_scene",
    "load_sequence",
    "merge_views",
    "relate",
    "relate_all",
    "scene_from_coco",
    "scene_from_mujoco",
    "scene_from_objects",
    "scene_from_points",
    "scene_from_rgbd",
    "scene_from_sam",
    "thinned",
    "with_models",
]

__getattr__, __dir__ = lazy_names(
    __name__,
    {
        "base.errors": "InvalidInput NotInstalled ToppleError UnknownObject",
        "geometry.hull": "Hull",
        "geometry.thin": "thinned",
        "views.image": "DepthImage",
        "io": "load_scene load_sequence",
        "scene.model_fit": "ModelFit",
        "io.assemble": "Parts",
        "io.coco": "scene_from_coco",
        "io.mjcf": "scene_from_mujoco",
        "io.objects": "scene_from_objects scene_from_points",
        "io.rgbd": "scene_from_rgbd",
        "io.sam": "scene_from_sam",
        "merging.merge": "MergedViews merge_views",
        "io.known_models": "with_models",
        "sixim.pair": "PairRelation",
        "relations.relate": "Relations relate relate_all",
        "scene.mesh": "Mesh",
        "scene.scene": "Scene",
        "situation.situation": "Situation",
        "sixim.table": "Relation classify",
        "base.workers": "WorkerLost WorkerPool",
    },
)
