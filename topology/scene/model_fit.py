"""How a known model was laid onto what was seen of an object."""

from dataclasses import dataclass, replace
from typing import Any

from topple.topology.base.arguments import checked_arguments
from topple.topology.base.arrays import FloatArray, freeze
from topple.topology.base.values import ByValue
from topple.topology.geometry.rigid import move_points


@checked_arguments
@dataclass(frozen=True, eq=False)
class ModelFit(ByValue):
    """How a known model was laid onto what was seen of an object.

    Attributes:
        model: Its name.
        pose_model_to_world: (4, 4).
        residual: Root mean square distance of the seen points from the model's surface [m], without the
            farthest tenth, which fly at outlines.
        inliers: Share of the seen points within 3 mm of the model's surface.
        visible: Share of the model's surface within 8 mm of a seen point: of thin things both sides.
        seen_through: Of the model's points that were seen or looked through, the share of the latter.
        ambiguity: How far from here another pose that fits as well would put the surface, but for its ends
            [m]; 0 where there is none.
        seen: (N, 3) the points that were seen [m].
        refused: Why the object keeps them for its cloud; None where the model's surface takes their place.

    Examples:
        >>> import pathlib, trimesh
        >>> pathlib.Path("models").mkdir()
        >>> _ = trimesh.creation.box((0.06, 0.06, 0.08)).export("models/cup.obj")
        >>> fit = with_models(scene, "models").models["cup"]
        >>> fit.residual < 0.002, fit.visible > 0.9
        (True, True)
    """

    model: str
    pose_model_to_world: FloatArray
    residual: float
    inliers: float
    visible: float
    seen_through: float
    ambiguity: float
    seen: FloatArray
    refused: str | None = None

    def __post_init__(self) -> None:
        """Make the arrays read-only."""
        object.__setattr__(self, "pose_model_to_world", freeze(self.pose_model_to_world))
        object.__setattr__(self, "seen", freeze(self.seen))

    def moved(self, pose: FloatArray) -> "ModelFit":
        """The fit in another frame, (4, 4) from the world into it."""
        there = pose @ self.pose_model_to_world
        return replace(self, pose_model_to_world=there, seen=move_points(self.seen, pose))

    def to_json(self) -> dict[str, Any]:
        """Its entry in a document."""
        return {
            "model": self.model,
            "registered": self.refused is None,
            "why": self.refused,
            "residual": self.residual,
            "inliers": self.inliers,
            "visible": self.visible,
            "seen_through": self.seen_through,
            "ambiguity": self.ambiguity,
            "pose_model_to_world": self.pose_model_to_world.tolist(),
        }
