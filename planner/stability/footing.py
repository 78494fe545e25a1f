"""What a scene stands on: weights, contacts, what is in each other, from exact meshes or from clouds."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from topple.planner.stability.solids import solid_of
from topple.planner.stability.tolerances import (
    BESIDES,
    CLOUD_EDGE,
    CLOUD_SINKS,
    CLOUD_TOUCHES,
    DEEPEST,
    EXACT,
    FACET,
    ROLLS,
    SINKS,
    SOLID_EDGE,
    TOUCHES,
)
from topple.topology.base.arrays import FloatArray
from topple.topology.bodies.upright import Upright
from topple.topology.geometry.broadphase import near_pairs
from topple.topology.geometry.sides import beyond, sides_of
from topple.topology.io.geometry import sampled_mesh
from topple.topology.scene.cloud import noise_and_spacing
from topple.topology.scene.friction import friction_between
from topple.topology.scene.mesh import Mesh
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation
from topple.topology.statics.contact import Contact
from topple.topology.statics.equilibrium import Weight
from topple.topology.statics.faces import faces_of
from topple.topology.statics.grounds import planes_and_rest
from topple.topology.statics.mesh_contact import Polyhedron, depth, drop, mesh_contact
from topple.topology.statics.rest import within_reach
from topple.topology.statics.tolerances import DENSITY, FACING, GUESSED, LEVER, UNSTEADY


@dataclass(frozen=True, eq=False)
class Footing:
    """What holds a scene up.

    Attributes:
        weights: Of the movable objects.
        contacts: Patches that carry.
        unseen: Patches that no camera saw and there must be.
        depths: (a, b) -> how far two are in each other [m], where that is more than noise; both ways.
        drops: name -> {other: how far it is above that [m]}, for what nothing carries.
        tops: Height [m] of the highest point of each movable object, in the frame of the contacts.
        lenience: name -> share of its weight that may be missing of the forces on it, for what noise hides.
        rotation: (3, 3) rows are the axes of the frame of the contacts, whose z is up.
        unit: What a metre of that frame stands for [m].
        exact: Whether it is of meshes.
    """

    weights: Mapping[str, Weight]
    contacts: tuple[Contact, ...]
    unseen: tuple[Contact, ...]
    depths: Mapping[tuple[str, str], float]
    drops: Mapping[str, Mapping[str, float]]
    tops: Mapping[str, float]
    lenience: Mapping[str, float]
    rotation: FloatArray
    unit: float
    exact: bool

    @staticmethod
    def of(situation: Situation) -> "Footing":
        """Find the footing of a scene: that of its meshes, where everything has one or is a flat table.

        Raises:
            InvalidInput: The scene has no `up`.
        """
        scene = situation.scene
        if any(name not in scene.meshes or name in scene.models for name in scene.movable):
            return _of_clouds(situation)
        upright = Upright.of(scene)
        solids = {name: _polyhedron(name, scene, upright) for name in scene.names}
        known = {name: solid for name, solid in solids.items() if solid is not None}
        return (
            _of_meshes(scene, known, upright.rotation) if len(known) == len(solids) else _of_clouds(situation)
        )

    @staticmethod
    def carries(contact: Contact, name: str) -> bool:
        """Whether a contact pushes one of its two bodies up, somewhere."""
        rising = contact.normals[:, 2] if contact.b == name else -contact.normals[:, 2]
        return bool(rising.max() > BESIDES)

    def carriers(self, name: str, contacts: Iterable[Contact]) -> list[str]:
        """Names of the bodies that push an object up."""
        meeting = [contact for contact in contacts if name in (contact.a, contact.b)]
        rising = [contact for contact in meeting if self.carries(contact, name)]
        return list(dict.fromkeys(c.a if c.b == name else c.b for c in rising))


def _polyhedron(name: str, scene: Scene, upright: Upright) -> Polyhedron | None:
    """The mesh of an object, a wide board for a flat table without one; None where neither has an area."""
    if name in scene.meshes and name not in scene.models:
        solid = Polyhedron.of(scene.meshes[name], upright.rotation, scene.clouds[name])
        return solid if len(solid.faces) else None
    planes, rest = planes_and_rest(upright, name)
    if len(planes) != 1 or len(rest):
        return None
    (plane,) = planes
    (x, y), (u, v) = plane.lower[:2], plane.upper[:2]
    level = np.array([[x, y], [u, y], [u, v], [x, v]])
    heights = -(level @ plane.normal[:2] + plane.offset) / plane.normal[2]
    corners = np.column_stack([level, heights]) @ upright.rotation
    return Polyhedron.of(
        Mesh(corners, np.array([[0, 1, 2], [0, 2, 3]])), upright.rotation, scene.clouds[name]
    )


def _of_meshes(scene: Scene, solids: Mapping[str, Polyhedron], rotation: FloatArray) -> Footing:
    weights: dict[str, Weight] = {}
    for name in scene.movable:
        volume, centre = solids[name].volume_and_centre
        mass = scene.masses.get(name, volume * DENSITY)
        centre = rotation @ scene.centres[name] if name in scene.centres else centre
        weights[name] = Weight(1e3 * max(mass, 1e-9) / DENSITY, centre, LEVER)
    contacts, depths = _meetings(scene, solids, TOUCHES, SINKS)
    tops = {name: float(solids[name].vertices[:, 2].max()) for name in weights}
    lenience = {name: ROLLS if name in _round(contacts) else EXACT for name in weights}
    footing = Footing(weights, tuple(contacts), (), depths, {}, tops, lenience, rotation, 1.0, True)
    loose = [name for name in weights if not footing.carriers(name, contacts)]
    return replace(footing, drops={name: _drops(name, solids) for name in loose})


def _meetings(
    scene: Scene, solids: Mapping[str, Polyhedron], touch: float, sink: float
) -> tuple[list[Contact], dict[tuple[str, str], float]]:
    """Contacts of polyhedra up to a gap and down to a depth [m], and what is deeper than that."""
    lower, upper = np.reshape([solid.box for solid in solids.values()], (-1, 2, 3)).swapaxes(0, 1)
    names = list(solids)
    contacts: list[Contact] = []
    depths: dict[tuple[str, str], float] = {}
    for i, j in near_pairs(lower, upper, touch).tolist():
        a, b = _lower_first(names[i], names[j], scene, solids)
        if a in scene.fixed and b in scene.fixed:
            continue
        deep = depth(solids[a], solids[b], DEEPEST)
        if deep > sink:
            depths[a, b] = depths[b, a] = deep
        friction = friction_between(scene.friction, a, b)
        contact = mesh_contact((a, b), solids[a], solids[b], touch, max(deep, sink), friction)
        contacts += [contact] if contact is not None else []
    return contacts, depths


def _round(contacts: Iterable[Contact]) -> frozenset[str]:
    """Names of bodies that stand on facets, or are stood on where they have some."""
    faceted = [c for c in contacts if ((c.turns > FACING) & (c.turns <= FACET)).any()]
    return frozenset(name for contact in faceted for name in (contact.a, contact.b))


def _lower_first(a: str, b: str, scene: Scene, solids: Mapping[str, Polyhedron]) -> tuple[str, str]:
    """Two names, what is fixed or lower first."""
    one, other = sorted((a, b), key=lambda n: (n not in scene.fixed, float(solids[n].vertices[:, 2].mean())))
    return one, other


def _drops(name: str, solids: Mapping[str, Polyhedron]) -> dict[str, float]:
    """How far an object is above others [m], where it is above them."""
    (lower, upper), found = solids[name].box, dict[str, float]()
    for other, solid in solids.items():
        low, high = solid.box
        if other != name and (low[:2] <= upper[:2]).all() and (high[:2] >= lower[:2]).all():
            gap = drop(solids[name], solid) if low[2] <= upper[2] else np.inf
            found |= {other: gap} if np.isfinite(gap) else {}
    return found


def _of_clouds(situation: Situation) -> Footing:
    sized = situation.sized
    statics, unit = sized.statics, sized.unit
    upright, weights = statics.upright, dict(statics.weights)
    cameras = upright.viewpoints is not None
    usable = within_reach(statics.contacts, weights)
    unseen = [contact for contact in usable if contact.inferred and cameras]
    seen: list[Contact] = [contact for contact in usable if not contact.inferred]
    depths: dict[tuple[str, str], float] = {}
    lenience = dict.fromkeys(weights, GUESSED)
    solids: dict[str, Polyhedron] = {}
    if not cameras:  # surfaces are whole, and faces can be held against each other
        raw = {name: cloud @ upright.rotation.T for name, cloud in sized.scene.clouds.items()}
        noise = min(noise_and_spacing(raw[name])[0] for name in weights)  # thin walls look like more
        for name, cloud in raw.items():
            solid = solid_of(cloud, noise, noise_and_spacing(cloud)[1])
            if solid is not None:
                samples = sampled_mesh(solid.vertices, solid.faces)
                solids[name] = Polyhedron.of(solid, np.eye(3), samples)
        for name in solids.keys() & weights.keys() - sized.scene.centres.keys():
            weights[name] = replace(weights[name], centre=solids[name].volume_and_centre[1])
        met, depths = _meetings(sized.scene, solids, CLOUD_TOUCHES + noise, CLOUD_SINKS + noise)
        others = [c for c in statics.contacts if not c.inferred and not {c.a, c.b} <= solids.keys()]
        faces = {(c.a, c.b): faces_of(c, raw, upright, noise) for c in others}
        for (a, b), face in faces.items():
            if face is not None and face.gap < -CLOUD_SINKS - 2 * noise:
                depths[a, b] = depths[b, a] = -face.gap
        depths = {pair: unit * deep for pair, deep in depths.items()}
        kept = [(c, faces[c.a, c.b]) for c in seen if (c.a, c.b) in faces]
        near = CLOUD_TOUCHES + 2 * noise
        seen = [c if f is None else f.contact for c, f in kept if f is None or f.gap <= near]
        rough = {name for c in seen for name in (c.a, c.b)}
        seen += met
        lenience = dict.fromkeys(weights, (SOLID_EDGE + noise / 2) / LEVER)
        lenience |= {name: ROLLS for name in weights if name in _round(met)}
        lenience |= {n: min(UNSTEADY, (CLOUD_EDGE + 2 * noise) / LEVER) for n in weights if n in rough}
    tops = {name: float(statics.surfaces[name][:, 2].max()) for name in weights}
    rotation = upright.rotation
    footing = Footing(weights, tuple(seen), tuple(unseen), depths, {}, tops, lenience, rotation, unit, False)
    drops: dict[str, dict[str, float]] = {}
    for name in (name for name in weights if not footing.carriers(name, seen)):
        drops[name] = _cloud_drops(name, statics.surfaces, upright, unit)
        if name in solids:
            drops[name] |= {other: unit * gap for other, gap in _drops(name, solids).items()}
    return replace(footing, drops=drops)


def _cloud_drops(
    name: str, surfaces: Mapping[str, FloatArray], upright: Upright, unit: float
) -> dict[str, float]:
    """How far an object is above others [m], by the points that are over each other."""
    found: dict[str, float] = {}
    own = surfaces[name]
    outline = sides_of(own[:, :2])
    for other, points in surfaces.items():
        if other == name or outline is None:
            continue
        planes = planes_and_rest(upright, other)[0] if other in upright.fixed else ()
        gaps = [float(plane.heights(own).min()) for plane in planes if plane.over(own).any()]
        under = points[beyond(outline, points[:, :2]) < 0]
        if len(under):
            gaps.append(float(own[:, 2].min() - under[:, 2].max()))
        if gaps and max(gaps) > 0:
            found[other] = unit * max(gap for gap in gaps if gap > 0)
    return found
