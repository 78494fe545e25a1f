"""Ask whether a scene stands before it is used: a mug that a generator put too near a book's edge.

python examples/check.py
"""

from pathlib import Path

import numpy as np

import topple
from topple.planner import check_page
from topple.testing import assert_stands
from topple.topology import Mesh

CUBE = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
SIDES = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
FACES = np.concatenate([SIDES[:, [0, 1, 2]], SIDES[:, [0, 2, 3]]])


def block(size: tuple[float, float, float], middle: tuple[float, float, float]) -> Mesh:
    """A box as a mesh, from its edges and its middle in metres."""
    return Mesh(CUBE * size + np.array(middle), FACES)


def main() -> None:
    """Check two scenes, and print what holds the one that stands."""
    for offset in (0.104, 0.080):
        meshes = {
            "table": block((1.0, 1.0, 0.04), (0.0, 0.0, -0.02)),
            "book": block((0.2, 0.15, 0.03), (0.0, 0.0, 0.015)),
            "mug": block((0.08, 0.08, 0.1), (offset, 0.0, 0.08)),
        }
        clouds = {name: mesh.vertices for name, mesh in meshes.items()}
        scene = topple.Scene(clouds, fixed=["table"], up=(0, 0, 1), meshes=meshes)
        found = topple.check(scene)
        print(found.sentence())
    for name, each in found.objects.items():
        if each.margins is not None:
            print(
                f"{name}: its weight may be {1e3 * each.margins.centre:.0f} mm aside, the table tilted by "
                f"{np.degrees(each.margins.tilt):.1f} degrees, or {each.margins.push:.2f} N pushed at its top"
            )
    assert_stands(scene)
    Path("check.html").write_text(check_page(scene, found.to_json(), "A mug on a book"), encoding="utf-8")


if __name__ == "__main__":
    main()
