"""Whether scenes that were spoilt are told from such that stand: verdicts of `topple check`, one by one.

Scenes of three generators, stacks of blocks and two that PyBullet lets come to rest, with one thing beside
them that floats, is in what carries it, has its weight beyond an edge, rolls or slides, each by a stated
amount, or stands next to doing so. All else stands. Told from exact meshes, and from clouds of them.
"""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from topple.benchmarks.row import Progress, Row
from topple.benchmarks.truth.built import built
from topple.benchmarks.truth.designed import designed
from topple.benchmarks.truth.resting import FRICTION, RestingScene
from topple.planner.stability.check import check
from topple.robots import shapes
from topple.robots.collision.convex import hull_of
from topple.robots.world.bodies import Body, join_meshes
from topple.robots.world.world import World
from topple.topology.base.arrays import FloatArray
from topple.topology.geometry.rigid import move_points
from topple.topology.scene.mesh import Mesh
from topple.topology.scene.scene import Scene

FIRST_SEED = 930_000
"""Of the scenes; nothing else begins there."""

AWAY = 0.65
"""[m] from the middle of the table to what is spoilt."""

NOISE = 0.0005
"""Standard deviation [m] of the clouds, along each axis: of a structured-light scanner."""

POINTS = 5000
"""Of each cloud."""

BAR_RECALL, BAR_PRECISION = ">= 98", ">= 95"
OWN = float(np.sqrt(FRICTION[0]))
"""Friction of what can move, so that two such have that of what came to rest on each other."""

SUNK = 0.0018
"""[m] that PyBullet lets what comes to rest into each other: deeper it was pressed in, and penetrates."""

Placed = dict[str, Mesh]
Spoil = Callable[[np.random.Generator, Body], tuple[Placed, str]]
"""What it puts onto the table, and what becomes of its object `odd`."""


def _mesh(body: Body, pose: FloatArray) -> Mesh:
    whole = join_meshes([hull_of(part) for part in body.parts])
    return Mesh(move_points(whole.vertices, pose), whole.faces)


def _box(size: tuple[float, float, float], middle: FloatArray, turn: Rotation | None = None) -> Mesh:
    pose = np.eye(4)
    pose[:3, 3] = middle
    pose[:3, :3] = np.eye(3) if turn is None else turn.as_matrix()
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]) * size
    return Mesh(move_points(corners, pose), hull_of(corners)[1])


def _shifted(mesh: Mesh, offset: FloatArray | tuple[float, float, float]) -> Mesh:
    return Mesh(mesh.vertices + offset, mesh.faces)


def _alone(body: Body) -> Mesh:
    """A body as PyBullet lets it come to rest on a table, at height 0."""
    with World() as world:
        world.add_table(size=(1.0, 1.0))
        lowest = min(float(part[:, 2].min()) for part in body.parts)
        pose = np.eye(4)
        pose[2, 3] = 1e-4 - lowest
        world.add(body.named("odd"), pose)
        world.settle(3.0)
        mesh = _mesh(body, world.pose("odd"))
    middle = (mesh.vertices.max(axis=0) + mesh.vertices.min(axis=0)) / 2
    return _shifted(mesh, (-middle[0], -middle[1], -mesh.vertices[:, 2].min()))


def _higher(by: float) -> Spoil:
    """Something above what it stood on, or in it where that is below 0; half of the time on a block."""

    def spoil(rng: np.random.Generator, body: Body) -> tuple[Placed, str]:
        odd = _alone(body)
        wide = 0.02 + float(np.ptp(odd.vertices, axis=0).max())
        base = _box((wide, wide, 0.05), np.array([0, 0, 0.025]))
        on = {"base": base} if rng.random() < 0.5 else {}
        verdict = "floats" if by > 0 else "penetrates" if by < 0 else "stands"
        return {**on, "odd": _shifted(odd, (0, 0, by + 0.05 * len(on)))}, verdict

    return spoil


def _beyond(by: float) -> Spoil:
    """A block whose middle is beyond the edge of another one, or before it where that is below 0."""

    def spoil(rng: np.random.Generator, body: Body) -> tuple[Placed, str]:
        low, high = rng.uniform(0.05, 0.12, 3), rng.uniform(0.04, 0.1, 3)
        yaw = Rotation.from_euler("z", rng.uniform(0, 2 * np.pi))
        base = _box(tuple(low), np.array([0, 0, low[2] / 2]), yaw)
        middle = yaw.apply([low[0] / 2 + by, 0, low[2] + high[2] / 2])
        odd = _box(tuple(high), middle, yaw * Rotation.from_euler("z", rng.uniform(-0.6, 0.6)))
        return {"base": base, "odd": odd}, "tips" if by > 0 else "stands"

    return spoil


def _slope(kind: str, least: float, most: float, verdict: str) -> Spoil:
    """A ball or a block on a slope between two angles [deg]."""

    def spoil(rng: np.random.Generator, body: Body) -> tuple[Placed, str]:
        angle = np.radians(rng.uniform(least, most))
        turn, up = Rotation.from_euler("y", angle), np.array([np.sin(angle), 0, np.cos(angle)])
        ramp = _box((0.3, 0.2, 0.02), np.array([0, 0, 0.2]), turn)
        top = np.array([0, 0, 0.2]) + 0.01 * up
        if kind == "ball":
            radius = rng.uniform(0.02, 0.04)
            ball = shapes.ball("odd", diameter=2 * radius)
            whole = join_meshes([hull_of(part) for part in ball.parts])
            somehow = Rotation.from_rotvec(rng.uniform(-3, 3, 3))
            corners = somehow.apply(whole.vertices - whole.vertices.mean(axis=0))
            odd = Mesh(corners + top - up * float((corners @ up).min()), whole.faces)
        else:
            size = (*rng.uniform(0.06, 0.09, 2), rng.uniform(0.02, 0.03))
            odd = _box(size, top + up * size[2] / 2, turn * Rotation.from_euler("z", rng.uniform(0, 6)))
        return {"ramp": ramp, "odd": odd}, verdict

    return spoil


def _leaning(least: float, most: float, verdict: str) -> Spoil:
    """A plank against a wall, at an angle [deg] to the table: with these frictions it stands from 30 on."""

    def spoil(rng: np.random.Generator, body: Body) -> tuple[Placed, str]:
        angle = np.radians(rng.uniform(least, most))
        plank = _box((rng.uniform(0.2, 0.3), 0.06, 0.01), np.zeros(3), Rotation.from_euler("y", -angle))
        plank = _shifted(plank, (0, 0, -plank.vertices[:, 2].min()))
        wall = _box((0.03, 0.3, 0.4), np.array([plank.vertices[:, 0].max() + 0.015, 0, 0.2]))
        return {"wall": wall, "odd": plank}, verdict

    return spoil


SPOILS: Mapping[str, Spoil] = {
    **{f"floats by {mm} mm": _higher(1e-3 * mm) for mm in (1, 2, 5, 20)},
    **{f"{mm} mm deep": _higher(-1e-3 * mm) for mm in (2, 5, 10)},
    **{f"centre {mm} mm beyond the edge": _beyond(1e-3 * mm) for mm in (1, 2, 5)},
    "ball on a slope": _slope("ball", 16, 25, "tips"),
    "block on too steep a slope": _slope("block", 30, 45, "slides"),
    "leaning past the friction cone": _leaning(18, 27, "slides"),
    "at rest": _higher(0.0),
    **{f"centre {mm} mm before the edge": _beyond(-1e-3 * mm) for mm in (2, 5)},
    "block on a slope it holds on": _slope("block", 8, 22, "stands"),
    "leaning within the cone": _leaning(42, 70, "stands"),
}
SMALL = ("floats by 1 mm", "centre 1 mm beyond the edge")
"""Spoils below what meshes are told to, 2 mm."""
IN_NOISE = (*SMALL, "floats by 2 mm", "2 mm deep", "5 mm deep", "centre 2 mm beyond the edge")
"""Those that the noise of clouds and the 3 mm that statics concedes hide."""
FIXED = ("table", "ramp", "wall")


@dataclass(frozen=True)
class Ground:
    """What stands on the table beside what is spoilt.

    Attributes:
        placed: Its meshes.
        goods: Bodies of which one may be spoilt.
        centres: name -> (3,) centre of mass [m], as far as known.
        pressed: What the simulator pressed into something else: that penetrates.
    """

    placed: Placed
    goods: Sequence[Body]
    centres: Mapping[str, FloatArray] = field(default_factory=dict[str, FloatArray])
    pressed: frozenset[str] = frozenset()


def _blocks(seed: int) -> Ground:
    """Stacks of blocks that stand: each has its middle well over the one below."""
    rng, placed = np.random.default_rng(seed), Placed()
    for number in range(int(rng.integers(2, 5))):
        middle = np.array([0.22 * number - 0.3, rng.uniform(-0.2, 0.2), 0.0])
        for level in range(int(rng.integers(1, 5))):
            size = (*rng.uniform(0.06, 0.12, 2), rng.uniform(0.02, 0.08))
            turn = Rotation.from_euler("z", rng.uniform(0, np.pi))
            placed[f"block_{number}_{level}"] = _box(size, middle + np.array([0, 0, size[2] / 2]), turn)
            middle = middle + np.array([*rng.uniform(-0.006, 0.006, 2), size[2]])
    return Ground(placed, [shapes.box("odd", tuple(rng.uniform(0.04, 0.1, 3)))])


def _settled(make: Callable[[int], tuple[str, RestingScene]]) -> Callable[[int], Ground]:
    """What another generator lets come to rest."""

    def scene(seed: int) -> Ground:
        _, resting = make(seed)
        with resting.world() as world:
            world.step(1)
            deep = [contact for contact in world.contacts() if contact.distance < -SUNK]
        pressed = frozenset(name for contact in deep for name in (contact.a, contact.b))
        poses = {body.name: (body, resting.poses[body.name]) for body in resting.bodies}
        centres = {name: move_points(body.centre_of_mass, pose) for name, (body, pose) in poses.items()}
        goods = [body for body in resting.bodies if body.name not in resting.fixed]
        return Ground({name: _mesh(*each) for name, each in poses.items()}, goods, centres, pressed)

    return scene


GENERATORS = {"blocks": _blocks, "designed": _settled(designed), "built": _settled(built)}


@dataclass(frozen=True)
class Case:
    """A scene, and what is true of it.

    Attributes:
        spoil: What was done to its object `odd`.
        scene: The scene, with meshes.
        truth: name -> verdict, of everything that can move.
        pressed: What the simulator pressed into something else by a few millimetres.
    """

    spoil: str
    scene: Scene
    truth: Mapping[str, str]
    pressed: frozenset[str] = frozenset()


def cases(generator: str, seed: int, count: int) -> Iterator[Case]:
    """Spoilt scenes of a generator, each spoil in turn."""
    for number in range(count):
        for kind, (spoil, make) in enumerate(SPOILS.items()):
            rng = np.random.default_rng([seed, number, kind])
            ground = GENERATORS[generator](FIRST_SEED + 1000 * seed + 100 * number + kind)
            added, verdict = make(rng, ground.goods[int(rng.integers(len(ground.goods)))])
            meshes = {
                "table": _box((2.4, 1.2, 0.04), np.array([0, 0, -0.02])),
                **ground.placed,
                **{name: _shifted(mesh, (AWAY, 0, 0)) for name, mesh in added.items()},
            }
            clouds = {name: _surface(mesh, rng) for name, mesh in meshes.items()}
            fixed = [name for name in meshes if name in FIXED]
            friction = {name: FRICTION[1] / OWN if name == "table" else OWN for name in meshes}
            known = {name: centre for name, centre in ground.centres.items() if name not in fixed}
            scene = Scene(clouds, fixed, (0, 0, 1), meshes=meshes, friction=friction, centres=known)
            truth = {n: "penetrates" if n in ground.pressed else "stands" for n in scene.movable}
            truth["odd"] = verdict
            if verdict == "penetrates" and "base" in added:
                truth["base"] = verdict
            yield Case(spoil, scene, truth, ground.pressed)


def _surface(mesh: Mesh, rng: np.random.Generator) -> FloatArray:
    import trimesh

    whole = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    points: FloatArray = trimesh.sample.sample_surface(whole, POINTS, seed=int(rng.integers(1 << 30)))[0]  # type: ignore[assignment]
    return np.concatenate([points, mesh.vertices])


def as_cloud(scene: Scene, rng: np.random.Generator) -> Scene:
    """The same as noisy clouds."""
    noisy = {name: cloud + rng.normal(0, NOISE, cloud.shape) for name, cloud in scene.clouds.items()}
    return Scene(noisy, sorted(scene.fixed), scene.up, friction=scene.friction)


def rows(quick: bool, seed: int, progress: Progress) -> list[dict[str, Any]]:
    """Measure.

    Args:
        quick: Fewer scenes.
        seed: Transfers on to other scenes.
        progress: Called before each part.
    """
    spoilt: dict[str, Counter[tuple[str, bool]]] = {"meshes": Counter(), "clouds": Counter()}
    told: dict[str, Counter[tuple[str, str]]] = {"meshes": Counter(), "clouds": Counter()}
    wrong: dict[str, list[str]] = {"meshes": [], "clouds": []}
    for generator in GENERATORS:
        for number, case in enumerate(cases(generator, seed, 1 if quick else 4)):
            progress(f"{generator}: {number + 1}")
            rng = np.random.default_rng(number)
            for kind, scene in (("meshes", case.scene), ("clouds", as_cloud(case.scene, rng))):
                found = check(scene, margins=False).objects
                spoils, deep = (SMALL, frozenset[str]()) if kind == "meshes" else (IN_NOISE, case.pressed)
                hidden = deep.union({"odd", "base"} if case.spoil in spoils else ())
                for name, true in case.truth.items():
                    verdict = str(found[name].verdict)
                    right = verdict == true
                    if name == "odd":
                        spoilt[kind][case.spoil, right] += 1
                    if name not in hidden:
                        told[kind][true, verdict] += 1
                        if not right:
                            wrong[kind].append(f"{generator}, {case.spoil}: {found[name].sentence()}")
    return [row.to_json() for kind in spoilt for row in _rows(kind, spoilt[kind], told[kind], wrong[kind])]


def _rows(
    kind: str, spoilt: Mapping[tuple[str, bool], int], told: Mapping[tuple[str, str], int], wrong: list[str]
) -> Iterator[Row]:
    """The figures of one kind of scenes."""
    for spoil in SPOILS:
        held, tried = spoilt[spoil, True], spoilt[spoil, True] + spoilt[spoil, False]
        yield Row(f"right of those with one {spoil}", 100 * held / max(tried, 1), "%", column=kind)
    for verdict in ("penetrates", "floats", "tips", "slides"):
        right, said = told[verdict, verdict], sum(n for (_, told_as), n in told.items() if told_as == verdict)
        yield Row(f"precision of {verdict!r}", 100 * right / max(said, 1), "%", column=kind)
    bad = [(true, said, n) for (true, said), n in told.items()]
    failing = sum(n for true, _, n in bad if true != "stands")
    found = sum(n for true, said, n in bad if true == said != "stands")
    alarms = sum(n for _, said, n in bad if said != "stands")
    yield Row(
        f"{kind}: recall of what does not stand", 100 * found / max(failing, 1), "%", bar=BAR_RECALL,
        tried=failing, held=found, wrong=tuple(wrong[:12]),
    )  # fmt: skip
    yield Row(
        f"{kind}: precision of what is said not to stand", 100 * found / max(alarms, 1), "%",
        bar=BAR_PRECISION, tried=alarms, held=found,
    )  # fmt: skip
