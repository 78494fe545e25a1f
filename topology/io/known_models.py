"""Known models in place of what was seen of objects: found by name, registered, each with its residual."""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np

from topple.topology.base.arguments import checked_arguments
from topple.topology.base.arrays import BoolArray, FloatArray, round_off
from topple.topology.bodies.model_registration import Excluded, register
from topple.topology.bodies.tolerances import (
    AGREED,
    AMBIGUOUS,
    INTO,
    MODEL_FEWEST,
    MODEL_INLIERS,
    MODEL_RESIDUAL,
    MODEL_SEEN_THROUGH,
    SEEN_SPACING,
    SEEN_THROUGH,
)
from topple.topology.bodies.tops import tops_of
from topple.topology.geometry.rigid import move_points
from topple.topology.geometry.thin import thinned
from topple.topology.io.model_files import meant_by, model_files, read_model
from topple.topology.scene.cloud import clean
from topple.topology.scene.mesh import Mesh
from topple.topology.scene.model_fit import ModelFit
from topple.topology.scene.scene import Scene
from topple.topology.scene.sight import seen_in
from topple.topology.views.free_space import FreeSpace


@checked_arguments
def with_models(scene: Scene, folder: str | os.PathLike[str]) -> Scene:
    """Put known models in place of what was seen of objects, each registered with what was seen of it.

    The name of an object says which model it is: `banana`, `banana_2` and `011_banana` are the model
    `011_banana`. Where its fit is good, the object's cloud becomes the surface of the model, which hides
    nothing; where it is poor or another pose fits as well, the object keeps its cloud. A sentence among the
    scene's assumptions says either, with the residual. What is fixed stays as it was seen.

    Args:
        scene: What was seen.
        folder: The models: NAME.obj, .stl, .ply or .glb, or folders NAME with a mesh, as YCB and BOP have
            them, in [m] (obj_000005.ply of BOP in [mm]).

    Returns:
        The scene; `models` has the fit of each object that has a model.

    Raises:
        InvalidInput: There are no models, or one that is needed cannot be read.
        OSError: A file cannot be read.

    Examples:
        >>> import pathlib, trimesh
        >>> pathlib.Path("models").mkdir()
        >>> _ = trimesh.creation.box((0.06, 0.06, 0.08)).export("models/cup.obj")
        >>> with_models(scene, "models").models["cup"].model
        'cup'
    """
    files, sight = model_files(Path(folder)), seen_in(scene)
    clouds, meshes, fits = dict(scene.clouds), dict(scene.meshes), dict[str, ModelFit]()
    notes, without = list(scene.assumptions), list[str]()
    for name in scene.movable:
        meant = meant_by(name, files)
        if len(meant) != 1:
            without.append(name if not meant else f"{name} (several: {', '.join(meant)})")
            continue
        model, (points, faces, vertices) = read_model(meant[0], files[meant[0]])
        seen = thinned(clean(scene.seen(name)), SEEN_SPACING)
        fit = register(model, seen, _space_excluded(scene, seen, sight), _view_direction(scene, seen))
        fit = fits[name] = replace(fit, seen=scene.seen(name), refused=_refusal(fit, len(seen)))
        notes.append(_sentence(name, fit))
        if fit.refused is None:
            clouds[name] = round_off(move_points(points, fit.pose_model_to_world))
            if faces is not None:
                meshes[name] = Mesh(move_points(vertices, fit.pose_model_to_world), faces)
    if without:
        notes.append(f"no model in {os.fspath(folder)} is called as {', '.join(without)}: kept as seen")
    return Scene(
        clouds,
        [name for name in scene.names if name in scene.fixed],
        scene.up,
        scene.viewpoints if len(scene.viewpoints) else None,
        scene.images,
        meshes,
        scene.robot_base,
        notes,
        scene.masses,
        scene.friction,
        fits,
        scene.matter,
        scene.wrong_masks,
        scene.centres,
    )


def _view_direction(scene: Scene, seen: FloatArray) -> FloatArray | None:
    """(3,) along which the cameras looked at something on average; None where they looked from all around."""
    rays = seen.mean(axis=0) - scene.viewpoints
    rays /= np.maximum(np.linalg.norm(rays, axis=1), 1e-9)[:, None]
    mean = rays.sum(axis=0) / max(len(rays), 1)
    length = float(np.linalg.norm(mean))
    return mean / length if length > AGREED else None


def _space_excluded(scene: Scene, seen: FloatArray, sight: FreeSpace | None) -> Excluded:
    """Where nothing of an object can be: what a camera looked through, and under the top that it is over."""
    up = scene.up
    found = [] if up is None else [tops_of(scene.clouds[name], up).under(seen) for name in scene.fixed]
    grounds = [top for top in found if top is not None]

    def exclude(places: FloatArray) -> BoolArray:
        barred = np.zeros(len(places), dtype=np.bool_) if sight is None else sight.empty(places, SEEN_THROUGH)
        for ground in grounds:
            barred |= ground.above(places) < -INTO
        return barred

    return exclude


def _refusal(fit: ModelFit, points: int) -> str | None:
    """Say why a fit cannot be trusted; None where it can."""
    if points < MODEL_FEWEST:
        return f"{points} points of it were seen, at least {MODEL_FEWEST} needed"
    if fit.residual > MODEL_RESIDUAL:
        return f"at most {1e3 * MODEL_RESIDUAL:.1f} mm allowed"
    if fit.inliers < MODEL_INLIERS:
        return f"at least {MODEL_INLIERS:.0%} needed within 3 mm"
    if fit.seen_through > MODEL_SEEN_THROUGH:
        return (
            f"cameras looked through {fit.seen_through:.0%} of it, at most {MODEL_SEEN_THROUGH:.0%} allowed"
        )
    if fit.ambiguity > AMBIGUOUS:
        return f"another pose {1e3 * fit.ambiguity:.0f} mm from there fits as well"
    return None


def _sentence(name: str, fit: ModelFit) -> str:
    """The sentence on a fit."""
    figures = (
        f"residual {1e3 * fit.residual:.1f} mm, {fit.inliers:.0%} of its seen points within 3 mm, "
        f"{fit.visible:.0%} of the model's surface seen"
    )
    if fit.refused is None:
        return f"{name!r} is the model {fit.model}, registered: {figures}"
    return f"{name!r} stays as it was seen, the model {fit.model} does not fit: {figures}; {fit.refused}"
