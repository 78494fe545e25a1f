"""The objects of a plan as a MoveIt planning scene: the text format of `.scene` files."""

import numpy as np

from topple.planner.planning.plan_format import Plan
from topple.robots.collision.convex import hull_of
from topple.topology.geometry.rigid import move_points

NO_TURN = "0 0 0 1"


def moveit_scene(plan: Plan) -> str:
    """Write the collision objects in the arm's base frame, one mesh for each convex part.

    Args:
        plan: The plan.

    Returns:
        Text as MoveIt's planning scene display loads it.
    """
    world_to_base = np.linalg.inv(np.array(plan.pose_base_to_world))
    lines = ["(noname)+" + plan.robot]
    for thing in plan.objects:
        lines += [f"* {' '.join(thing.name.split())}", "0 0 0", NO_TURN, str(len(thing.parts))]
        for part in thing.parts:
            vertices, faces = hull_of(move_points(np.array(part), world_to_base))
            lines += ["mesh", f"{len(vertices)} {len(faces)}"]
            lines += [" ".join(f"{value:.6g}" for value in vertex) for vertex in vertices.tolist()]
            lines += [" ".join(str(index) for index in face) for face in faces.tolist()]
            lines += ["0 0 0", NO_TURN, "0 0 0 0"]  # pose of the shape, and its colour: MoveIt's own
        lines.append("0")  # no named subframes
    return "\n".join([*lines, "."]) + "\n"
