"""Fits how likely taking one object moves another: `python -m topple.benchmarks.chances`.

Scenes of the pool that no change is judged on are looked at in every view, as pictures and as clouds; what
reasoning finds of each pair is weighed so that the labels of the simulation become as likely as they can.
"""

import argparse
import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np

from topple.benchmarks.piles import Pile, observe
from topple.benchmarks.truth.asked import scene_of
from topple.benchmarks.truth.cases import table_of, training
from topple.benchmarks.truth.pool import PoolScene
from topple.benchmarks.truth.views import VIEWS, seen
from topple.planner.cli.console import print_json
from topple.planner.decide.chances import SIGNS, seen_by, signs
from topple.planner.decide.disturbance import disturbances
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import ToppleError
from topple.topology.base.workers import opened
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation

LOOK = 1
"""Number of the look, whose noise no score is of."""

DECAY = 1.0
"""Weight of the squares of the weights beside the log likelihood: of some signs there are few cases."""

Counted = tuple[FloatArray, FloatArray]
"""Signs (n, len(SIGNS)) and labels (n,) of pairs."""


def given(scene: PoolScene, cameras: int, pictures: bool) -> Scene:
    """What topple is given of a scene.

    Args:
        scene: Of the pool.
        cameras: How many look, 0 for whole surfaces.
        pictures: Whether their pictures are known, or only the clouds that came of them.
    """
    if pictures or not cameras:
        return scene_of(seen(scene.resting, cameras, LOOK, table_of(scene)))
    resting = scene.resting
    looked = observe(Pile(resting.bodies, dict(resting.poses)), cameras, scene.seed)
    fixed = looked.fixed | (resting.fixed & looked.clouds.keys())
    return Scene(looked.clouds, fixed, looked.up, looked.viewpoints)


def counted(scene: PoolScene, cameras: int, pictures: bool) -> Counted:
    """Signs and labels of a scene's pairs in one view; none where topple refuses it.

    Args:
        scene: Of the pool.
        cameras: How many look, 0 for whole surfaces.
        pictures: Whether their pictures are known.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            situation = Situation(given(scene, cameras, pictures)).sized
            asked = disturbances(situation)
    except ToppleError:
        return np.empty((0, len(SIGNS))), np.empty(0)
    labels = [scene.labels.get(then, {}).get(first) for first, then in asked]
    told = [number for number, label in enumerate(labels) if label is not None]
    found = signs(asked, situation.statics.surfaces)
    return found[told], np.array([labels[number] for number in told], dtype=float)


def fitted(found: Sequence[Counted]) -> list[float]:
    """Weights of the signs under which labels are likeliest.

    Args:
        found: What was counted, by scene.
    """
    from sklearn.linear_model import LogisticRegression  # pyright: ignore[reportMissingImports]

    every, labels = (np.concatenate(each) for each in zip(*found, strict=True))
    model: Any = LogisticRegression(C=0.5 / DECAY, tol=1e-8, max_iter=1000).fit(every[:, 1:], labels)
    return [round(float(weight), 3) for weight in (model.intercept_[0], *model.coef_[0])]


def _counted(job: tuple[PoolScene, tuple[int, bool]]) -> Counted:
    scene, view = job
    return counted(scene, *view)


def main() -> None:
    """Fit the weights of every view and print them as JSON."""
    argparse.ArgumentParser(description="Fit how likely taking one object moves another.").parse_args()
    scenes = training()
    views = [
        (cameras, pictures) for cameras in VIEWS.values() for pictures in (True, False) if cameras or pictures
    ]
    weights: dict[str, list[float]] = {}
    with opened(None) as workers:
        for view in views:
            found = list(workers.map(_counted, [(scene, view) for scene in scenes]))
            weights[seen_by(given(scenes[0], *view))] = fitted(found)
    print_json({"made_by": "python -m topple.benchmarks.chances", "scenes": len(scenes), "weights": weights})


if __name__ == "__main__":
    main()
