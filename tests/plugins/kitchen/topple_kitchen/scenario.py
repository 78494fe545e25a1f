from topple.robots.scenarios.scenario import pose_at, settle, settled
from topple.robots.shapes import block


def cups(seed):
    return settled("cups", seed, layout, robot="panda")


def layout(world, rng):  # fills a world that has a table; raises Unlucky where it has to be tried again
    for name, height in (("low", 0.0), ("high", 0.0502)):
        world.add(block(name), pose_at(0.0, rng.uniform(-0.005, 0.005), height))
    settle(world)
    return "free low", ("low",)
