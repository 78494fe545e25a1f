"""Situation: a scene, and what is read of it, each part worked out once and only when it is asked for."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise

import networkx as nx
import numpy as np

from topple.topology.base.arguments import checked_arguments
from topple.topology.base.arrays import BoolArray, FloatArray, freeze
from topple.topology.bodies.completed import completed_bodies, with_level_undersides
from topple.topology.bodies.solids import Solids, move_parts, solids_of, up_of
from topple.topology.bodies.surfaces import carry_over, surfaces_of
from topple.topology.bodies.tolerances import GRAIN
from topple.topology.geometry.axes import level_axes
from topple.topology.geometry.hull import Hull
from topple.topology.geometry.rigid import move_points
from topple.topology.geometry.samples import sample
from topple.topology.io.load import AnyScene, as_scene
from topple.topology.relations.relate import Relations, relate
from topple.topology.scene.cloud import unit_of
from topple.topology.scene.frame import enlarge
from topple.topology.scene.scene import Scene
from topple.topology.situation.evidence import Evidence, Pixel
from topple.topology.sixim.table import classify
from topple.topology.statics.contact import Contact
from topple.topology.statics.rest import Statics
from topple.topology.statics.support import Support, supports
from topple.topology.statics.sweep import overlap, swept_matrix
from topple.topology.statics.tolerances import SHOWN
from topple.topology.statics.way_out import along, continued_boards, leads_up, way_out


@dataclass(frozen=True, eq=False)
class Situation:
    """A scene with its relations, and with gravity what follows from them.

    The relations are the one reading of the clouds: between two objects that they call disjoint there is no
    contact, and none carries, leans on or holds the other.

    Attributes:
        scene: What was seen; it knows where up is where contacts are asked for.
        known_relations: Relations that are known already, ours or somebody else's; None to work them out.
        known_solids: Convex parts of the objects where they are known already.
        known_completed: The same with the hidden sides, likewise.
        origin: What it came of by taking objects away or moving them: the other bodies are those still.
        unit: What a metre of its bodies stands for [m], see `sized`; lengths of its relations are true ones.

    Examples:
        >>> [(support.supporter, support.supported) for support in Situation(scene).supports]
        [('table', 'book'), ('book', 'cup')]
    """

    scene: Scene
    known_relations: Relations | None = None
    known_solids: Solids | None = field(default=None, repr=False)
    known_completed: Solids | None = field(default=None, repr=False)
    origin: "Change | None" = field(default=None, repr=False)
    unit: float = 1.0

    @staticmethod
    @checked_arguments
    def of(scene: "AnyScene | Situation", relations: Relations | None = None) -> "Situation":
        """A scene as a situation; a situation as it is, unless other relations are given.

        Args:
            scene: The scene, the path of one, or what is known of it.
            relations: Relations that are known already.
        """
        if isinstance(scene, Situation):
            return scene if relations is None else replace(scene, known_relations=relations)
        return Situation(as_scene(scene), relations)

    @cached_property
    def up(self) -> FloatArray:
        """(3,) unit vector against gravity.

        Raises:
            InvalidInput: The scene has no `up`.
        """
        return up_of(self.scene)

    @cached_property
    def relations(self) -> Relations:
        """The relation of every pair."""
        if self.known_relations is not None:
            return self.known_relations
        if self.origin is None or self.origin.pose is None:
            return relate(self.scene)
        before = self.origin.before
        while before.origin is not None and before.origin.pose is not None and not before.is_related:
            before = before.origin.before  # nobody has asked of those between
        return before.relations.followed(self.scene)

    @property
    def is_related(self) -> bool:
        """Whether the relations were worked out already."""
        return self.known_relations is not None or "relations" in vars(self)

    @cached_property
    def statics(self) -> Statics:
        """Completed bodies, their weights and contacts, in a frame whose z is up.

        Raises:
            InvalidInput: The scene has no `up`.
        """
        return Statics.of(self.scene, relations=self.relations)

    @cached_property
    def sized(self) -> "Situation":
        """The same with things as large as hands take, about which it is asked what falls and what is met.

        How far things lie apart, roll or move before it counts is told in millimetres, for things of some
        15 cm; nuts and crates are enlarged to that first. Itself where its things are neither.
        """
        unit = unit_of(self.scene)
        if unit == 1.0:
            return self
        return Situation(enlarge(self.scene, 1.0 / unit), self.relations, unit=unit)

    @property
    def movable(self) -> tuple[str, ...]:
        """Names that can move."""
        return self.scene.movable

    @property
    def surfaces(self) -> Mapping[str, FloatArray]:
        """The completed bodies: name -> (N, 3) upright points [m] of the whole surface."""
        return self.statics.surfaces

    @cached_property
    def solids(self) -> Solids:
        """Convex parts of every object in the world, as far as it was seen: what is kept clear of."""
        if self.known_solids is not None:
            return self.known_solids
        return solids_of(self.scene) if self.origin is None else self.origin.of(self.origin.before.solids)

    @cached_property
    def completed(self) -> Solids:
        """Convex parts with the hidden sides: how things stand and fall.

        Where nobody says from where the scene was seen nothing is hidden.
        """
        if self.known_completed is not None:
            return self.known_completed
        if self.origin is not None:
            return self.origin.of(self.origin.before.completed)
        if not len(self.scene.viewpoints):
            return self.solids
        to_world = self.statics.upright.rotation  # of rows
        guessed = [name for name in self.movable if name not in self.scene.whole]
        surfaces = {name: self.surfaces[name] @ to_world for name in guessed}
        return completed_bodies(self.scene.clouds, self.solids, surfaces)

    @property
    def contacts(self) -> tuple[Contact, ...]:
        """Patches between bodies that meet."""
        return self.statics.contacts

    @cached_property
    def supports(self) -> tuple[Support, ...]:
        """Supports between objects: see `topple.topology.statics.support.supports`."""
        return supports(self.statics, self.relations)

    def without(self, *names: str) -> "Situation":
        """Take objects away; the bodies of the others stay as they are.

        Args:
            names: The objects.
        """
        scene = self.scene
        for name in names:
            scene = scene.without(name)
        carry_over(scene, self.scene)
        return Situation(scene, origin=Change(self, frozenset(names)))

    def with_completed(self, name: str) -> "Situation":
        """The same with an object as it was completed in place of what was seen of it: how it stands.

        Args:
            name: The object.
        """
        body = self.completed[name]
        cloud = np.vstack([self.scene.clouds[name], sample(body, 2.0 * GRAIN)])
        bodies = {**self.solids, name: body}
        scene = self.scene.with_cloud(name, cloud).weighed(centres=self.scene.centres)
        return Situation(scene, known_solids=bodies, known_completed=self.completed)

    def moved(self, names: Collection[str], pose: FloatArray, more: FloatArray | None = None) -> "Situation":
        """The situation once objects were moved: they are rigid, and all else is where it was.

        Args:
            names: The objects.
            pose: (4, 4) rigid transform in the world.
            more: (N, 3) points of the first of them where it was [m] that will be seen besides.
        """
        scene, whole = self.scene, {name: pose for name in names}
        for name in names:
            cloud = scene.clouds[name]
            if more is not None:
                cloud, more = np.vstack([cloud, more]), None
                del whole[name]
            scene = scene.with_cloud(name, move_parts((cloud,), pose)[0])
            if name in self.scene.centres:
                scene = scene.weighed(centres={name: move_points(self.scene.centres[name][None], pose)[0]})
        carry_over(scene, self.scene, whole)
        return Situation(scene, origin=Change(self, frozenset(names), pose))

    def with_level_undersides(self) -> "Situation":
        """The same with the undersides of what stands levelled: see `topology.bodies.completed`.

        Where nothing is hidden it stays as it is.
        """
        if not len(self.scene.viewpoints):
            return self
        found = replace(
            self,
            known_relations=self.relations,
            known_solids=self.solids,
            known_completed=with_level_undersides(
                self.completed, set(self.movable) - self.scene.whole, self.up
            ),
        )
        vars(found)["statics"] = self.statics  # they are of the same clouds
        return found

    def shown(self, places: FloatArray, slack: float) -> BoolArray:
        """Which places cameras saw, a surface there, or what was moved or taken away from there since.

        Args:
            places: (N, 3) places in the world [m].
            slack: How far behind what was seen, or beside what was moved, a place may be [m].

        Returns:
            (N,) True for those; for all where no camera is known, since nothing is hidden then.
        """
        if self.origin is not None:
            found = self.origin.before.shown(places, slack)
            for part in (part for name in self.origin.names for part in self.origin.before.solids[name]):
                found[~found] = Hull.of(part).facet_distance(places[~found]) < slack
            return found
        bodies = surfaces_of(self.scene)
        if bodies.sight is None:
            return np.ones(len(places), dtype=np.bool_)
        return bodies.sight.shows(places @ bodies.upright.rotation.T, slack)

    def between(self, a: str, b: str) -> Evidence:
        """The relation of two objects as they lie, and where the pictures show it."""
        found = Evidence.of(self.relations.between(a, b))
        if not found.observed or not self.scene.images:
            return found
        patches = [each.points for each in self.contacts if {each.a, each.b} == {a, b} and not each.inferred]
        return replace(found, pixels=self._pixels(np.concatenate(patches), {a, b})) if patches else found

    def swept(self, name: str, other: str) -> Evidence:
        """The relation of an object, with all that it passes on its straight way out, to another one.

        Args:
            name: What is taken.
            other: What may be in its way.
        """
        axes, clouds = self.outwards(name), self.statics.upright.clouds
        body, met, own, seen = (
            along(axes, points)
            for points in (self.surfaces[name], self.surfaces[other], clouds[name], clouds[other])
        )
        over, shown = overlap(met, body), overlap(seen, own)
        gap = self.relations.between(name, other).gap if over is None else -over.evasion * self.unit
        pixels = () if shown is None else self._pixels(along(axes.T, shown.places), {other})
        relation = classify(swept_matrix(body, met))
        level = not self.goes_up(name)
        return Evidence(name, other, relation, gap, shown is not None, True, pixels, level)

    def _pixels(self, places: FloatArray, names: Collection[str]) -> tuple[Pixel, ...]:
        """Where pictures show one of upright places (N, 3) [m] as surface of an object named, one in each."""
        places = places @ self.statics.upright.rotation
        pixels: list[Pixel] = []
        for camera, image in enumerate(self.scene.images, 1):
            labels = image.labels_at(places, SHOWN)
            rows, columns, *_ = image.pixels_of(places)
            shown = [i for i, label in enumerate(labels) if label and image.name_of(label) in names]
            pixels += [(camera, int(rows[i]), int(columns[i])) for i in shown[:1]]
        return tuple(pixels)

    def way_out(self, name: str) -> FloatArray:
        """(3,) unit vector along which an object goes when taken: `up`, unless something fixed bars it."""
        return self.way_out_from(self.scene.clouds[name])

    def way_out_from(self, points: FloatArray) -> FloatArray:
        """(3,) unit vector likewise of something whose points (N, 3) are elsewhere."""
        nothing_over = float((points @ self.up).max()) > self._highest
        return self.up if nothing_over else way_out(points, self._fixed_points, self.up)

    def goes_up(self, name: str) -> bool:
        """Whether the way out of an object is up, and not level."""
        return leads_up(self.way_out(name), self.up)

    def outwards(self, name: str) -> FloatArray:
        """(3, 3) axes of the upright frame, the rows, of which the third is the way out of an object."""
        out = self.statics.upright.rotation @ self.way_out(name)
        return np.eye(3) if self.goes_up(name) else np.stack([*level_axes(out), out])

    @cached_property
    def _highest(self) -> float:
        """Height of the highest fixed point along `up` [m]."""
        return float((self._fixed_points @ self.up).max(initial=-np.inf))

    @cached_property
    def _fixed_points(self) -> FloatArray:
        """(N, 3) points of all that never moves, and where its boards may go on [m]."""
        clouds = [self.scene.clouds[name] for name in sorted(self.scene.fixed)]
        bodies = surfaces_of(self.scene)
        if bodies.sight is not None:
            sight, to_upright = bodies.sight, bodies.upright.rotation.T
            clouds += [
                continued_boards(cloud, self.up, lambda p: sight.empty(p @ to_upright)) for cloud in clouds
            ]
        return freeze(np.concatenate([np.empty((0, 3)), *clouds]))

    @cached_property
    def islands(self) -> Mapping[str, frozenset[str]]:
        """The movable objects in contact with each, or with others that are, itself among them, by name."""
        return {n: part for part in map(frozenset, nx.connected_components(self._graph)) for n in part}

    def chain(self, a: str, b: str) -> tuple[Evidence, ...]:
        """The relations by which two movable objects hang together, through as few others as possible.

        Args:
            a: One of them.
            b: The other one.

        Returns:
            The relation of each to the next, from a to b; empty where they do not.
        """
        if b not in self.islands[a]:
            return ()
        path = nx.shortest_path(self._graph, a, b)
        return tuple(self.between(one, other) for one, other in pairwise(path))

    @cached_property
    def _graph(self) -> "nx.Graph[str]":
        """The movable objects, those in contact joined."""
        graph: nx.Graph[str] = nx.Graph()
        graph.add_nodes_from(self.movable)
        for a, b in sorted(map(sorted, self.relations.meeting)):
            if a in graph and b in graph:
                graph.add_edge(a, b)
        return graph


@dataclass(frozen=True, eq=False)
class Change:
    """How a situation came of another one.

    Attributes:
        before: The other one.
        names: What was taken away or moved.
        pose: (4, 4) rigid transform in the world by which they were moved; None where they were taken away.
    """

    before: Situation
    names: frozenset[str]
    pose: FloatArray | None = None

    def of(self, bodies: Solids) -> Solids:
        """Bodies from before as they are now."""
        if self.pose is None:
            return {name: parts for name, parts in bodies.items() if name not in self.names}
        return {n: move_parts(parts, self.pose) if n in self.names else parts for n, parts in bodies.items()}
