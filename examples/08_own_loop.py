"""A loop of your own: look, decide, act, check. `solve` knows no simulation: give it your arm and eyes."""

import sys
from collections.abc import Iterator

import numpy as np
from PIL import Image

from topple.planner import Look, Perception, plan
from topple.robots import Driver, arm_in, robot, scenario
from topple.topology import Scene, Situation, scene_from_objects


class Tracker:
    """A `Perception`: known shapes where an estimator of poses has them, half a millimetre off."""

    def __init__(self, world) -> None:
        self.world, self.rng = world, np.random.default_rng(0)
        self.shapes = {name: self.world.body(name).surface(9000, self.rng) for name in self.world.names}

    def look(self, expected: Scene | None = None, more: object = ()) -> Look:
        """See where everything is, and say what is elsewhere than it should be."""
        seen = {name: shape + self.rng.normal(0, 5e-4, 3) for name, shape in self.shapes.items()}
        scene = scene_from_objects(seen, self.world.poses(), fixed=self.world.fixed, up=(0, 0, 1))
        off = [n for n, c in (expected or scene).clouds.items() if abs(scene.clouds[n] - c).mean() > 0.005]
        return Look((), Situation(scene), None, {name: f"{name} is elsewhere" for name in off})


def solve(goal: str, driver: Driver, eyes: Perception) -> Iterator[str]:
    """Do one step at a time, decided by what is seen, until none is left; yields what each took."""
    look, arm, base = eyes.look(), driver.arm, driver.pose_base_to_world
    while (found := plan(look.scene, goal, arm, pose_base_to_world=base, q_start=driver.q_target)).steps:
        step = found.steps[0]
        print(f"{step.action} {step.object}: {step.reason}")
        for number, segment in enumerate(step.segments):
            if segment.kind == "grasp":
                driver.close(force=30.0)  # [N]
            elif not segment.holding:
                driver.open(segment.hand.opening)
            if segment.motion is not None:
                driver.follow(found.trajectory(0, number))
            driver.wait(0.3)  # [s]
            if segment.holding and not driver.holding:
                sys.exit(f"{step.object} slipped during the {segment.kind}")
        yield step.object
        place = np.array(step.placement.pose_before_to_after)
        look = eyes.look(look.situation.moved([step.object], place).scene)
        print("seen:", ", ".join(look.surprises.values()) or "everything is where it should be")


with scenario("tower") as stage:
    driver = arm_in(stage.world, robot("panda"), stage.pose_base_to_world)
    poses, far = stage.world.poses(), 0.0
    for taken in solve(stage.goal, driver, Tracker(stage.world)):
        before, poses = poses, stage.world.poses()
        far = max(far, *(float(np.linalg.norm((poses[n] - before[n])[:3, 3])) for n in poses if n != taken))
    Image.fromarray(stage.cameras[0].look(stage.world, np.random.default_rng(0)).rgb).save("own_loop.png")
print(f"in truth nothing else moved by more than {1e3 * far:.1f} mm")
sys.exit(int(far > 0.01))
