"""Triangle meshes of objects."""

from dataclasses import dataclass

import numpy as np

from topple.topology.base.arrays import FloatArray, IntArray, frozen_int
from topple.topology.base.checks import as_points
from topple.topology.base.errors import InvalidInput
from topple.topology.base.values import ByValue


@dataclass(frozen=True, eq=False)
class Mesh(ByValue):
    """A triangle mesh in world coordinates.

    Attributes:
        vertices: Vertices (V, 3) in [m].
        faces: Triangles (F, 3), indices into the vertices.

    Raises:
        InvalidInput: If the shapes are wrong, a vertex is not finite, or a face names no vertex.

    Examples:
        >>> Mesh(corners, [[0, 1, 3]]).faces
        array([[0, 1, 3]])
    """

    vertices: FloatArray
    faces: IntArray

    def __post_init__(self) -> None:
        """Check both arrays and make them read-only."""
        vertices = as_points(self.vertices, "mesh vertices")
        faces = np.asarray(self.faces)
        if faces.ndim != 2 or faces.shape[1] != 3 or faces.dtype.kind not in "iu":
            raise InvalidInput(
                f"mesh faces have shape {faces.shape} of {faces.dtype}: expected (F, 3) integers"
            )
        if faces.size and (faces.min() < 0 or faces.max() >= len(vertices)):
            raise InvalidInput(
                f"mesh faces name vertex {faces.max()} where there are {len(vertices)} vertices"
            )
        object.__setattr__(self, "vertices", vertices)
        object.__setattr__(self, "faces", frozen_int(faces))
