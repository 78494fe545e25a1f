"""Scene: named clouds, what never moves, which way is up, and from where it was seen."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from topple.topology.base.arguments import checked_arguments
from topple.topology.base.arrays import Bodies, FloatArray, freeze
from topple.topology.base.checks import (
    Names,
    as_clouds,
    as_direction,
    as_name,
    as_names,
    as_points,
    as_pose,
    as_viewpoints,
    check_unit,
    duplicates,
    numeric,
)
from topple.topology.base.errors import InvalidInput, UnknownObject
from topple.topology.base.notebook import in_cell, in_words
from topple.topology.base.tolerances import FEWEST_SEEN
from topple.topology.base.values import ByValue, FrozenDict, all_but
from topple.topology.geometry.plane import up_from_fixed
from topple.topology.scene.amounts import as_centres, as_friction, as_masses
from topple.topology.scene.background import table_among, unnamed_among, without_bodies
from topple.topology.scene.mesh import Mesh
from topple.topology.scene.model_fit import ModelFit
from topple.topology.scene.write import write_clouds
from topple.topology.views.agreement import check_views
from topple.topology.views.image import DepthImage, check_depth, said_of_images
from topple.topology.views.wrong_masks import WrongMask, wrong_masks


@checked_arguments
@dataclass(frozen=True, eq=False, init=False)
class Scene(ByValue):
    """Objects as point clouds in one frame; a Scene that exists has been checked.

    Attributes:
        clouds: Points (N, 3) in [m] per object, read-only, in the order given.
        fixed: Names of the objects that never move: table, shelf.
        up: Unit vector (3,) against gravity, or None where nobody knows.
        viewpoints: Camera centres (k, 3) in [m], k >= 0, in the frame of the clouds.
        images: Depth images the clouds came from, if any.
        meshes: Triangle meshes in world coordinates of the objects that have one.
        robot_base: Pose (4, 4) of the robot's base in the world, or None.
        assumptions: Plain sentences on what was assumed and not given.
        masses: Masses in [kg] of the objects that were weighed; any others are guessed from their volume.
        friction: Coulomb coefficients of surfaces that were tried; two that touch have the product.
        models: How known models were laid onto what was seen of objects (`topple.topology.with_models`).
        matter: Points (N, 3) in [m], about 1 cm apart, of what is no object and in the way: walls, screens.
        wrong_masks: Masks of the images that are wrong in kind, where these were asked (`examined`).
        centres: Centres of mass (3,) [m] where known; of any other object the density is taken as even.

    Examples:
        >>> Scene({"table": corners * [9, 9, 0], "cup": corners}, fixed=["table"]).movable
        ('cup',)
    """

    clouds: Mapping[str, FloatArray]
    fixed: frozenset[str]
    up: FloatArray | None
    viewpoints: FloatArray
    images: tuple[DepthImage, ...]
    meshes: Mapping[str, Mesh]
    robot_base: FloatArray | None
    assumptions: tuple[str, ...]
    masses: Mapping[str, float]
    friction: Mapping[str, float]
    models: Mapping[str, ModelFit]
    matter: FloatArray
    wrong_masks: tuple[WrongMask, ...]
    centres: Mapping[str, FloatArray]

    def __init__(
        self,
        clouds: Mapping[str, ArrayLike],
        fixed: Names = (),
        up: ArrayLike | None = None,
        viewpoints: ArrayLike | None = None,
        images: Sequence[DepthImage] = (),
        meshes: Mapping[str, Mesh] | None = None,
        robot_base: ArrayLike | None = None,
        assumptions: Iterable[str] = (),
        masses: Mapping[str, float] | None = None,
        friction: Mapping[str, float] | None = None,
        models: Mapping[str, ModelFit] | None = None,
        matter: ArrayLike | None = None,
        wrong_masks: Iterable[WrongMask] = (),
        centres: Mapping[str, ArrayLike] | None = None,
    ) -> None:
        """Check everything and keep read-only copies.

        Args:
            clouds: Points (N, 3) in [m] per object; at least one object, no cloud empty.
            fixed: Names of the objects that never move.
            up: Direction (3,) against gravity, of any length.
            viewpoints: Camera centres (k, 3) in [m], in the frame of the clouds.
            images: Depth images the clouds came from.
            meshes: Meshes in world coordinates, for objects that have a cloud.
            robot_base: Rigid pose (4, 4) base to world.
            assumptions: Sentences on what was assumed.
            masses: Masses in [kg], above 0, of objects that have a cloud; of all, of some or of none.
            friction: Coulomb coefficients, 0 to 10, of the surfaces of objects that have a cloud.
            models: Fits of known models to objects that have a cloud.
            matter: Points (N, 3) in [m] of what is no object and in the way, about 1 cm apart.
            wrong_masks: Masks of the images that are wrong in kind.
            centres: Centres of mass (3,) in [m], in the frame of the clouds, of objects that have a cloud.

        Raises:
            InvalidInput: If anything is not what it should be; names the object.
            UnknownObject: If any of these names an object without a cloud.
        """
        checked, fixed = as_clouds(clouds), as_names(fixed)
        for name in fixed:
            if name not in checked:
                raise UnknownObject(name, checked, role="fixed object")
        for role, named in (("object with a mesh", meshes), ("object with a model", models)):
            for name in named or {}:
                if name not in checked:
                    raise UnknownObject(name, checked, role=role)
        if not images:  # whose depths are held against what a camera reaches
            check_unit({name: points for name, points in checked.items() if name not in fixed})
        notes = [assumptions] if isinstance(assumptions, str) else list(assumptions)
        notes += [] if images else duplicates(checked, fixed)
        if up is not None:
            given = numeric(up, "up")
            up = as_direction(given, "up")
            if abs(float(np.linalg.norm(given)) - 1) > 1e-3:
                notes.append(f"up was given with length {np.linalg.norm(given):.4g} and scaled to 1")
        put = object.__setattr__
        put(self, "clouds", FrozenDict(checked))
        put(self, "fixed", frozenset(fixed))
        put(self, "up", up)
        put(self, "viewpoints", as_viewpoints([] if viewpoints is None else viewpoints))
        put(self, "images", tuple(images))
        put(self, "meshes", FrozenDict(dict(meshes or {})))
        put(self, "robot_base", None if robot_base is None else as_pose(robot_base, "robot_base"))
        put(self, "assumptions", tuple(dict.fromkeys(notes)))
        put(self, "masses", as_masses(masses, checked))
        put(self, "friction", as_friction(friction, checked))
        put(self, "models", FrozenDict(dict(models or {})))
        some = numeric([] if matter is None else matter, "matter")
        put(self, "matter", as_points(some, "matter") if some.size else freeze(np.empty((0, 3))))
        put(self, "wrong_masks", tuple(wrong_masks))
        put(self, "centres", as_centres(centres, checked))

    def __reduce__(self) -> tuple[object, ...]:
        """Pickle by parts, so that a scene can go to another process."""
        clouds, fixed = dict(self.clouds), self._fixed_in_order()
        parts = (clouds, fixed, self.up, self.viewpoints, self.images, dict(self.meshes), self.robot_base)
        seen = (dict(self.masses), dict(self.friction), dict(self.models), self.matter, self.wrong_masks)
        return (Scene, (*parts, self.assumptions, *seen, dict(self.centres)))

    def _repr_html_(self) -> str | None:
        """Show the scene in a notebook."""
        return in_cell(self)

    def __repr__(self) -> str:
        """Say what is in the scene, not the points."""
        sizes = ", ".join(f"{name}: {len(points)}" for name, points in self.clouds.items())
        return f"Scene({{{sizes}}} points, fixed={self._fixed_in_order()}, up={self.up})"

    def __str__(self) -> str:
        """The objects, what never moves, and what was assumed, a line each."""
        size, up = sum(map(len, self.clouds.values())), "not known" if self.up is None else self.up.round(2)
        movable, fixed, assumed = in_words(self, (self.movable, sorted(self.fixed), self.assumptions))
        about = f"fixed: {', '.join(fixed) or 'nothing'}", f"{size:,} points; up is {up}"
        objects = f"{len(movable)} objects: {', '.join(movable)}"
        return "\n".join([objects, *about, *(f"Assumed: {each}" for each in assumed)])

    @classmethod
    @checked_arguments
    def from_images(
        cls,
        images: Sequence[DepthImage] | DepthImage,
        fixed: Names = (),
        up: ArrayLike | None = None,
        table: Literal["auto"] | None = None,
        unnamed: bool = True,
        robot_bodies: Bodies = (),
    ) -> "Scene":
        """Merge what one or several depth cameras see into one scene.

        Args:
            images: Depth images of the same moment; labels of one name are one object.
            fixed: Names of the objects that never move.
            up: Direction (3,) against gravity; None takes it from the plane of a fixed object.
            table: "auto" finds the table where nothing is fixed: an object named so, else the plane under
                the objects among the pixels without a label, which becomes the fixed object "table".
            unnamed: Whether wrong masks are said, and what no mask names becomes objects and matter.
            robot_bodies: Corners (V, 3) [m] of bodies left out of that: `arm.bodies(q, pose_base_to_world)`.

        Returns:
            The scene in world coordinates. An object of which hardly a point was seen is left out,
            which its assumptions say, and so is where the table is from.

        Raises:
            InvalidInput: If no image shows an object, an image is not what it should be, or two disagree.
            UnknownObject: If `fixed` names an object no image shows.
        """
        images = [images] if isinstance(images, DepthImage) else images
        views: dict[str, list[FloatArray]] = {}
        for image in images:
            for name, points in image.clouds().items():
                views.setdefault(name, []).append(points)
        clouds = {name: np.concatenate(pieces) for name, pieces in views.items()}
        check_depth(images, clouds)
        few = {name: len(points) for name, points in clouds.items() if len(points) < FEWEST_SEEN}
        notes = [f"{name!r} is left out: only {count} of its points were seen" for name, count in few.items()]
        notes += said_of_images(images)
        clouds = {name: points for name, points in clouds.items() if name not in few}
        viewpoints = np.array([image.viewpoint for image in images]).reshape(-1, 3)
        fixed = as_names(fixed)
        if table == "auto" and not fixed and clouds:
            background = np.concatenate([image.background() for image in images])
            fixed = table_among(clouds, background, viewpoints, notes)
        scene = cls(clouds, fixed, up, viewpoints, images, assumptions=notes).upright()
        return scene.examined(robot_bodies=robot_bodies) if unnamed else scene

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all objects, in the order given."""
        return tuple(self.clouds)

    @property
    def movable(self) -> tuple[str, ...]:
        """Names of the objects that can be taken, in the order given."""
        return tuple(name for name in self.clouds if name not in self.fixed)

    @property
    def whole(self) -> frozenset[str]:
        """Names of the objects whose clouds are known models: nothing of them is hidden."""
        return frozenset(name for name, fit in self.models.items() if fit.refused is None)

    def seen(self, name: str) -> FloatArray:
        """Points (N, 3) [m] that were seen of an object: its cloud, or what a model took the place of."""
        return self.models[name].seen if name in self.models else self.clouds[name]

    def upright(self) -> "Scene":
        """Find the upward direction from the plane of a fixed object, where none is known.

        Returns:
            The scene with `up` and the sentence that says where it is from; the same scene where up is
            known already or no fixed object is flat.
        """
        if self.up is not None:
            return self
        found = up_from_fixed(self.clouds, self._fixed_in_order(), self.viewpoints)
        if found is None:
            return self
        up, note = found
        return self._copy_with(up=as_direction(up, "up"), assumptions=(*self.assumptions, note))

    @checked_arguments
    def examined(self, background: FloatArray | None = None, robot_bodies: Bodies = ()) -> "Scene":
        """Refuse views that disagree, say which masks are wrong in kind, and add what no mask names."""
        check_views(self.images, self.fixed)
        wrong = wrong_masks(self.images, self.fixed)
        said = (*self.assumptions, *map(str, wrong))
        return self._copy_with(wrong_masks=wrong, assumptions=said).with_unnamed(background, robot_bodies)

    def with_masks_as_they_are(self) -> "Scene":
        """The scene with trusted masks: what is wrong with them stays said, and nothing is refused for it."""
        return self._copy_with(wrong_masks=tuple(replace(wrong, trusted=True) for wrong in self.wrong_masks))

    @checked_arguments
    def with_unnamed(
        self, background: FloatArray | None = None, robot_bodies: Bodies = (), things: bool = True
    ) -> "Scene":
        """Add what was seen and no mask names.

        Args:
            background: Points (N, 3) [m] that belong to no object; those of the images where None.
            robot_bodies: Corners (V, 3) [m] of bodies whose points are left out.
            things: Whether what is at objects becomes objects; else it is matter as well.

        Returns:
            The scene with what is at objects as objects `unnamed_1` and so on, the rest as `matter`, and
            sentences on these; the same scene where there is nothing, or up is unknown.
        """
        if background is None:
            background = np.concatenate([np.empty((0, 3)), *(image.background() for image in self.images)])
        if self.up is None or len(background) == 0:
            return self
        seen = without_bodies(background, robot_bodies)
        found, matter, notes = unnamed_among(seen, self.clouds, self._fixed_in_order(), self.up, things)
        clouds = {name: as_points(cloud, f"cloud {name!r}") for name, cloud in found.items()}
        joined, said = FrozenDict({**self.clouds, **clouds}), (*self.assumptions, *notes)
        return self._copy_with(clouds=joined, matter=freeze(matter), assumptions=said)

    def with_up(self, up: ArrayLike) -> "Scene":
        """Give the scene another upward direction.

        Args:
            up: Direction (3,) against gravity, of any length.

        Returns:
            A new scene; all else is shared.

        Raises:
            InvalidInput: If it is not a direction.
        """
        return self._copy_with(up=as_direction(up, "up"))

    def with_base(self, robot_base: ArrayLike) -> "Scene":
        """Put the robot's base at a rigid pose (4, 4) in the world, whatever the scene said of it."""
        return self._copy_with(robot_base=as_pose(robot_base, "base"))

    def with_cloud(self, name: str, points: ArrayLike) -> "Scene":
        """Give an object a new cloud, or add one.

        Args:
            name: The object; one already there keeps its place among the others, mass and friction, and loses
                mesh, model and centre of mass.
            points: Its points (N, 3) in [m].

        Returns:
            A new scene; the clouds that did not change are shared.

        Raises:
            InvalidInput: If the cloud is not what it should be.
        """
        clouds = {**self.clouds, as_name(name): as_points(points, f"cloud {name!r}")}
        lost = {key: all_but(name, getattr(self, key)) for key in ("meshes", "models", "centres")}
        return self._copy_with(clouds=FrozenDict(clouds), **lost)

    def without(self, name: str) -> "Scene":
        """Take an object out of the scene.

        Args:
            name: The object.

        Returns:
            A new scene; its images still show the object.

        Raises:
            UnknownObject: If there is no such object.
            InvalidInput: If it was the only one.
        """
        if name not in self.clouds:
            raise UnknownObject(name, self.clouds)
        if not (clouds := all_but(name, self.clouds)):
            raise InvalidInput(f"without {name!r} the scene has no objects: expected at least one")
        named = ("meshes", "masses", "friction", "models", "centres")
        left = {key: all_but(name, getattr(self, key)) for key in named}
        return self._copy_with(clouds=clouds, fixed=self.fixed - {name}, **left)

    @checked_arguments
    def weighed(
        self,
        masses: Mapping[str, float] | None = None,
        friction: Mapping[str, float] | None = None,
        centres: Mapping[str, ArrayLike] | None = None,
    ) -> "Scene":
        """Say how heavy and how rough objects are, and where their weight is.

        Args:
            masses: Masses in [kg], above 0, by name; they replace what was known of these objects.
            friction: Coulomb coefficients, 0 to 10, of their surfaces, by name.
            centres: Centres of mass (3,) in [m] in the frame of the clouds, by name.

        Returns:
            A new scene; what is known of the other objects stays.

        Raises:
            InvalidInput: If a value is not what it should be; names the object.
            UnknownObject: If there is no such object.
        """
        return self._copy_with(
            masses=FrozenDict({**self.masses, **as_masses(masses, self.clouds)}),
            friction=FrozenDict({**self.friction, **as_friction(friction, self.clouds)}),
            centres=FrozenDict({**self.centres, **as_centres(centres, self.clouds)}),
        )

    def save(self, path: str | Path) -> None:
        """Write an `.npz` that `load_scene` reads: without images, meshes, models and assumptions.

        Raises:
            InvalidInput: The file cannot be written, or an object has the name of another of its arrays.
        """
        kept = ("up", "viewpoints", "robot_base", "matter", "masses", "friction", "centres")
        about = {"fixed": sorted(self.fixed), **{key: getattr(self, key) for key in kept}}
        write_clouds(Path(path), self.clouds, about)

    def _copy_with(self, **checked: object) -> "Scene":
        """Copy with other attributes, which have been checked; what was worked out of this one stays here."""
        changed = object.__new__(Scene)
        changed.__dict__.update({each.name: getattr(self, each.name) for each in fields(self)} | checked)
        return changed

    def _fixed_in_order(self) -> list[str]:
        return [name for name in self.clouds if name in self.fixed]
