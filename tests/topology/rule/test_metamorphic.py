"""The same scene told differently has the same relations: turned, shifted, in another order, with more far off.

What hangs on a tie is left out: where several contacts could hold an object equally well, the linear programme
that infers one may choose another when numbers change in their last digit. Those pairs are counted instead.
"""

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from topple.topology.rule.relate import relate
from topple.topology.scene import Scene

sys.path.insert(0, str(Path(__file__).parents[1]))
from made import ball, moved, pile, seen, told, whole

PILES = Path(__file__).resolve().parents[3].parent / "shared" / "piles"
Change = Callable[[Scene, np.random.Generator], Scene]


def reordered(scene: Scene, rng: np.random.Generator) -> Scene:
    names = rng.permutation(scene.names).tolist()
    return Scene({n: scene.clouds[n] for n in names}, scene.fixed, scene.up, scene.viewpoints, scene.images)


def blurred(scene: Scene, rng: np.random.Generator) -> Scene:
    clouds = {name: cloud + rng.normal(0, 1e-7, cloud.shape) for name, cloud in scene.clouds.items()}
    return Scene(clouds, scene.fixed, scene.up, scene.viewpoints, scene.images)


CHANGES: dict[str, Change] = {
    "turned about the vertical": lambda scene, rng: moved(
        scene, Rotation.from_euler("z", rng.uniform(0.2, 6.0)).as_matrix(), np.zeros(3)
    ),
    "turned": lambda scene, rng: moved(
        scene, Rotation.random(random_state=int(rng.integers(1 << 30))).as_matrix(), np.zeros(3)
    ),
    "shifted": lambda scene, rng: moved(scene, np.eye(3), rng.uniform(-1, 1, 3)),
    "in another order": reordered,
    "with a ball 8 m away": lambda scene, rng: scene.with_cloud(
        "ball", ball(rng, 0.03, np.array([8.0, 0.0, 0.03]))
    ),
    "blurred by 1e-7 m": blurred,
}


def changed(scene: Scene, change: Change, rng: np.random.Generator) -> tuple[int, int]:
    """Number of pairs that are told differently of the changed scene, and of all."""
    before = told(relate(scene, deviation=0.003))
    after = told(relate(change(scene, rng), deviation=0.003))
    return sum(after[pair] != before[pair] for pair in before) // 2, len(before) // 2


@pytest.mark.parametrize("change", CHANGES)
@pytest.mark.parametrize("cameras", [0, 1, 3])
def test_what_changes_nothing_in_the_scene_changes_no_pair(change: str, cameras: int) -> None:
    for seed in range(6):
        rng = np.random.default_rng(seed)
        boxes = pile(rng)
        scene = seen(boxes, rng, cameras) if cameras else whole(boxes, rng)
        assert changed(scene, CHANGES[change], rng)[0] == 0, seed


@pytest.mark.skipif(not PILES.is_dir(), reason="the piles are not at ../shared/piles")
@pytest.mark.parametrize("change", CHANGES)
def test_of_recorded_piles_hardly_a_pair_changes(change: str) -> None:
    from topple.benchmarks.recorded import recorded_piles

    found = [
        changed(scene, CHANGES[change], np.random.default_rng(number))
        for number, case in enumerate(recorded_piles(PILES)[::3])
        for scene in case.scenes.values()
    ]
    assert sum(one for one, _ in found) <= 0.02 * sum(every for _, every in found)
