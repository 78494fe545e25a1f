"""What an action did to everything it was not about, measured on the simulation's true poses."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np

from topple.planner.decide.goal import Goal
from topple.planner.execution.execute import MISSED, TAKEN
from topple.planner.execution.monitor import Verdict
from topple.planner.tolerances import DISTURBED, TURNED
from topple.planner.transfer.transfer import Transfer
from topple.robots.poses import angle_between
from topple.robots.world.simulated_arm import SimulatedArm, Touch
from topple.robots.world.world import World
from topple.topology.arrays import FloatArray
from topple.topology.scene import Scene
from topple.topology.situation import Situation

SAMPLES = 3000  # points on a body's surface when the true scene is related: 2 mm apart on a can
TABLE_SAMPLES = 20_000  # on one that never moves


@dataclass(frozen=True)
class Limits:
    """From where on an object counts as disturbed.

    Attributes:
        distance: Displacement in [m].
        angle: Turn in [rad].
        hit: Contact force of the robot in [N] on something it does not handle: a brush below the
            weight of a can moves nothing.
        fall: Drop in [m] from which a displaced object counts as fallen.
        drop: Height in [m] from which an object that slips out of the hand counts as dropped: crockery
            survives a finger's width.
    """

    distance: float = DISTURBED
    angle: float = TURNED
    hit: float = 5.0
    fall: float = 0.03
    drop: float = 0.03


LIMITS = Limits()


class Judge:
    """Watches a run in simulation on true poses and contact forces; see `topple.planner.execution.monitor`.

    Args:
        robot: The arm in its world.
        fixed: Names that never move.
        up: (3,) unit vector against gravity.
        limits: From where on it counts.
    """

    def __init__(
        self, robot: SimulatedArm, fixed: Collection[str], up: FloatArray, limits: Limits = LIMITS
    ) -> None:
        self._robot, self._world, self._fixed, self._up = robot, robot.world, tuple(fixed), up
        self._limits = limits

    def begin(self, transfer: Transfer) -> None:
        """Look before an action."""
        self._name, self._started = transfer.object, self._world.time
        self._before = self._world.poses()
        self._robot.touched.clear()
        self._taken: FloatArray | None = None
        self._slip: tuple[float, float] | None = None
        self._lost_at: FloatArray | None = None

    def moment(self, moment: str, tool: str) -> None:
        """Look at the hand at a moment of `topple.planner.execution.execute`."""
        now = self._robot.pose_in_hand(self._name, tool)
        if moment == TAKEN:
            self._taken = now
        elif self._taken is not None:
            way = float(np.linalg.norm(now[:3, 3] - self._taken[:3, 3]))
            self._slip = way, angle_between(self._taken, now)
            self._lost_at = self._world.pose(self._name)[:3, 3] if moment == MISSED else None

    def verdict(self) -> Verdict:
        """Say what the action did."""
        before, now, handled = self._before, self._world.poses(), (self._name, *self._fixed)
        wrong = violations(before, now, self._robot.touched, handled, self._limits)
        fallen = 0.0 if self._lost_at is None else float(self._lost_at[2] - now[self._name][2, 3])
        dropped = fallen > self._limits.drop
        if dropped:
            wrong.append(f"it was dropped by {100 * fallen:.0f} cm")
        touched = {other: touch for other, touch in self._robot.touched.items() if other not in handled}
        return Verdict(
            tuple(wrong),
            displacements(before, now, handled),
            tilts(before, now, handled),
            {other: touch.force for other, touch in touched.items()},
            {other: touch.impulse for other, touch in touched.items()},
            self._slip,
            dropped,
            self._world.time - self._started,
        )

    def unmet(self, goal: Goal) -> tuple[str, ...]:
        """Say what of a goal does not hold in the world as it is."""
        return truly_unmet(goal, self._world, self._up)


def displacements(
    before: Mapping[str, FloatArray], after: Mapping[str, FloatArray], handled: Collection[str]
) -> dict[str, tuple[float, float]]:
    """How far everything but the handled objects moved and turned.

    Args:
        before: Poses (4, 4) by name.
        after: Poses (4, 4) by name, the same names.
        handled: Names to leave out.

    Returns:
        Distance in [m] and angle in [rad] by name.
    """
    return {
        name: (
            float(np.linalg.norm(after[name][:3, 3] - pose[:3, 3])),
            angle_between(pose, after[name]),
        )
        for name, pose in before.items()
        if name not in handled and name in after
    }


def violations(
    before: Mapping[str, FloatArray],
    after: Mapping[str, FloatArray],
    touched: Mapping[str, Touch],
    handled: Collection[str],
    limits: Limits = LIMITS,
) -> list[str]:
    """One sentence for each object that moved, turned, fell or was hit though it was not handled.

    Args:
        before: Poses (4, 4) by name.
        after: Poses (4, 4) by name.
        touched: What the robot touched in between, by name.
        handled: Names that the action was about.
        limits: From where on it counts.
    """
    found: list[str] = []
    for name, (distance, angle) in displacements(before, after, handled).items():
        drop = float(before[name][2, 3] - after[name][2, 3])
        if distance > limits.distance and drop > limits.fall:
            found.append(f"{name} fell by {drop * 100:.0f} cm")
        elif distance > limits.distance or angle > limits.angle:
            found.append(f"{name} moved {distance * 1000:.0f} mm and turned {np.degrees(angle):.0f} degrees")
    for name, touch in touched.items():
        if name not in handled and touch.force > limits.hit:
            links = ", ".join(sorted(touch.links))
            found.append(f"{name} was hit by {links} with {touch.force:.0f} N")
    return found


def tilts(
    before: Mapping[str, FloatArray], after: Mapping[str, FloatArray], handled: Collection[str]
) -> dict[str, float]:
    """How far everything but the handled objects was tipped, turns about the vertical left out, in [rad].

    Args:
        before: Poses (4, 4) by name.
        after: Poses (4, 4) by name, the same names.
        handled: Names to leave out.
    """
    return {
        name: float(np.arccos(np.clip(after[name][2, :3] @ pose[2, :3], -1.0, 1.0)))
        for name, pose in before.items()
        if name not in handled and name in after
    }


def truly_unmet(goal: Goal, world: World, up: FloatArray) -> tuple[str, ...]:
    """What of a goal does not hold in the world as it is, whatever the cameras make of it.

    Args:
        goal: What shall hold. What is to be free shall carry nothing.
        world: The world at rest.
        up: (3,) unit vector against gravity.

    Returns:
        The clauses that do not hold, in words.
    """
    rng = np.random.default_rng(0)
    clouds: dict[str, FloatArray] = {}
    for name in world.names:
        points = world.body(name).surface(TABLE_SAMPLES if name in world.fixed else SAMPLES, rng)
        pose = world.pose(name)
        clouds[name] = points @ pose[:3, :3].T + pose[:3, 3]
    scene = Scene(clouds, fixed=sorted(world.fixed), up=up)
    situation = Situation(scene)
    relations, carried = situation.relations, situation.supports
    burdened = [
        f"{name} is not free: it carries {pair.supported}"
        for name in goal.free
        for pair in carried
        if pair.supporter == name
    ]
    return (*burdened, *goal.unmet(relations, scene.fixed, carried))
