"""A world rebuilt from a scene: bodies from the observed clouds, a table, and cameras to look again."""

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np

from topple.planner.execution.tolerances import EDGE, RELAX, RELAX_STEPS, SAGGED
from topple.planner.placement.base import choose_base
from topple.planner.report.palette import object_colours
from topple.planner.simulate.rebuild import Rebuilt, rebuild
from topple.robots.arm.arm import Arm
from topple.robots.driver import Fixture
from topple.robots.engines import fixture_in, new_world
from topple.robots.poses import inverse
from topple.robots.scenarios.scenario import around
from topple.robots.world.bodies import Body
from topple.robots.world.camera import Camera
from topple.robots.world.physical_world import PhysicalWorld
from topple.robots.world.tolerances import TABLE_FRICTION
from topple.topology.base.arrays import FloatArray
from topple.topology.base.checks import as_pose
from topple.topology.base.errors import InvalidInput
from topple.topology.bodies.matter import MATTER
from topple.topology.bodies.solids import fixed_parts, solids_of, up_of
from topple.topology.bodies.tops import lowest_in_use, tops_of
from topple.topology.scene.frame import in_frame
from topple.topology.scene.scene import Scene
from topple.topology.statics.rest import Statics

Z = np.array([0.0, 0.0, 1.0])
"""Up in a world."""


@dataclass(frozen=True, eq=False)
class Rehearsal:
    """A world in which a scene can be acted out, to be used with `with`.

    Attributes:
        world: The bodies at rest, z up, the table at height 0.
        cameras: Three around the objects.
        pose_base_to_world: (4, 4) where the arm stands.
        pose_scene_to_world: (4, 4) from the frame of the scene's clouds.
        base_searched: Whether the base was searched for.
        sagged: How far each body moved until it was at rest, name to [m]: what the clouds left open.
        fixture: What keeps some of them still; None where nothing does.
    """

    world: PhysicalWorld
    cameras: tuple[Camera, ...]
    pose_base_to_world: FloatArray
    pose_scene_to_world: FloatArray
    base_searched: bool
    sagged: dict[str, float]
    fixture: Fixture | None = None

    def __enter__(self) -> "Rehearsal":
        return self

    def __exit__(self, *_: object) -> None:
        self.world.close()

    def notes(self) -> tuple[str, ...]:
        """Tell a reader of the run where the base stands and what sagged, in sentences."""
        x, y, z = (inverse(self.pose_scene_to_world) @ self.pose_base_to_world)[:3, 3]
        how = "searched" if self.base_searched else "given"
        said = [f"the arm's base stands at {x:.3f} {y:.3f} {z:.3f} m in the scene ({how})"]
        moved = {name: way for name, way in self.sagged.items() if way > SAGGED}
        if moved:
            words = ", ".join(f"{name} {1e3 * way:.0f} mm" for name, way in sorted(moved.items()))
            said.append(f"bodies rebuilt from the clouds moved before they were at rest: {words}")
        return tuple(said)

    @classmethod
    def of(
        cls, scene: Scene, arm: Arm, base: FloatArray | None = None, clamped: Collection[str] = ()
    ) -> "Rehearsal":
        """Rebuild a scene.

        Args:
            scene: The scene, with `up` and at least one flat fixed object.
            arm: The arm that is to act in it.
            base: (4, 4) pose_base_to_scene; the scene's `robot_base`, or else searched for.
            clamped: Names that a fixture keeps where they were seen.

        Raises:
            InvalidInput: The scene does not know up, or nothing flat and level in it is fixed.
            NoBase: The arm reaches nothing from anywhere.
        """
        table, to_world = _level_table(scene)
        statics = Statics.of(in_frame(scene, to_world, Z))
        to_world[:3] = statics.upright.rotation @ to_world[:3]  # bodies are rebuilt along the table's sides
        level = in_frame(scene, to_world, Z)
        given = base if base is not None else scene.robot_base
        pose_base = choose_base(level, arm) if given is None else to_world @ as_pose(given, "base")
        world = new_world()
        try:
            rebuilt = _colour(rebuild(statics), level)
            rebuilt = replace(rebuilt, grounds=tuple(b for b in rebuilt.grounds if b.name != table))
            ground, more = _taken_apart(level, table)
            low, high = ground[:, :2].min(axis=0) - EDGE, ground[:, :2].max(axis=0) + EDGE
            size, centre = high - low, (high + low) / 2.0
            world.add_table(
                table,
                height=rebuilt.floor,
                size=(float(size[0]), float(size[1])),
                centre=(float(centre[0]), float(centre[1])),
                more=more,
                friction=scene.friction.get(table, TABLE_FRICTION),
            )
            if MATTER in (solids := solids_of(level)):
                world.add(Body.of(MATTER, solids[MATTER]), fixed=True)
            rebuilt.add_to(world)
            fixture = fixture_in(world, clamped)
            relax(world)
        except BaseException:
            world.close()
            raise
        sagged = {
            name: float(np.linalg.norm(world.pose(name)[:3, 3] - rebuilt.poses[name][:3, 3]))
            for name in world.movable
        }
        middle = np.mean([level.clouds[name].mean(axis=0) for name in level.movable], axis=0)
        cameras = around((float(middle[0]), float(middle[1]), 0.03))
        return cls(world, cameras, pose_base, to_world, given is None, sagged, fixture)


def _colour(rebuilt: Rebuilt, scene: Scene) -> Rebuilt:
    """The same bodies in the colours that pages and graphs give them, to be told apart in pictures."""
    shares = {name: np.divide(rgb, 255.0) for name, rgb in object_colours(scene.names, scene.fixed).items()}
    bodies = {
        name: body.colored((float(shares[name][0]), float(shares[name][1]), float(shares[name][2]), 1.0))
        for name, body in rebuilt.bodies.items()
    }
    return replace(rebuilt, bodies=bodies)


def relax(world: PhysicalWorld) -> None:
    """Lets overlapping bodies part slowly, without the speed that parting gives them, then settle."""
    for _ in range(RELAX):
        world.step(RELAX_STEPS)
        for name in world.movable:
            world.place(name, world.pose(name))
    world.settle(3.0)


def _taken_apart(level: Scene, table: str) -> tuple[FloatArray, list[FloatArray]]:
    """Points (N, 3) of the top at height 0, and the parts (V, 3) of the table that rise above it [m]."""
    cloud, up = level.clouds[table], up_of(level)
    found = tops_of(cloud, up)
    if found.flat or not found.tops:
        return cloud, []
    ground = min(found.tops, key=lambda top: abs(top.height)).points
    return ground, [part for part in fixed_parts(cloud, up) if part[:, 2].max() > EDGE]


def _level_table(scene: Scene) -> tuple[str, FloatArray]:
    """The table's name and the (4, 4) pose_scene_to_world that lays it at height 0 under the objects."""
    up = up_of(scene)
    tables = {name: tops_of(scene.clouds[name], up).tops for name in sorted(scene.fixed)}
    tables = {name: tops for name, tops in tables.items() if tops}
    if not tables:
        raise InvalidInput(_no_table(scene))
    table = max(tables, key=lambda name: len(scene.clouds[name]))
    top = lowest_in_use(tables[table], [scene.clouds[name] for name in scene.movable])
    normal, height = top.normal, top.height
    x = np.cross([0.0, 1.0, 0.0] if abs(normal[1]) < 0.9 else [0.0, 0.0, 1.0], normal)
    x /= np.linalg.norm(x)
    pose = np.eye(4)
    pose[:3, :3] = np.stack([x, np.cross(normal, x), normal])
    names = scene.movable or scene.names
    middle = np.mean([scene.clouds[name].mean(axis=0) for name in names], axis=0)
    pose[:2, 3] = -(pose[:2, :3] @ middle)
    pose[2, 3] = -height
    return table, pose


def _no_table(scene: Scene) -> str:
    if not scene.fixed:
        return "nothing in the scene is fixed: name the table with fixed=NAME"
    names = ", ".join(repr(name) for name in sorted(scene.fixed))
    return f"fixed {names}: no level surface is seen: expected a table or the boards of a shelf"
