"""Order, plan and run in a world that topple did not make: of PyBullet, or of MuJoCo where that alone is."""

from importlib.util import find_spec
from pathlib import Path
from typing import Any

from topple.planner import order, plan, run, run_page
from topple.topology import Scene, scene_from_mujoco

BOXES = {  # half sizes and middles [m], mass [kg], 0 for what never moves; the weight holds the plank
    "table": ((0.50, 0.40, 0.02), (0.0, 0.0, -0.02), 0.0),
    "block": ((0.05, 0.05, 0.05), (0.0, 0.0, 0.05), 1.0),
    "plank": ((0.15, 0.04, 0.005), (0.09, 0.0, 0.105), 0.3),
    "weight": ((0.03, 0.03, 0.03), (-0.03, 0.0, 0.14), 1.5),
    "low": ((0.03, 0.03, 0.03), (0.05, 0.25, 0.03), 0.3),
    "high": ((0.025, 0.025, 0.025), (0.05, 0.25, 0.085), 0.2),
}


def seen_in_pybullet() -> Scene:
    """Let it settle for two seconds in a world of PyBullet, whose surfaces topple samples."""
    import pybullet as p

    from topple.robots import scene_from_world

    world, names = p.connect(p.DIRECT), dict[int, str]()
    p.setGravity(0, 0, -9.81)
    for name, (half, place, mass) in BOXES.items():
        names[p.createMultiBody(mass, p.createCollisionShape(p.GEOM_BOX, halfExtents=half), -1, place)] = name
    for _ in range(480):
        p.stepSimulation()
    return scene_from_world(world, names=names)


def seen_in_mujoco() -> Scene:
    """Let it settle for two seconds in a world of MuJoCo, likewise."""
    import mujoco

    spec: Any = mujoco.MjSpec()
    for name, (half, place, mass) in BOXES.items():
        body = spec.worldbody.add_body(name=name, pos=place)
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=half, mass=mass)
        if mass:
            body.add_freejoint()
    model = spec.compile()
    mujoco.mj_step(model, data := mujoco.MjData(model), 1000)
    return scene_from_mujoco(model, data)


if __name__ == "__main__":
    scene = seen_in_pybullet() if find_spec("pybullet") else seen_in_mujoco()
    found = order(scene, ["block"])
    print(f"never moves: {', '.join(scene.fixed)}", *found.explanation, sep="\n")
    print(*(f"{e.first} before {e.then}: {e.reason}" for e in found.graph.dependencies), sep="\n")
    print(*(f"{s.action} {s.object}: {s.reason}" for s in plan(scene, ["low"], "panda").steps), sep="\n")
    record = run(scene, ["low"], "panda")  # the scene rebuilt in simulation, with an arm in it
    Path("own_world.html").write_text(run_page(record), encoding="utf-8")
    print(f"{record.goal}: {'reached' if record.success else '; '.join(record.violations)}")
