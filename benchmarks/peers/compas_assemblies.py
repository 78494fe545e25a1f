"""Write the sample assemblies of compas-cra as meshes, and what rigid block equilibrium says of removals.

Runs in an environment of its own, with compas-cra 0.8; `topple bench assemblies` says how. An assembly
becomes `NAME.json`: blocks, volumes and centres, which are fixed, and whether the rest is in equilibrium
without anything, and without each block that is not fixed.
"""

import contextlib
import io
import json
import sys
import time
from importlib import import_module
from itertools import pairwise
from pathlib import Path
from typing import Any

FRICTION = {"shelf": 0.9, "bridge": 0.9, "snake": 0.7}
"""By the beginning of a name; all else as compas-cra assumes."""
USUAL = 0.84
FIXED = {"type-b": (0, 1), "A": (0, 1), "H": (0, 1), "bridge": (0, 1)}
"""Blocks that are fixed where a file does not say; the first alone in all others."""
AREA, FLAT = 1e-6, 1e-4
"""[m2] least face that two blocks share, and [m] how far it may be from flat."""
TENSION = 1e-3
"""Of the mean weight of a block: more pull than that between two faces is no equilibrium."""
REMOVALS = 24
"""Of a larger assembly so many removals, evenly, since each takes the peer 5 s."""
UNFIXED = {"armadillo"}
"""Of this one nothing says what is fixed; `armadillo_cra` holds the same blocks, and does."""


def prepared(path: Path) -> Any:
    """The assembly of a file, with its interfaces and what is fixed."""
    kind = import_module("compas_cra.datastructures").CRA_Assembly
    found = import_module("compas").json_load(str(path)).copy(cls=kind)
    if not found.graph.number_of_edges():
        faces = import_module("compas_cra.algorithms").assembly_interfaces_numpy
        faces(found, nmax=len(list(found.nodes())), amin=AREA, tmax=FLAT)
    if not fixed(found):
        found.set_boundary_conditions(FIXED.get(path.stem, (0,)))
    return found


def fixed(assembly: Any) -> list[int]:
    """The blocks that nothing moves."""
    return [node for node in assembly.nodes() if assembly.graph.node_attribute(node, "is_support")]


def hangs(assembly: Any) -> bool:
    """Whether a block touches nothing that leads to what is fixed."""
    reached, queue = set(fixed(assembly)), fixed(assembly)
    while queue:
        for other in assembly.graph.neighbors(queue.pop()):
            if other not in reached:
                reached.add(other)
                queue.append(other)
    return len(reached) < len(list(assembly.nodes()))


def stands(assembly: Any, friction: float) -> bool | None:
    """Whether pushes and friction alone balance all weights; None where the solver does not say.

    It minimises pulls that it adds, so that an answer without any is an equilibrium.
    """
    if hangs(assembly):
        return False
    free = [assembly.node_block(n).volume() for n in assembly.nodes() if n not in fixed(assembly)]
    if not free:
        return True
    try:
        with contextlib.redirect_stdout(io.StringIO()):
            import_module("compas_cra.equilibrium").rbe_solve(assembly, mu=friction)
    except ValueError:
        return None
    pulls = [
        force["c_nn"]
        for edge in assembly.graph.edges()
        for interface in assembly.graph.edge_attribute(edge, "interfaces")
        for force in interface.forces
    ]
    return max(pulls, default=0.0) < TENSION * sum(free) / len(free)


def triangles(block: Any) -> tuple[list[list[float]], list[list[int]]]:
    """Vertices and triangles of a block."""
    geometry = import_module("compas.geometry")
    keys = list(block.vertices())
    index = {key: number for number, key in enumerate(keys)}
    faces: list[list[int]] = []
    for face in block.faces():
        corners = [index[key] for key in block.face_vertices(face)]
        if len(corners) <= 4:
            faces += [[corners[0], *pair] for pair in pairwise(corners[1:])]
        else:
            polygon = geometry.Polygon(block.face_coordinates(face))
            faces += [[corners[k] for k in triangle] for triangle in geometry.earclip_polygon(polygon)]
    return [list(map(float, block.vertex_coordinates(key))) for key in keys], faces


def described(assembly: Any, friction: float) -> dict[str, Any]:
    """What `topple bench assemblies` reads of an assembly."""
    blocks: dict[str, Any] = {}
    for node in assembly.nodes():
        block = assembly.node_block(node)
        vertices, faces = triangles(block)
        blocks[f"b{node}"] = {
            "vertices": vertices, "faces": faces,
            "volume": abs(block.volume()), "centre": list(block.center()),
        }  # fmt: skip
    free = [node for node in assembly.nodes() if node not in fixed(assembly)]
    some = free if len(free) <= REMOVALS else free[:: len(free) // REMOVALS + 1]
    begun = time.process_time()
    whole = stands(assembly.copy(), friction)
    taken: dict[str, float] = {"whole": time.process_time() - begun}
    without: dict[str, bool | None] = {}
    begun = time.process_time()
    for node in some:
        rest = assembly.copy()
        rest.delete_blocks([node])
        without[f"b{node}"] = stands(rest, friction)
    taken["removal"] = (time.process_time() - begun) / max(len(some), 1)
    return {
        "friction": friction, "fixed": [f"b{node}" for node in fixed(assembly)], "blocks": blocks,
        "stands": whole, "without": without, "seconds": taken,
    }  # fmt: skip


def write(folder: Path, names: list[str]) -> None:
    """Write a file for each sample."""
    samples = Path(str(import_module("compas_cra").__file__)).parent / "data" / "samples"
    folder.mkdir(parents=True, exist_ok=True)
    for path in sorted(samples.glob("*.json")):
        if path.stem in UNFIXED or (names and path.stem not in names):
            continue
        friction = FRICTION.get(path.stem.split("-")[0], USUAL)
        document = described(prepared(path), friction)
        (folder / path.name).write_text(json.dumps(document))
        sys.stdout.write(f"{path.stem}: {document['stands']}\n")


if __name__ == "__main__":
    write(Path(sys.argv[1]), sys.argv[2:])
