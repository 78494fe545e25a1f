"""The completed surfaces of a scene's bodies, shared by all who ask and by the scenes that come of it."""

from collections.abc import Collection, Mapping
from functools import cached_property
from weakref import ref

import numpy as np

from topple.topology.base.arrays import FloatArray
from topple.topology.base.tolerances import VOXEL
from topple.topology.bodies.complete import complete
from topple.topology.bodies.upright import Upright
from topple.topology.geometry.outline import in_openings
from topple.topology.scene.scene import Scene
from topple.topology.views.free_space import FreeSpace

_KEPT = "_surfaces"
"""Under which name a scene keeps its bodies, as it would a cached property."""


class Surfaces:
    """The bodies of a scene, each completed once for all who ask, in whatever company."""

    def __init__(
        self,
        scene: Scene,
        like: "Surfaces | None" = None,
        kept: Collection[str] = (),
        moved: Mapping[str, FloatArray] | None = None,
    ) -> None:
        """Nothing is completed yet.

        Args:
            scene: The scene; asked for only while it lives.
            like: The bodies of the scene that it came of.
            kept: Names of those bodies that are where they were.
            moved: name -> (4, 4) rigid transform in the world of those that are elsewhere.
        """
        self._scene, self._like = ref(scene), like
        self._poses = {**{name: np.eye(4) for name in kept}, **(moved or {})}
        self._done: dict[str, FloatArray] = {}
        self.without_strays: Scene | None = None
        """The scene as contacts are inferred in it, if they were."""

    @property
    def scene(self) -> "Scene | None":
        """The scene, while there is one."""
        return self._scene()

    def before_without_strays(self) -> "Scene | None":
        """That of the last scene before that has one, which is given up with it."""
        like = self._like
        while like is not None and like.without_strays is None:
            like = like._like
        found = None if like is None else like.without_strays
        if like is not None:
            like.without_strays = None
        return found

    @cached_property
    def upright(self) -> Upright:
        """The scene turned upright; as the one it came of was, where anything is fixed that tells."""
        scene, like = self.scene, self._like
        assert scene is not None, "asked for by somebody who has the scene"
        told = like if like is not None and like.scene is not None and scene.fixed else None
        return Upright.of(scene, told.upright.rotation if told else None)

    @cached_property
    def sight(self) -> FreeSpace | None:
        """Space that the cameras saw to be empty, in the upright frame; None where no camera is known."""
        upright, scene = self.upright, self.scene
        if upright.viewpoints is None or scene is None:
            return None
        seen = {name: scene.seen(name) @ upright.rotation.T for name in scene.whole}
        return FreeSpace({**upright.clouds, **seen}, upright.viewpoints, scene.images, upright.rotation)

    def among(self, names: Collection[str]) -> dict[str, FloatArray]:
        """Upright points (N, 3) [m] of the whole surfaces, by name."""
        missing = [name for name in names if name not in self._done]
        self._done.update(self._carried_over([name for name in missing if name in self._poses]))
        missing = [name for name in missing if name not in self._done]
        self._done.update(complete(self.upright.among(missing), self.sight))
        if self.sight is None:  # else what was seen through openings tells
            movable = [name for name in missing if name not in self.upright.fixed]
            self._done.update((name, self._without_lids(name)) for name in movable)
        for name in missing:
            self._done[name].setflags(write=False)
        return {name: self._done[name] for name in names}

    def _without_lids(self, name: str) -> FloatArray:
        """A completed body (N, 3) with nothing guessed over openings in which others stand on its floor."""
        clouds, body = self.upright.clouds, self._done[name]
        others = [] if len(body) == len(clouds[name]) else [*self.upright.movable]
        if len(others) < 2:
            return body
        feet = np.concatenate([clouds[other] for other in others if other != name])
        feet = feet[np.abs(feet[:, 2] - self.upright.floor_under(clouds[name])) < VOXEL]
        over = in_openings(clouds[name][:, :2], feet[:, :2], body[:, :2], 2 * VOXEL)
        over[: len(clouds[name])] = False
        return body[~over]

    def _carried_over(self, names: Collection[str]) -> dict[str, FloatArray]:
        """The bodies that were completed in the scene this one came of, where they are now."""
        like, names = self._like, [name for name in names if name not in self.upright.fixed]
        if like is None or not names or like.scene is None:
            return {}
        before, now = like.upright.rotation, self.upright.rotation
        found: dict[str, FloatArray] = {}
        for name, body in like.among(names).items():
            pose = self._poses[name]
            turn = now @ pose[:3, :3] @ before.T
            still = np.array_equal(pose, np.eye(4)) and np.array_equal(before, now)
            found[name] = body if still else body @ turn.T + now @ pose[:3, 3]
        return found


def surfaces_of(scene: Scene) -> Surfaces:
    """The completed bodies of a scene: relations that infer contacts, orders and placements share them.

    An equal scene has its own, since how bodies are completed hangs on what a scene came of.
    """
    known: Surfaces | None = vars(scene).get(_KEPT)  # in a copy those of another scene
    return _kept(scene, Surfaces(scene)) if known is None or known.scene is not scene else known


def _kept(scene: Scene, surfaces: Surfaces) -> Surfaces:
    """Keep the bodies of a scene with it."""
    vars(scene)[_KEPT] = surfaces
    return surfaces


def carry_over(scene: Scene, before: Scene, moved: Mapping[str, FloatArray] | None = None) -> None:
    """Say of a scene that it came of another one: bodies whose clouds are the same ones are completed once.

    Args:
        scene: The scene, of which nothing was asked yet.
        before: The one it came of.
        moved: name -> (4, 4) rigid transform in the world of objects that are elsewhere now, and whole.
    """
    kept = [name for name, cloud in scene.clouds.items() if before.clouds.get(name) is cloud]
    _kept(scene, Surfaces(scene, surfaces_of(before), kept, moved))


def whole_surfaces(scene: Scene) -> dict[str, FloatArray]:
    """The surface of every object that can move, guessed sides included, as orders and placements see it.

    Args:
        scene: A scene that knows where up is.

    Returns:
        Name -> (N, 3) points [m] in the scene's frame.

    Raises:
        InvalidInput: The scene has no `up`.
    """
    bodies = surfaces_of(scene)
    found = bodies.among(bodies.upright.clouds)
    return {name: found[name] @ bodies.upright.rotation for name in bodies.upright.movable}
