"""Order, plan and run in a PyBullet world that topple did not make.

python examples/own_world.py
"""

import pybullet

from topple.planner import order, plan, run
from topple.robots import scene_from_world


def add_box(
    client: int, size: tuple[float, float, float], place: tuple[float, float, float], mass: float
) -> int:
    """Put a box into the world; mass 0 never moves."""
    half = [length / 2 for length in size]
    shape = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=half, physicsClientId=client)
    return pybullet.createMultiBody(mass, shape, basePosition=place, physicsClientId=client)


def main() -> None:
    """Build a stack with a counterweight and let it settle; then free the block beside it."""
    client = pybullet.connect(pybullet.DIRECT)
    pybullet.setGravity(0, 0, -9.81, physicsClientId=client)
    names = {
        add_box(client, (1.00, 0.80, 0.04), (0.0, 0.0, -0.02), 0.0): "table",
        add_box(client, (0.10, 0.10, 0.10), (0.0, 0.0, 0.05), 1.0): "block",
        add_box(client, (0.30, 0.08, 0.01), (0.09, 0.0, 0.105), 0.3): "plank",
        add_box(client, (0.06, 0.06, 0.06), (-0.03, 0.0, 0.14), 1.5): "weight",
        add_box(client, (0.06, 0.06, 0.06), (0.05, 0.25, 0.03), 0.3): "low",
        add_box(client, (0.05, 0.05, 0.05), (0.05, 0.25, 0.085), 0.2): "high",
    }
    for _ in range(480):  # two seconds
        pybullet.stepSimulation(physicsClientId=client)

    scene = scene_from_world(client, names=names)
    pybullet.disconnect(physicsClientId=client)
    found = order(scene, ["block"])
    print(f"never moves: {', '.join(sorted(scene.fixed))}")
    for sentence in found.explanation:
        print(sentence)
    print(
        f"reasons: {', '.join(f'{e.first} before {e.then} ({e.reason})' for e in found.graph.dependencies)}"
    )
    for step in plan(scene, ["low"], "panda").steps:
        print(f"{step.action} {step.object}: {step.reason}")
    record = run(scene, ["low"], "panda")  # the scene rebuilt in PyBullet, with an arm in it
    print(f"{record.goal}: {'reached' if record.success else '; '.join(record.violations)}")


if __name__ == "__main__":
    main()
