"""One look at the world: depth images, clouds, relations, and what of it was not expected."""

import time
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain
from typing import Protocol, runtime_checkable

import numpy as np

from topple.planner.execution.associate import associate_names, middle, seen_through
from topple.planner.execution.frames import Eye, Frames
from topple.planner.execution.masks import name_faults, rename
from topple.planner.execution.tolerances import COARSE, FINE, GONE, MOVED, THERE
from topple.planner.formats.pictures import picture
from topple.robots.driver import Driver
from topple.robots.world.camera import Camera
from topple.robots.world.physical_world import PhysicalWorld
from topple.topology.base.arguments import checked_arguments
from topple.topology.base.arrays import FloatArray
from topple.topology.bodies.solids import up_of
from topple.topology.bodies.tops import tops_of
from topple.topology.geometry.thin import thinned
from topple.topology.relations.relate import Relations
from topple.topology.scene.cloud import clean
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation
from topple.topology.sixim.table import Relation
from topple.topology.views.image import DepthImage, Photo, said_of_images

Relate = Callable[[Scene], Relations]


@dataclass(frozen=True, eq=False)
class Look:
    """One look at the world and what follows from it.

    Attributes:
        images: What the cameras took.
        situation: What is seen, and what was seen before and may be hidden now, and what was read of it.
        picture: PNG bytes of the first camera's view, or None.
        photo: The same taken for people, where that was asked for.
        taken: When its pictures were there [s], by `time.perf_counter`.
        surprises: What was not as expected, by name, in sentences: newly seen, moved, hidden or gone.
        faults: What was wrong with cameras and masks and was put right or left out, in sentences.

    Examples:
        >>> with new_world() as world:
        ...     world.add(Body.of("crate", [corners]))
        ...     look = Observer(world, around((0, 0, 0)), np.random.default_rng(0), ()).look()
        >>> len(look.images), look.scene.names, look.faults
        (3, ('crate',), ())
    """

    images: tuple[DepthImage, ...]
    situation: Situation
    picture: bytes | None
    surprises: Mapping[str, str] = field(default_factory=dict[str, str])
    faults: tuple[str, ...] = ()
    photo: Photo | None = None
    taken: float = field(default_factory=time.perf_counter)

    @property
    def scene(self) -> Scene:
        """The clouds."""
        return self.situation.scene

    @property
    def relations(self) -> Relations:
        """The relations of the clouds."""
        return self.situation.relations


@runtime_checkable
class Perception(Protocol):
    """Whatever looks at a scene: simulated cameras, or those of a robot.

    Examples:
        >>> with new_world() as world:
        ...     isinstance(Observer(world, around((0, 0, 0)), np.random.default_rng(0), ()), Perception)
        True
    """

    def look(self, expected: Scene | None = None, more: Sequence[DepthImage] = ()) -> Look:
        """Look now; `expected` is the scene as it should be, `more` are pictures just taken of it besides."""
        ...


@checked_arguments
@dataclass
class Observer:
    """Looks at a world through depth cameras, and remembers what it saw.

    Attributes:
        world: The world.
        cameras: At least one.
        rng: Of their noise.
        fixed: Names that never move.
        up: (3,) up direction in the world.
        masses: Masses [kg] by name of what was weighed, seen or not.
        friction: Coefficients of surfaces by name of what was tried, seen or not.
        shuffle_labels: Whether names of objects are not kept between looks: what is seen is matched with what
            is expected, by place and shape.
        relate: What relates what is seen; topple's own rule where None.
        photographer: What takes photos for people of the world, for a report; None takes none.
        robots: Those in the pictures: what is seen at them is nobody's, and what else has no mask is matter;
            None where that is not known, and nothing is.
        period: Time between pictures that the cameras stream in turn [s].

    Examples:
        >>> with new_world() as world:
        ...     world.add(Body.of("crate", [corners]))
        ...     observer = Observer(world, around((0, 0, 0)), np.random.default_rng(0), ())
        ...     observer.look().scene.names
        ('crate',)
    """

    world: PhysicalWorld
    cameras: Sequence[Eye]
    rng: np.random.Generator
    fixed: tuple[str, ...]
    up: FloatArray = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    masses: Mapping[str, float] = field(default_factory=dict[str, float])
    friction: Mapping[str, float] = field(default_factory=dict[str, float])
    shuffle_labels: bool = False
    relate: Relate | None = None
    photographer: Callable[[], Photo] | None = None
    robots: Sequence[Driver] | None = None
    period: float = 1.0 / 15.0

    def __post_init__(self) -> None:
        self._frames = Frames(self.cameras)
        self._last: Scene | None = None
        self._glimpsed, self._turn, self._stream = -self.period, -1, self.rng.spawn(1)[0]
        self._kept: tuple[DepthImage, ...] = ()  # taken by another camera, of what is still as it was then

    def look(self, expected: Scene | None = None, more: Sequence[DepthImage] = ()) -> Look:
        """Takes a picture with every camera and relates what is seen.

        Args:
            more: Pictures that another camera took just now. What they show counts until it is moved.
            expected: The scene as it should be by now. Of what no camera sees any more, its cloud is kept
                until a camera sees through the place where it should be.

        Returns:
            The look. A camera that delivers no picture of now is left out, and masks that swapped their names
            or fell into pieces since the last look are put right; `faults` says so.

        Raises:
            InvalidInput: No camera sees anything, or they never saw the table.
        """
        images, faults = self._frames.take(self.world, self.rng, changed=expected is not self._last)
        background = np.concatenate([image.background() for image in images])
        photo = None if self.photographer is None else self.photographer()
        taken = time.perf_counter()
        images = (*images, *more)
        if expected is None:  # the first look stands for all
            faults = (*faults, *said_of_images(images))
        kept = self._kept
        if self.shuffle_labels and expected is not None:
            images = associate_names(images, expected, self.rng)
        scene = self._scene(images)
        surprises: dict[str, str] = {}
        if expected is not None:
            names, wrong = name_faults(scene, expected)
            if names:
                images = tuple(rename(image, names) for image in images)
                scene, faults = self._scene(images), (*faults, *wrong.values())
            scene, surprises = _join_remembered(scene, expected)
            kept = tuple(image for each in kept if (image := _strip(each, self._last, expected, surprises)))
            if kept:
                images = (*images, *kept)
                scene, _ = _join_remembered(self._scene(images), expected)
        self._kept = (*kept, *more)
        if self.robots is not None:
            own = (r.arm.bodies(r.q_target, r.pose_base_to_world, r.tool_state) for r in self.robots)
            scene = scene.with_unnamed(background, chain.from_iterable(own), things=False)
        scene = scene.weighed(_among(self.masses, scene), _among(self.friction, scene))
        self._last = scene
        relations = None if self.relate is None else self.relate(scene)
        shown = _picture_bytes(images[0]) if photo is None else picture(photo.rgb)
        return Look(images, Situation(scene, relations), shown, surprises, faults, photo, taken)

    def glimpse(self) -> Sequence[DepthImage]:
        """A coarse picture, as cameras stream them in turn, where one came since the last time."""
        if self.world.time < self._glimpsed + self.period - self.world.time_step / 2.0:
            return ()
        self._glimpsed, self._turn = self.world.time, (self._turn + 1) % len(self.cameras)
        eye = self.cameras[self._turn]
        return ((eye.coarse() if isinstance(eye, Camera) else eye).look(self.world, self._stream),)

    def _scene(self, images: Sequence[DepthImage]) -> Scene:
        fixed = [name for name in self.fixed if any(name in image.names.values() for image in images)]
        return _thin_scene(Scene.from_images(images, fixed=fixed, up=self.up, unnamed=False))


def _strip(
    image: DepthImage, last: Scene | None, now: Scene, surprises: Collection[str]
) -> DepthImage | None:
    """A picture from before without what was moved since, or is not as expected; None if nothing is left."""
    before = now if last is None else last
    stays = [
        name
        for name, cloud in now.clouds.items()
        if name not in surprises and before.clouds.get(name) is cloud
    ]
    kept = np.isin(image.label, [number for number, name in image.names.items() if name in stays])
    if not kept.any():
        return None
    names = {number: name for number, name in image.names.items() if name in stays}
    depth, label = np.where(kept, image.depth, 0.0), np.where(kept, image.label, 0)
    return replace(image, depth=depth, label=label, names=names)


def _join_remembered(seen: Scene, expected: Scene) -> tuple[Scene, dict[str, str]]:
    """Join the seen and the expected scene, and say how they differ."""
    new = [name for name in seen.names if name not in expected.names]
    said = {name: f"{name} is seen for the first time" for name in new}
    clouds = dict(seen.clouds)
    fixed = set(seen.fixed)
    for name, cloud in expected.clouds.items():
        if name in clouds:
            way = float(np.linalg.norm(middle(clouds[name]) - middle(cloud)))
            if way > MOVED and name not in fixed and _has_moved(clouds[name], cloud):
                said[name] = f"{name} is {1e3 * way:.0f} mm from where it should be"
        elif name in expected.fixed:
            clouds[name], fixed = cloud, fixed | {name}
        elif seen_through(cloud, seen.images).mean() > GONE:
            said[name] = f"{name} is not where it should be, and seen nowhere"
        else:
            clouds[name] = cloud
            unclaimed = _something_at(cloud, seen.images)
            why = "no mask shows it, though something is seen there" if unclaimed else "it is hidden"
            said[name] = f"{name} is taken to be where it should be: {why}"
    order = [name for name in (*expected.names, *seen.names) if name in clouds]
    joined = Scene(
        {name: clouds[name] for name in dict.fromkeys(order)},
        fixed=[name for name in dict.fromkeys(order) if name in fixed],
        up=seen.up,
        viewpoints=seen.viewpoints,
        images=seen.images,
        assumptions=seen.assumptions,
        matter=seen.matter,
    )
    return joined.weighed(_among(expected.masses, joined), _among(expected.friction, joined)), said


def _something_at(cloud: FloatArray, images: Sequence[DepthImage]) -> bool:
    """Whether some camera sees a surface where a cloud should be."""
    return any((np.abs(image.depth_past(cloud)) < MOVED).mean() > THERE for image in images)


def _among(values: Mapping[str, float], scene: Scene) -> dict[str, float]:
    """Select the values of a scene's objects."""
    return {name: value for name, value in values.items() if name in scene.clouds}


def _has_moved(now: FloatArray, before: FloatArray) -> bool:
    """Whether much of a cloud lies where there was nothing of it before, or the other way round.

    An object of which other sides are seen now has not moved.
    """
    from topple.topology.kernels.neighbours import PointTree

    away = np.quantile(PointTree(before).query(now)[0], 0.9)
    back = np.quantile(PointTree(now).query(before)[0], 0.9)
    return bool(min(away, back) > MOVED)


def without(look: Look, gone: Collection[str]) -> Look:
    """A look without what is none of the scene's any more, though a camera may see it in its bin."""
    names = [name for name in look.scene.names if name in gone]
    said = {name: text for name, text in look.surprises.items() if name not in gone}
    return replace(look, situation=look.situation.without(*names), surprises=said) if names else look


def find_unexpected(predicted: Relations, observed: Relations) -> list[str]:
    """Pairs that were predicted apart and are seen in contact, or the other way round.

    Pairs that either side has not seen well enough to tell are left out.

    Args:
        predicted: Relations of the scene as it should be.
        observed: Relations of the scene as it is seen.

    Returns:
        One line a pair.
    """
    found: list[str] = []
    for pair in predicted.pairs:
        if pair.a not in observed.objects or pair.b not in observed.objects:
            found.append(f"{pair.a} and {pair.b}: one of them is not seen any more")
            continue
        now = observed.between(pair.a, pair.b)
        apart = pair.relation is Relation.DISJOINT
        if apart != (now.relation is Relation.DISJOINT) and pair.observed and now.observed:
            found.append(f"{pair.a} and {pair.b}: {pair.relation} expected, {now.relation} seen")
    return found


def _picture_bytes(image: DepthImage) -> bytes | None:
    return None if image.rgb is None else picture(image.rgb)


def _thin_scene(scene: Scene) -> Scene:
    """The scene without strays, and with as many points as decisions need: a table comes with 300 000."""
    for name, cloud in scene.clouds.items():
        cloud = thinned(cloud, FINE)
        tops = tops_of(cloud, up_of(scene)).tops if name in scene.fixed else ()
        table = any(not top.walled for top in tops)
        scene = scene.with_cloud(name, clean(thinned(cloud, COARSE) if table else cloud))
    return scene
