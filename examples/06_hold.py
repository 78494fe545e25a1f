"""Two cards that hold each other: what a second hand has to hold, and what happens if nobody does.

python examples/06_hold.py [cards.npz], which it writes
"""

import sys
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

import topple
from topple.planner import show_page
from topple.robots import new_world
from topple.robots.poses import angle_between
from topple.robots.scenarios.scenario import pose_at
from topple.robots.shapes import box
from topple.robots.world.physical_world import PhysicalWorld
from topple.topology import scene_from_objects

TILT = 0.25  # [rad]
CARD = box("card", (0.01, 0.09, 0.1))


def card_house(held: str | None = None) -> PhysicalWorld:
    """Two cards on a table that lean on each other; one may be kept still."""
    world = new_world()
    world.add_table(size=(0.8, 0.8))
    thick, _, high = np.ptp(np.concatenate(CARD.parts), axis=0)
    reach = high * np.sin(TILT) + thick * np.cos(TILT)
    for name, side in (("left", -1), ("right", 1)):
        turn = Rotation.from_euler("y", -side * TILT)
        foot = np.array([side * reach, 0.0, 0.0]) - turn.apply([side * thick / 2, 0.0, 0.0])
        world.add(CARD.named(name), pose_at(*foot.tolist(), turn), fixed=name == held)
    world.settle(2.0)
    return world


def main() -> None:
    """Order the cards for one hand and for two, and try it in simulation."""
    with card_house() as world:
        clouds = {n: world.body(n).surface(10_000, np.random.default_rng(0)) for n in world.names}
        scene = scene_from_objects(clouds, world.poses(), fixed=["table"], up=(0, 0, 1))
    scene.save(sys.argv[1] if len(sys.argv) > 1 else "cards.npz")
    print(*topple.order(scene, hands=1).certificate, sep="\n")
    (hold,) = (found := topple.order(scene, hands=2)).holds
    Path("hold.html").write_text(show_page(scene, topple.relate(scene), found), encoding="utf-8")
    print(f"take {', '.join(found.order)}; {hold.sentence(found.order)}")
    for held in (None, hold.object):
        with card_house(held) as world:
            world.remove(hold.since)
            before = world.poses()
            world.step(480)  # two seconds
            far = max((angle_between(before[n], pose) for n, pose in world.poses().items()), default=0.0)
            print(f"{hold.since} is taken, {held or 'nothing'} held: the rest turns {far:.1f} rad")


if __name__ == "__main__":
    main()
