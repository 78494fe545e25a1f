"""Bodies as they stand and fall: what was seen of them, with the sides that no camera saw guessed.

What is kept clear of is what was seen. How a thing stands is another question: what one camera saw of it is a
shell, and the open side of that looks like the best face of all. Placements, their simulated release and the
check of a plan all ask the same body.
"""

import numpy as np

from topple.planner.solids import Solids, hull_vertices
from topple.topology.scene import Scene
from topple.topology.statics import Statics


def whole_bodies(scene: Scene, solids: Solids, statics: Statics | None = None) -> Solids:
    """Complete the bodies of a scene.

    Args:
        scene: The scene, with `up`.
        solids: Convex parts of its objects, as far as they are known.
        statics: The scene at rest where it has been worked out before.

    Returns:
        For each movable object one convex part around what is known and what is guessed; what is known alone
        where nobody says from where the scene was seen, as nothing is hidden then.
    """
    if not len(scene.viewpoints):
        return solids
    statics = Statics.of(scene) if statics is None else statics
    to_world = statics.upright.rotation  # of rows
    guessed = {name: statics.surfaces[name] @ to_world for name in scene.movable}
    return {
        name: (hull_vertices(np.vstack([scene.clouds[name], guessed[name], *parts])),)
        if name in guessed
        else parts
        for name, parts in solids.items()
    }
