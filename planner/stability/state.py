"""A world at one instant: what touches what with which force, what moves, and shapes, of any simulator."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cache, cached_property
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from topple.planner.stability.check import check
from topple.planner.stability.tolerances import CLOUD_RIM, REST_SPEED, REST_TURN, RIM
from topple.planner.stability.verdicts import Verdict
from topple.robots.tolerances import TOLERANCES
from topple.robots.world.physical_world import PhysicalWorld
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput, UnknownObject
from topple.topology.geometry.axes import level_axes
from topple.topology.geometry.rigid import move_points
from topple.topology.geometry.sides import beyond, sides_of
from topple.topology.scene.scene import Scene
from topple.topology.statics.tolerances import LOWEST_SHARE

CUBE = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
_KNOWN: "WeakKeyDictionary[Scene, State]" = WeakKeyDictionary()


@dataclass(frozen=True, eq=False)
class State:
    """A world at one instant, as predicates need it: make it once to ask several.

    Attributes:
        names: Of everything there.
        up: (3,) unit vector against gravity; None where there is no gravity.
        weights: name -> weight [N], of what can move.
        pushes: (a, b) -> (3,) normal force of b on a [N], of all that touch; both ways.
        doubted: (a, b) of which no camera saw whether b carries a, or that are in each other.
        middles: name -> (3,) centre of mass [m].
        corners: Gives points (K, 3) around a name's shape [m].
        motion: Gives velocity [m/s] at the centre of mass and turning speed [rad/s], both (3,), of a name.
        joined: name -> names that it is a part of, or that are parts of it.
        fallen: What statics says not to stay; empty of a running world.
        rim: How far below another's highest point [m] a thing is in its hollow.
    """

    names: tuple[str, ...]
    up: FloatArray | None
    weights: Mapping[str, float]
    pushes: Mapping[tuple[str, str], FloatArray]
    middles: Mapping[str, FloatArray]
    corners: Callable[[str], FloatArray] = field(repr=False)
    motion: Callable[[str], tuple[FloatArray, FloatArray]] = field(repr=False)
    doubted: frozenset[tuple[str, str]] = frozenset()
    joined: Mapping[str, frozenset[str]] = field(default_factory=dict[str, frozenset[str]])
    fallen: frozenset[str] = frozenset()
    rim: float = RIM

    @staticmethod
    def of(world: Any, data: Any = None) -> "State":
        """Take the state of a world.

        Args:
            world: A `mujoco.MjModel`, a PyBullet client, a world of topple, a Scene, or a State.
            data: The `mujoco.MjData` that goes with a model, after a step.

        Raises:
            InvalidInput: It is none of these, or a scene without `up`.
        """
        if isinstance(world, State):
            return world
        if isinstance(world, PhysicalWorld):
            return _of_world(world)
        if isinstance(world, Scene):
            return _KNOWN.get(world) or _KNOWN.setdefault(world, _of_scene(world))
        if isinstance(world, int) and not isinstance(world, bool):
            return _of_bullet(world)
        if hasattr(world, "geom_bodyid") and hasattr(data, "ncon"):
            return _of_mujoco(world, data)
        raise InvalidInput(
            f"got a {type(world).__name__}: expected a mujoco.MjModel and its MjData, a PyBullet client "
            "or a Scene"
        )

    def check(self, *names: str) -> None:
        """Refuse names that are not there."""
        for name in names:
            if name not in self.names:
                raise UnknownObject(name, self.names)

    @cached_property
    def pressed(self) -> bool:
        """Whether forces are known: before a first step none is."""
        return any(push.any() for push in self.pushes.values())

    def lift(self, name: str, carrier: str) -> float:
        """Upward force of one on another [N]."""
        push = self.pushes.get((name, carrier))
        return 0.0 if push is None or self.up is None else float(push @ self.up)

    def rests(self, name: str, on: str | None = None) -> bool:
        """Whether a body is at rest, beside another one where that is given, which may move itself."""
        speed, turn = self.motion(name)
        if on is not None:
            other, turning = self.motion(on)
            speed = speed - other - np.cross(turning, self.middles[name] - self.middles[on])
            turn = turn - turning
        return bool(np.linalg.norm(speed) < REST_SPEED and np.linalg.norm(turn) < REST_TURN)

    def apart(self, name: str) -> Iterable[str]:
        """Everything that is no part of a body, nor it of that."""
        own = self.joined.get(name, frozenset())
        return (other for other in self.names if other != name and other not in own)

    def in_hollow(self, name: str, container: str) -> bool:
        """Whether a body is in the hollow of another, carried or not.

        Its centre of mass is over the other's outline, its lowest point below the rim and above the lowest.
        """
        if self.up is None or name == container:
            return False
        around, level = self._around(container), self._level
        plan, middle = around @ level, self.middles[name] @ level
        if (middle < plan.min(axis=0)).any() or (middle > plan.max(axis=0)).any():  # beside the box: most are
            return False
        heights, lowest = around @ self.up, float((self._around(name) @ self.up).min())
        if not heights.min() < lowest < heights.max() - self.rim:
            return False
        sides = sides_of(plan)
        return sides is not None and bool(beyond(sides, middle) <= 0)

    @cached_property
    def _around(self) -> Callable[[str], FloatArray]:
        return cache(self.corners)

    @cached_property
    def _level(self) -> FloatArray:
        """(3, 2) level axes, the columns; none without up."""
        return np.zeros((3, 0)) if self.up is None else np.stack(level_axes(self.up), axis=1)

    def within(self, name: str, container: str) -> bool:
        """Whether a body is in the hollow of another, and meets that or what else is in it."""
        if not self.in_hollow(name, container):
            return False
        meeting, reached = [name], {name}
        while meeting:
            low = meeting.pop()
            met = {b for a, b in self.pushes if a == low} - reached
            if container in met:
                return True
            reached |= met
            meeting += [each for each in met if self.in_hollow(each, container)]
        return False


def _of_world(world: PhysicalWorld) -> State:
    """The state of a world of topple, on either engine; robots are left out, as its contacts leave them."""
    pushes: dict[tuple[str, str], FloatArray] = {}
    for contact in world.contacts():
        _add(pushes, contact.a, contact.b, contact.force * contact.normal)
    bodies = {name: world.body(name) for name in world.names}
    speeds = {name: world.speeds(name) for name in world.movable}

    def motion(name: str) -> tuple[FloatArray, FloatArray]:
        speed, turn = speeds.get(name, (0.0, 0.0))  # which way is not known: what rides is said to move
        return np.array([speed, 0.0, 0.0]), np.array([turn, 0.0, 0.0])

    gravity = world.physics.gravity
    return State(
        tuple(bodies),
        np.array([0.0, 0.0, 1.0]) if gravity > 0 else None,
        {name: bodies[name].mass * gravity for name in world.movable},
        pushes,
        {name: move_points(body.centre_of_mass, world.pose(name)) for name, body in bodies.items()},
        lambda name: np.vstack(world.parts(name)),
        motion,
    )


def _of_bullet(client: int) -> State:
    """The state of a PyBullet world after its last step; a body of several links is one thing."""
    from topple.robots.engine import pybullet  # a world of another engine does not need it
    from topple.robots.world.observe import bodies_in, box_of, mass_of

    ids = bodies_in(client, {})
    numbers = {name: number for number, name in ids.items()}
    settings: Any = pybullet.getPhysicsEngineParameters(physicsClientId=client)
    down = np.array([settings[f"gravityAcceleration{axis}"] for axis in "XYZ"], dtype=np.float64)
    pushes: dict[tuple[str, str], FloatArray] = {}
    points: Any = pybullet.getContactPoints(physicsClientId=client)
    for point in points or ():
        a, b = ids.get(point[1]), ids.get(point[2])
        if a is not None and b is not None and a != b and point[8] <= TOLERANCES.contact:
            _add(pushes, a, b, point[9] * np.array(point[7]))

    def corners(name: str) -> FloatArray:
        lower, upper = box_of(client, numbers[name])
        return (lower + upper) / 2 + CUBE * (upper - lower) / 2

    def motion(name: str) -> tuple[FloatArray, FloatArray]:
        speed, turn = pybullet.getBaseVelocity(numbers[name], physicsClientId=client)
        return np.array(speed), np.array(turn)

    places = {
        name: pybullet.getBasePositionAndOrientation(k, physicsClientId=client) for k, name in ids.items()
    }
    masses = {name: mass_of(client, number) for number, name in ids.items()}
    gravity = float(np.linalg.norm(down))
    return State(
        tuple(numbers),
        -down / gravity if gravity else None,
        {name: mass * gravity for name, mass in masses.items() if mass > 0},
        pushes,
        {name: np.array(place[0]) for name, place in places.items()},
        corners,
        motion,
    )


def _of_mujoco(model: Any, data: Any) -> State:
    """The state of a MuJoCo world after its last step. Every body is a thing, with all that hangs on it."""
    from topple.robots.mujoco.engine import mujoco

    body = mujoco.mjtObj.mjOBJ_BODY
    names = [mujoco.mj_id2name(model, body, k) or f"body_{k}" for k in range(model.nbody)]
    lines: list[tuple[int, ...]] = [()]
    for k in range(1, model.nbody):  # a body and all it hangs on, but the world: parents come first
        lines.append((k, *lines[int(model.body_parentid[k])]))
    joined: dict[str, set[str]] = {name: set() for name in names}
    for k, line in enumerate(lines):
        for parent in line[1:]:
            joined[names[k]].add(names[parent])
            joined[names[parent]].add(names[k])
    down = np.array(model.opt.gravity)
    gravity = float(np.linalg.norm(down))
    pushes: dict[tuple[str, str], FloatArray] = {}
    force = np.zeros(6)
    owners, frames = model.geom_bodyid[data.contact.geom], data.contact.frame.reshape(-1, 9)
    for k in range(data.ncon):
        mujoco.mj_contactForce(model, data, k, force)
        push = -force[0] * frames[k, :3]  # its normal points from the first geom to the second
        first, second = (lines[int(owner)] or (0,) for owner in owners[k])
        for a in set(first) - set(second):
            for b in set(second) - set(first):
                _add(pushes, names[a], names[b], push)

    numbers = {name: k for k, name in enumerate(names)}

    def corners(name: str) -> FloatArray:
        own = [k for k in range(model.ngeom) if numbers[name] in (lines[int(model.geom_bodyid[k])] or (0,))]
        solid = [k for k in own if model.geom_contype[k] or model.geom_conaffinity[k]] or own
        boxes = [
            data.geom_xpos[k]
            + (model.geom_aabb[k, :3] + CUBE * model.geom_aabb[k, 3:]) @ data.geom_xmat[k].reshape(3, 3).T
            for k in solid
        ]
        return np.concatenate([*boxes, data.xpos[numbers[name]][None]])

    def motion(name: str) -> tuple[FloatArray, FloatArray]:
        found = np.zeros(6)
        mujoco.mj_objectVelocity(model, data, body, numbers[name], found, 0)
        return found[3:], found[:3]

    free = [k for k in range(1, model.nbody) if model.body_weldid[k] != 0]
    return State(
        tuple(names),
        -down / gravity if gravity else None,
        {names[k]: float(model.body_subtreemass[k]) * gravity for k in free},
        pushes,
        {name: np.array(data.xipos[k]) for k, name in enumerate(names)},
        corners,
        motion,
        joined={name: frozenset(others) for name, others in joined.items()},
    )


def _of_scene(scene: Scene) -> State:
    """A scene as statics has it, at rest."""
    checked = check(scene)
    found = checked.objects
    up = scene.up
    assert up is not None  # `check` saw to it
    still = np.zeros(3), np.zeros(3)
    pushes: dict[tuple[str, str], FloatArray] = {}
    doubted: set[tuple[str, str]] = set()
    borne: dict[str, float] = dict.fromkeys(found, 0.0)
    for name, each in found.items():
        if each.verdict is Verdict.PENETRATES:
            doubted |= {(name, other) for other in each.others}
        for carry in each.carried_by:
            borne[name] += carry.force
            borne |= {carry.name: borne[carry.name] - carry.force} if carry.name in borne else {}
            if carry.inferred:
                doubted.add((name, carry.name))
            else:
                _add(pushes, name, carry.name, carry.force * up)
    clouds = scene.clouds
    return State(
        scene.names,
        np.asarray(up),
        {name: max(weight, 0.0) for name, weight in borne.items()},
        pushes,
        {n: scene.centres.get(n, (cloud.min(axis=0) + cloud.max(axis=0)) / 2) for n, cloud in clouds.items()},
        lambda name: clouds[name] if checked.exact else _without_strays(clouds[name], up),
        lambda name: still,
        frozenset(doubted),
        fallen=frozenset(name for name, each in found.items() if not each.stands),
        rim=RIM if checked.exact else CLOUD_RIM,
    )


def _without_strays(points: FloatArray, up: FloatArray) -> FloatArray:
    """Points of a cloud but the highest hundredth, which noise put there."""
    heights = points @ up
    return points[heights <= np.quantile(heights, 1 - LOWEST_SHARE)]


def _add(pushes: dict[tuple[str, str], FloatArray], a: str, b: str, push: FloatArray) -> None:
    """Add a force of b on a, and what b feels of it."""
    pushes[a, b] = pushes.get((a, b), 0.0) + push
    pushes[b, a] = pushes.get((b, a), 0.0) - push
