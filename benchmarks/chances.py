"""Fits how likely taking one object moves another: `python -m topple.benchmarks.chances`.

Scenes of the pool that no change is judged on are looked at in every view, as clouds and as pictures, these
with exact masks and with ragged ones, as segmentations give them; what reasoning finds of each pair is
weighed so that the labels of the simulation become as likely as they can.
"""

import argparse
import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.optimize import minimize
from scipy.special import expit

from topple.benchmarks.piles import Pile, observe
from topple.benchmarks.truth.asked import scene_of
from topple.benchmarks.truth.cases import table_of, training
from topple.benchmarks.truth.mask_faults import corrupt
from topple.benchmarks.truth.pool import PoolScene
from topple.benchmarks.truth.views import seen
from topple.planner.cli.console import print_json
from topple.planner.decide.chances import SIGNS, seen_by, signs
from topple.planner.decide.disturbance import disturbances
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import ToppleError
from topple.topology.base.workers import open_executor
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation

LOOK = 1
"""Number of the look, whose noise no score is of."""

DECAY = 1.0
"""Weight of the squares of the weights beside the log likelihood: of some signs there are few cases."""

LOOKS = (
    (0, False, ""), (1, True, ""), (1, True, "ragged 2"), (1, False, ""),
    (3, True, ""), (3, True, "ragged 2"), (3, False, ""),
)  # fmt: skip
"""Cameras, whether their pictures are known, and how masks are off: exact, and as segmentations give them."""

FOR = (1, 1, 1, 1, 1, -1, 1, 1, 1, -1, 1, 1, 1)
"""Whether each sign but "always" speaks for a dependency or against: by chance none may do the contrary."""

Counted = tuple[FloatArray, FloatArray]
"""Signs (n, len(SIGNS)) and labels (n,) of pairs."""


def given(scene: PoolScene, cameras: int, pictures: bool, masks: str = "") -> Scene:
    """What topple is given of a scene.

    Args:
        scene: Of the pool.
        cameras: How many look, 0 for whole surfaces.
        pictures: Whether their pictures are known, or only the clouds that came of them.
        masks: How the pictures' masks are off, of `mask_faults.INACCURATE`; exact where empty.
    """
    if pictures or not cameras:
        arrays = dict(seen(scene.resting, cameras, LOOK, table_of(scene)))
        rng, names = np.random.default_rng(scene.seed), arrays["names"].tolist()
        for key in (key for key in arrays if masks and key.startswith("label")):
            arrays[key], _, _ = corrupt(arrays[key], names, masks, "table", rng)
        return scene_of(arrays)
    resting = scene.resting
    looked = observe(Pile(resting.bodies, dict(resting.poses)), cameras, scene.seed)
    fixed = looked.fixed | (resting.fixed & looked.clouds.keys())
    return Scene(looked.clouds, fixed, looked.up, looked.viewpoints)


def counted(scene: PoolScene, *look: Any) -> Counted:
    """Signs and labels of a scene's pairs in one view; none where topple refuses it.

    With masks that are off no face counts as tilted: there it costs needless removals, 7 of 54 for 5.

    Args:
        scene: Of the pool.
        *look: As `given` takes it.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            situation = Situation(given(scene, *look)).sized
            asked = disturbances(situation)
    except ToppleError:
        return np.empty((0, len(SIGNS))), np.empty(0)
    labels = [scene.labels.get(then, {}).get(first) for first, then in asked]
    told = [number for number, label in enumerate(labels) if label is not None]
    found = signs(asked) * np.append(np.ones(len(SIGNS) - 1), not look[-1])  # tilted; the masks
    return found[told], np.array([labels[number] for number in told], dtype=float)


def fitted(found: Sequence[Counted]) -> list[float]:
    """Weights of the signs under which labels are likeliest, each of the sense that `FOR` gives its sign.

    Args:
        found: What was counted, by scene.
    """
    every, labels = (np.concatenate(each) for each in zip(*found, strict=True))
    turned = (2.0 * labels - 1.0)[:, None] * every

    def unlikeliness(weights: FloatArray) -> tuple[float, FloatArray]:
        shown, free = turned @ weights, np.array([0.0, *weights[1:]])
        loss = np.logaddexp(0.0, -shown).sum() + DECAY * free @ free
        return float(loss), 2.0 * DECAY * free - turned.T @ expit(-shown)

    senses = [(None, None), *((0.0, None) if sense > 0 else (None, 0.0) for sense in FOR)]
    fit = minimize(unlikeliness, np.zeros(len(SIGNS)), jac=True, bounds=senses, method="L-BFGS-B")
    return [round(float(weight), 3) for weight in fit.x]


def _counted(job: tuple[Any, ...]) -> Counted:
    return counted(*job)


def main() -> None:
    """Fit the weights of every view and print them as JSON."""
    argparse.ArgumentParser(description="Fit how likely taking one object moves another.").parse_args()
    scenes = training()
    weights: dict[str, list[float]] = {}
    with open_executor(None) as workers:
        for look in LOOKS:
            found = list(workers.map(_counted, [(scene, *look) for scene in scenes]))
            weights[seen_by(given(scenes[0], *look))] = fitted(found)
    print_json({"made_by": "python -m topple.benchmarks.chances", "scenes": len(scenes), "weights": weights})


if __name__ == "__main__":
    main()
