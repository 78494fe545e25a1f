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


@pytest.fixture(scope="module")
def pile() -> Iterator[Scenario]:
    with scenario_called("pile", 702) as stage:
        yield stage


def looks(pile: Scenario, off: float) -> list[DepthImage]:
    rng = np.random.default_rng(2)
    return [camera.with_mask_noise(off).look(pile.world, rng) for camera in pile.cameras]


def test_what_is_given_to_another_was_wrong_and_few_that_lie_beside_their_object_are_left(
    pile: Scenario,
) -> None:
    for true, seen in zip(looks(pile, 0.0), looks(pile, 1.0), strict=True):
        wrong = (seen.label != true.label) & (seen.depth > 0)
        given = (seen.borders.owner != seen.label) & (seen.borders.owner >= 0)
        assert (given & (seen.borders.owner == true.label)).sum() > 0.75 * given.sum()
        assert (wrong & (seen.borders.owner == seen.label)).sum() < 0.4 * wrong.sum()


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


@pytest.mark.parametrize("off", [0.0, 2.0])
def test_a_frame_whose_masks_are_off_says_so_as_it_is_read(
    pile: Scenario, tmp_path: Path, off: float
) -> None:
    seen = looks(pile, off)[0]
    np.savez(tmp_path / "frame.npz", depth=seen.depth, K=seen.K, label=seen.label)
    said = [note for note in load_scene(tmp_path / "frame.npz").assumptions if "masks are off" in note]
    assert len(said) == (off > 0.0)
