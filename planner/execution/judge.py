"""What an action did to everything it was not about, measured on the simulation's true poses."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace

import numpy as np

from topple.planner.decide.goal import Goal
from topple.planner.execution.attained import truly_unmet
from topple.planner.execution.execute import MISSED, TAKEN
from topple.planner.execution.goal_poses import off_goal_poses
from topple.planner.formats.run_record import Verdict
from topple.planner.placement.away import BODIES, IN_HAND, Away
from topple.planner.stability.state import State
from topple.planner.tolerances import DISTURBED, HIT, TURNED
from topple.planner.transfer.transfer import Transfer
from topple.robots.arm.tolerances import GRAVITY
from topple.robots.poses import angle_between
from topple.robots.world.acting_arm import ActingArm
from topple.robots.world.touch import Touch
from topple.topology.base.arrays import FloatArray


@dataclass(frozen=True)
class Limits:
    """From where on an object counts as disturbed.

    Attributes:
        distance: Displacement in [m], in one action or in all since the object was last handled.
        angle: Turn in [rad], likewise; of the handled object how far a failed attempt may tip it.
        hit: Impulse in [N s] of a touch of the robot, beyond a brush, on something it does not handle.
        fall: Drop in [m] from which a displaced object counts as fallen.
        drop: Height in [m] from which an object that slips out of the hand counts as dropped: crockery
            survives a finger's width.
    """

    distance: float = DISTURBED
    angle: float = TURNED
    hit: float = HIT
    fall: float = 0.03
    drop: float = 0.03


LIMITS = Limits()


class Judge:
    """Watches a run in simulation on true poses and contact forces; see `topple.planner.execution.monitor`.

    Args:
        robot: The arm in its world.
        fixed: Names that never move.
        up: (3,) unit vector against gravity.
        wanted: Where things shall lie in the end, as (4, 4) true poses by name; where None, by the goal.
        second: The arm beside it that holds things, if any.
    """

    def __init__(
        self,
        robot: ActingArm,
        fixed: Collection[str],
        up: FloatArray,
        wanted: Mapping[str, FloatArray] | None = None,
        second: ActingArm | None = None,
    ) -> None:
        self._arms: tuple[ActingArm, ...] = (robot,) if second is None else (robot, second)
        self._robot, self._world, self._fixed, self._up = robot, robot.world, tuple(fixed), up
        self._wanted, self._first = wanted, robot.world.poses()
        self._gone: set[str] = set()  # handed on, or in a bin: no more of what the goal is about
        self._rested: dict[str, FloatArray] = {}  # where each thing was when it was last handled, or at first

    def begin(self, transfer: Transfer, held: str | None = None, by_second: bool = False) -> None:
        """Look before an action.

        Args:
            transfer: What is about to be done.
            held: What the other arm holds meanwhile: it may be touched by that arm alone, and not move.
            by_second: Whether the second arm does it.
        """
        self._robot = self._arms[1 if by_second else 0]
        self._held = held
        self._name, self._started, self._how = transfer.object, self._world.time, transfer.placement.how
        self._handled = (transfer.object, *transfer.riding, *self._fixed)
        self._before = self._world.poses()
        self._rested = {**self._before, **self._rested}
        for arm in self._arms:
            arm.touched.clear()
        self._taken: FloatArray | None = None
        self._slip: tuple[float, float] | None = None
        self._missed = False
        self._highest = self._height()
        self._robot.on_step.append(self._track_height)

    def moment(self, moment: str, tool: str) -> None:
        """Look at the hand at a moment of `topple.planner.execution.execute`."""
        now = self._robot.pose_in_hand(self._name, tool)
        if moment == TAKEN:
            self._taken = now
        elif self._taken is not None:
            way = float(np.linalg.norm(now[:3, 3] - self._taken[:3, 3]))
            self._slip = way, angle_between(self._taken, now)
        self._missed = self._missed or moment == MISSED

    def verdict(self) -> Verdict:
        """Say what the action did."""
        self._robot.on_step.remove(self._track_height)
        before, now, handled = self._before, self._world.poses(), self._handled
        touched = self._stray_touches()
        wrong = [*violations(before, now, handled), *hits(touched)]
        fallen = self._highest - self._height() if self._missed else 0.0
        dropped = fallen > LIMITS.drop
        if dropped:
            wrong.append(f"it was dropped by {100 * fallen:.0f} cm")
        tipped = tilts(before, now, self._fixed)[self._name] if self._missed else 0.0
        if tipped > LIMITS.angle:
            wrong.append(f"it was tipped by {np.degrees(tipped):.0f} degrees in a failed attempt")
        if not self._missed and self._how in (*IN_HAND, Away.BIN):
            self._gone.add(self._name)
            if self._how is Away.BIN and not State.of(self._world).within(self._name, BODIES[Away.BIN]):
                wrong.append("it is not in the bin")
        moves = displacements(before, now, handled)
        wrong += self._crept(now, moves)
        far = [name for name, (way, turn) in moves.items() if way > LIMITS.distance or turn > LIMITS.angle]
        return Verdict(
            violations=tuple(wrong),
            disturbed=moves,
            severity={name: self._fall(name, before[name], now[name]) for name in far},
            tilts=tilts(before, now, handled),
            forces={other: touch.force for other, touch in touched.items()},
            impulses={other: touch.hit for other, touch in touched.items()},
            slip=self._slip,
            dropped=dropped,
            robot_seconds=self._world.time - self._started,
        )

    def _fall(self, name: str, before: FloatArray, now: FloatArray) -> tuple[float, float]:
        """How far the middle of a body fell between two poses (4, 4) [m], and its energy by that [J]."""
        body = self._world.body(name)
        middle = np.append(body.centre_of_mass, 1.0)
        drop = max(0.0, float(((before - now) @ middle)[:3] @ self._up))
        return drop, body.mass * GRAVITY * drop

    def _stray_touches(self) -> dict[str, Touch]:
        """Touches of objects that an arm was not to handle, by name."""
        return {
            name: touch
            for arm in self._arms
            for name, touch in arm.touched.items()
            if name not in (self._handled if arm is self._robot else (self._held, *self._fixed))
        }

    def _crept(self, now: Mapping[str, FloatArray], at_once: Mapping[str, tuple[float, float]]) -> list[str]:
        """One sentence for each thing that moved by as much as counts in several actions, in none at once."""
        found: list[str] = []
        for name, (way, angle) in displacements(self._rested, now, self._handled).items():
            if way <= LIMITS.distance and angle <= LIMITS.angle:
                continue
            self._rested[name] = now[name]  # said once
            once, turned = at_once[name]
            if once <= LIMITS.distance and turned <= LIMITS.angle:
                by = f"{way * 1000:.0f} mm and {np.degrees(angle):.0f} degrees"
                found.append(f"{name} has crept by {by} since it was last handled")
        self._rested.update({name: now[name] for name in self._handled if name in now})
        return found

    def _height(self) -> float:
        """Of the handled object [m]."""
        return float(self._world.pose(self._name)[:3, 3] @ self._up)

    def _track_height(self) -> None:
        self._highest = max(self._highest, self._height())

    def unmet(self, goal: Goal) -> tuple[str, ...]:
        """Say what of a goal does not hold in the world as it is."""
        goal = replace(goal, free=tuple(name for name in goal.free if name not in self._gone))
        wanted = self._wanted
        if wanted is None:
            wanted = {name: pose @ self._first[name] for name, pose in goal.poses.items()}
        return (
            *truly_unmet(goal, self._world, self._up),
            *off_goal_poses(self._world, wanted, self._up, LIMITS.distance, LIMITS.angle),
        )


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
    before: Mapping[str, FloatArray], after: Mapping[str, FloatArray], handled: Collection[str]
) -> list[str]:
    """One sentence for each object that moved, turned or fell though it was not handled.

    Args:
        before: Poses (4, 4) by name.
        after: Poses (4, 4) by name.
        handled: Names that the action was about.
    """
    found: list[str] = []
    for name, (distance, angle) in displacements(before, after, handled).items():
        drop = float(before[name][2, 3] - after[name][2, 3])
        if distance > LIMITS.distance and drop > LIMITS.fall:
            found.append(f"{name} fell by {drop * 100:.0f} cm")
        elif distance > LIMITS.distance or angle > LIMITS.angle:
            found.append(f"{name} moved {distance * 1000:.0f} mm and turned {np.degrees(angle):.0f} degrees")
    return found


def hits(touched: Mapping[str, Touch]) -> list[str]:
    """One sentence for each object that was hit by a robot that was not to handle it.

    Args:
        touched: What a robot touched, by name.
    """
    return [
        f"{name} was hit by {', '.join(sorted(touch.links))} with {touch.hit:.2f} N s"
        for name, touch in touched.items()
        if touch.hit > LIMITS.hit
    ]


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
