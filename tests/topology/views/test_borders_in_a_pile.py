from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from topple.planner.decide.dependency import dependencies
from topple.planner.execution.look import Observer
from topple.robots.scenarios import scenario_called
from topple.robots.scenarios.scenario import Scenario
from topple.topology.image import DepthImage
from topple.topology.io.load import load_scene
from topple.topology.views.borders import mend_masks


@pytest.fixture(scope="module")
def pile() -> Iterator[Scenario]:
    with scenario_called("pile", 702) as stage:
        yield stage


def looks(pile: Scenario, off: float) -> list[DepthImage]:
    rng = np.random.default_rng(2)
    return [camera.with_mask_noise(off).look(pile.world, rng) for camera in pile.cameras]


def test_of_the_pixels_that_change_nine_tenths_were_wrong_and_half_of_the_wrong_ones_do(
    pile: Scenario,
) -> None:
    for true, seen in zip(looks(pile, 0.0), looks(pile, 1.0), strict=True):
        found, said = mend_masks(seen)
        assert said is not None and "off by a pixel" in said
        changed, right = found.label != seen.label, found.label == true.label
        wrong = (seen.label != true.label) & (seen.depth > 0)
        assert (changed & right).sum() > 0.85 * changed.sum()
        assert (wrong & right).sum() > 0.4 * wrong.sum()


def test_exact_masks_stay_as_they_are(pile: Scenario) -> None:
    for seen in looks(pile, 0.0):
        assert mend_masks(seen) == (seen, None)


def test_what_depends_on_what_is_as_with_exact_masks(pile: Scenario) -> None:
    def found(off: float) -> tuple[set[tuple[str, str]], tuple[str, ...]]:
        cameras = [camera.with_mask_noise(off) for camera in pile.cameras]
        look = Observer(pile.world, cameras, np.random.default_rng(2), pile.fixed).look()
        edges = dependencies(look.situation, direct=False).dependencies
        return {(edge.first, edge.then) for edge in edges}, look.faults

    (exact, silent), (off, said) = found(0.0), found(1.0)
    assert off == exact
    assert silent == ()
    assert [text.split(":")[0] for text in said] == ["camera 1", "camera 2", "camera 3"]


@pytest.mark.parametrize("off", [0.0, 1.0])
def test_a_frame_is_mended_as_it_is_read_and_says_so(pile: Scenario, tmp_path: Path, off: float) -> None:
    seen = looks(pile, off)[0]
    np.savez(tmp_path / "frame.npz", depth=seen.depth, K=seen.K, label=seen.label)
    scene = load_scene(tmp_path / "frame.npz")
    said = [note for note in scene.assumptions if "masks are off" in note]
    assert len(said) == (off > 0.0)
    assert (scene.images[0].label == mend_masks(seen)[0].label).all()
