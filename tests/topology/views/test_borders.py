from pathlib import Path

import numpy as np
import pytest

from topple.planner.decide.dependency import dependencies
from topple.planner.execution.look import Observer
from topple.robots.scenarios import SCENARIOS
from topple.robots.scenarios.scenario import Scenario
from topple.topology.image import DepthImage
from topple.topology.io.load import load_scene
from topple.topology.views.borders import border_share, mend_masks


@pytest.fixture(scope="module")
def pile() -> Scenario:
    return SCENARIOS["pile"](702)


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


def test_a_pixel_of_a_step_goes_to_the_side_that_it_is_of() -> None:
    depth = np.full((40, 40), 0.8)
    depth[:, 20:] = 0.7
    depth[5, 17] = 0.75  # flies between the two: of neither
    label = np.where(np.arange(40) < 20, 1, 2)[None].repeat(40, axis=0)
    label[10:20, 20:22] = 1
    image = DepthImage(depth, np.array([[500.0, 0, 20], [0, 500, 20], [0, 0, 1]]), label)
    share, found = border_share(image)
    assert share > 0.0
    assert (found == np.where(np.arange(40) < 20, 1, 2)).all()


@pytest.mark.parametrize("label", [np.zeros((6, 8), int), np.arange(48).reshape(6, 8)])
def test_masks_without_borders_or_without_an_inside_stay(label: np.ndarray) -> None:
    image = DepthImage(np.full((6, 8), 0.5), np.array([[50.0, 0, 4], [0, 50, 3], [0, 0, 1]]), label)
    assert mend_masks(image) == (image, None)


@pytest.mark.parametrize("off", [0.0, 1.0])
def test_a_frame_is_mended_as_it_is_read_and_says_so(pile: Scenario, tmp_path: Path, off: float) -> None:
    seen = looks(pile, off)[0]
    np.savez(tmp_path / "frame.npz", depth=seen.depth, K=seen.K, label=seen.label)
    scene = load_scene(tmp_path / "frame.npz")
    said = [note for note in scene.assumptions if "masks are off" in note]
    assert len(said) == (off > 0.0)
    assert (scene.images[0].label == mend_masks(seen)[0].label).all()
