"""Two cards that hold each other: what a second hand has to hold, and what happens if nobody does.

python examples/hold.py [cards.npz], which it writes
"""

import sys

import numpy as np
from scipy.spatial.transform import Rotation

import topple
from topple.planner.simulate.lifts import take_away
from topple.robots import scene_from_world
from topple.robots.scenarios.scenario import pose_at
from topple.robots.shapes import box
from topple.robots.world.world import World

TILT = 0.25  # [rad]
CARD = box("card", (0.01, 0.09, 0.1))


def card_house(held: str | None = None) -> World:
    """Two cards on a table that lean on each other; one may be kept still."""
    world = World()
    world.add_table(size=(0.8, 0.8))
    thick, _, high = np.ptp(np.concatenate(CARD.parts), axis=0)
    reach = high * np.sin(TILT) + thick * np.cos(TILT)
    for name, side in (("left", -1), ("right", 1)):
        turn = Rotation.from_euler("y", -side * TILT)
        foot = np.array([side * reach, 0.0, 0.0]) - turn.apply([side * thick / 2, 0.0, 0.0])
        world.add(
            CARD.named(name),
            pose_at(float(foot[0]), float(foot[1]), float(foot[2]), turn),
            fixed=name == held,
        )
    world.settle(2.0)
    return world


def main() -> None:
    """Order the cards for one hand and for two, and try it in simulation."""
    with card_house() as world:
        scene = scene_from_world(world.client, names={number: name for name, number in world.ids.items()})
    if len(sys.argv) > 1:
        np.savez_compressed(sys.argv[1], **scene.clouds, up=scene.up, fixed=sorted(scene.fixed))
    print(*topple.order(scene, hands=1).certificate, sep="\n")
    found = topple.order(scene, hands=2)
    (hold,) = found.holds
    print(f"take {', '.join(found.order)}; {hold.sentence(found.order)}")
    for held in (None, hold.object):
        with card_house(held) as world:
            far = [move.angle for move in take_away(world, hold.since).values()]
            turned = f"the rest turns {max(far, default=0.0):.1f} rad"
            print(f"{hold.since} is lifted, {held or 'nothing'} held: {turned}")


if __name__ == "__main__":
    main()
