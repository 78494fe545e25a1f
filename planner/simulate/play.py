"""The same asked of a physics engine: everything is put where it is, time starts, and what moved is told."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from topple.planner.simulate.lift import Move, move_between
from topple.planner.simulate.rebuild import ground_of, rebuild, shape_of
from topple.planner.simulate.tolerances import CONVEX, FLOOR_BELOW, PLAYED, STAYS, STAYS_TURNED
from topple.planner.stability.check import ObjectCheck, StabilityCheck
from topple.planner.stability.solids import solid_of
from topple.planner.stability.verdicts import Verdict
from topple.robots.engines import new_world
from topple.robots.world.bodies import Body
from topple.robots.world.body_clouds import shell
from topple.robots.world.physical_world import PhysicalWorld
from topple.topology.base.arguments import checked_arguments
from topple.topology.base.arrays import FloatArray
from topple.topology.geometry.sides import hull_volume
from topple.topology.io.geometry import sampled_mesh
from topple.topology.io.load import AnyScene
from topple.topology.scene.cloud import noise_and_spacing
from topple.topology.scene.friction import SURFACE
from topple.topology.scene.mesh import Mesh
from topple.topology.situation.situation import Situation
from topple.topology.statics.mesh_contact import Polyhedron


@dataclass(frozen=True)
class Played:
    """What became of a scene in simulation.

    Attributes:
        engine: What simulated it: "bullet" or "mujoco".
        moves: name -> how far it got, of what can move.
        disagreeing: Objects of which statics and simulation do not say the same: one that it stays, one not.
    """

    engine: str
    moves: Mapping[str, Move]
    disagreeing: tuple[str, ...]

    def to_json(self) -> dict[str, object]:
        """The part `played` of the JSON of `topple check --play`."""
        moved = {
            name: {"mm": round(1e3 * move.distance, 2), "degrees": round(float(np.degrees(move.angle)), 2)}
            for name, move in self.moves.items()
        }
        return {
            "engine": self.engine,
            "seconds": PLAYED,
            "moved": moved,
            "disagreeing": list(self.disagreeing),
        }


@checked_arguments
def play(scene: AnyScene | Situation, found: StabilityCheck) -> Played:
    """Let time start in a scene, and hold what moves against what was found by statics.

    Bodies are the pieces of their meshes, each convex; of whole clouds what these are surfaces of. Nothing
    is seated before: what floats falls. What cameras saw is completed and fitted to stand, as its undersides
    are not known. What is in each other is pushed apart, so that it is not held against anything.

    Args:
        scene: The scene that was checked.
        found: What `topple.check` found of it.

    Returns:
        How far everything moved in two seconds. What stands and moves by more than 1 cm or 10 degrees, and
        what does not and stays within a millimetre and a degree, is where the two disagree.

    Raises:
        NotInstalled: There is no physics engine.
    """
    situation = Situation.of(scene)
    with new_world() as world:
        if not found.exact and situation.sized.statics.upright.viewpoints is not None:
            rebuild(situation.sized.statics).fill(world)
        else:
            _fill(world, situation)
        before = world.poses()
        world.step(round(PLAYED / world.time_step))
        moves = {name: move_between(world, name, before[name], world.pose(name)) for name in before}
        engine = world.engine
    wrong = tuple(name for name, each in found.objects.items() if _disagree(each, moves[name]))
    return Played(engine, moves, wrong)


def _disagree(found: ObjectCheck, move: Move) -> bool:
    if found.verdict is Verdict.PENETRATES:
        return False
    return move.share > 1.0 if found.stands else not move.beyond(STAYS, STAYS_TURNED)


def _fill(world: PhysicalWorld, situation: Situation) -> None:
    """Put everything where it is, with a floor far below."""
    scene, sized = situation.scene, situation.sized
    upright, unit, lowest = sized.statics.upright, sized.unit, np.inf
    for name in scene.names:
        pieces = _pieces(name, situation)
        if not pieces:
            continue
        origin, fixed = np.mean([piece.mean(axis=0) for piece in pieces], axis=0), name in scene.fixed
        body = Body.of(
            name,
            [piece - origin for piece in pieces],
            mass=None if fixed else sized.statics.weights[name].mass * unit**3,
            friction=scene.friction.get(name, SURFACE),
        )
        if name in scene.centres:
            body = replace(body, centre_of_mass=upright.rotation @ scene.centres[name] - origin)
        pose = np.eye(4)
        pose[:3, 3] = origin
        world.add(body, pose, fixed=fixed)
        lowest = min(lowest, *(float(piece[:, 2].min()) for piece in pieces))
    world.add_floor(lowest - FLOOR_BELOW)


def _pieces(name: str, situation: Situation) -> list[FloatArray]:
    """Corners (V, 3) of the convex parts of an object, upright [m]."""
    scene, sized = situation.scene, situation.sized
    upright, unit = sized.statics.upright, sized.unit
    if name in scene.meshes and name not in scene.models:
        return _parts(scene.meshes[name], upright.rotation)
    cloud = sized.scene.clouds[name] @ upright.rotation.T
    smoothest = min(noise_and_spacing(sized.scene.clouds[each])[0] for each in scene.movable)
    solid = solid_of(cloud, smoothest, noise_and_spacing(cloud)[1])
    if solid is not None:
        return [solid.vertices * unit]
    shape = ground_of(upright, name, -np.inf) if name in scene.fixed else shape_of(name, sized.statics)
    return [piece.corners * unit for piece in shape]


def _parts(mesh: Mesh, rotation: FloatArray) -> list[FloatArray]:
    """Parts of a mesh that hang together, each as its hull, or along its walls where that fills a hollow."""
    solid = Polyhedron.of(mesh, rotation, mesh.vertices)
    sides = solid.faces[:, [0, 1, 1, 2]].reshape(-1, 2)
    count = len(solid.vertices)
    linked = coo_array((np.ones(len(sides)), sides.T), shape=(count, count))
    number = connected_components(linked, directed=False)[1]
    found: list[FloatArray] = []
    for k in np.unique(number[solid.faces[:, 0]]):
        faces = solid.faces[number[solid.faces[:, 0]] == k]
        part = replace(solid, faces=faces)
        corners = solid.vertices[np.unique(faces)]
        filled = hull_volume(corners)
        if part.signed_volume >= CONVEX * filled:
            found.append(corners)
        else:
            samples = sampled_mesh(solid.vertices, faces)
            found += [piece.corners for piece in shell(samples, samples, None)]
    return found
