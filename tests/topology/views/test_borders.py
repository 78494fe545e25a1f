import numpy as np
import pytest
from scipy import ndimage

from topple.topology.kernels.tolerances import BORDER, NOBODY
from topple.topology.views.borders import borders
from topple.topology.views.image import DepthImage

HALVES = np.where(np.arange(40) < 20, 1, 2)[None].repeat(40, axis=0)
K = np.array([[500.0, 0, 20], [0, 500, 20], [0, 0, 1]])


def owners_of(depth: np.ndarray, label: np.ndarray) -> np.ndarray:
    return borders(depth, label).owner


def step() -> np.ndarray:
    depth = np.full((40, 40), 0.8)
    depth[:, 20:] = 0.7
    return depth


@pytest.mark.parametrize("off", [1, 2, BORDER])
def test_masks_beside_a_step_of_depth_end_at_it(off):
    for shifted in (np.roll(HALVES, off, axis=1), np.roll(HALVES, -off, axis=1)):
        shifted[:, :10], shifted[:, 30:] = 1, 2
        assert (owners_of(step(), shifted) == HALVES).all()


def test_what_flies_between_two_surfaces_is_nobodys():
    depth = step()
    depth[5:30, 19] = 0.75
    found = owners_of(depth, HALVES)
    assert (found[5:30, 19] == NOBODY).all()
    assert (np.delete(found, 19, axis=1) == np.delete(HALVES, 19, axis=1)).all()
    image = DepthImage(depth, K, HALVES)
    clouds = image.clouds()
    assert {name: len(cloud) for name, cloud in clouds.items()} == {"1": 20 * 40 - 25, "2": 20 * 40}
    assert len(image.background()) == 0


@pytest.mark.parametrize(("wide", "kept"), [(2, False), (3, True), (4, True)])
def test_a_face_turned_away_at_a_border_stays_and_a_narrower_ramp_flies(wide, kept):
    depth = np.where(HALVES == 1, 0.7, 0.8)
    face = slice(20 - wide, 20)
    depth[:, face] = 0.7 + 0.006 * np.arange(1, wide + 1)  # falls off steeply, towards what stands behind
    found = owners_of(depth, HALVES)
    assert (found[1:-1, face] == (1 if kept else NOBODY)).all()
    assert (found[:, 20:] == 2).all() and (found[:, : 20 - wide] == 1).all()


@pytest.mark.parametrize("wide", [1, 2, 3, 5])
def test_thin_things_keep_their_pixels(wide):
    depth, label = np.full((60, 60), 0.8), np.zeros((60, 60), dtype=int)
    depth[10:50, 30 : 30 + wide] = 0.76  # a spoon held over the table
    label[10:50, 30 : 30 + wide] = 7
    assert (owners_of(depth, label) == label).all()


def test_a_rim_before_its_own_inside_stays_and_a_strip_of_a_nearer_neighbour_does_not():
    depth, label = np.full((80, 80), 0.9), np.zeros((80, 80), dtype=int)
    depth[20:60, 20:60] = 0.88  # the floor of a tray
    depth[57:60, 20:60] = 0.84  # its rim, in front
    label[20:60, 20:60] = 1
    assert (borders(depth, label).owner == label).all()
    depth[57:60], label[57:60] = 0.9, 0
    depth[57:70, 20:60], label[57:70, 20:60] = 0.84, 2  # a box, of which a pixel's row goes to the tray
    off = label.copy()
    off[57, 25:50] = 1
    assert (borders(depth, off).owner == label).all()


def test_slanted_and_noisy_surfaces_are_continued():
    rng = np.random.default_rng(0)
    rows, columns = np.indices((80, 80))
    depth = 0.9 - 0.002 * rows  # a table, seen at an angle
    label = np.zeros((80, 80), dtype=int)
    box = (rows > 20) & (rows < 60) & (columns > 20) & (columns < 60)
    depth[box] = 0.65 + 0.001 * columns[box]
    label[box] = 1
    depth += rng.normal(0, 0.001, depth.shape)
    wide = np.zeros_like(label)
    wide[19:62, 19:62] = 1
    found = owners_of(depth, wide)
    assert (found == label).mean() > 0.999
    assert (owners_of(depth, label) != label).mean() < 0.001


def test_pixels_without_depth_keep_their_label():
    depth = step()
    depth[::3] = 0.0
    wrong = HALVES.copy()
    wrong[12:25, 20:22] = 1
    found = owners_of(depth, wrong)
    assert (found[::3] == wrong[::3]).all()
    assert (found[1::3] == HALVES[1::3]).all()


@pytest.mark.parametrize("label", [np.zeros((6, 8), int), np.arange(48).reshape(6, 8)])
def test_masks_without_borders_or_without_an_inside_stay(label):
    assert (owners_of(np.full((6, 8), 0.5), label) == label).all()
    assert (owners_of(np.zeros((6, 8)), label) == label).all()


def table_with_boxes() -> tuple[np.ndarray, np.ndarray]:
    depth, label = np.full((90, 120), 0.9), np.zeros((90, 120), dtype=int)
    for number, (top, left) in enumerate([(10, 10), (40, 60), (15, 80)], 1):
        depth[top : top + 30, left : left + 25] = 0.8 - 0.02 * number
        label[top : top + 30, left : left + 25] = number
    return depth, label


def test_exact_masks_are_not_said_to_be_off():
    found = borders(*table_with_boxes())
    assert (found.off, found.moved, found.said()) == (0.0, (0, 0), None)


@pytest.mark.parametrize(
    ("rows", "columns", "words"),
    [(0, 2, "2 px to the right"), (-1, 0, "1 px up"), (3, -2, "3 px down and 2 px to the left")],
)
def test_masks_beside_the_depth_are_moved_back_and_it_is_said(rows, columns, words):
    depth, label = table_with_boxes()
    found = borders(depth, np.roll(label, (rows, columns), axis=(0, 1)))
    assert found.moved == (-rows, -columns)
    assert (found.owner == label).all()
    assert found.said() == f"masks lie {words} of the depth, and are moved back: is it registered to them?"


@pytest.mark.parametrize("grow", [ndimage.grey_dilation, ndimage.grey_erosion])
def test_masks_too_wide_or_too_narrow_are_not_moved(grow):
    depth, label = table_with_boxes()
    found = borders(depth, grow(label, size=(3, 3)))
    assert found.moved == (0, 0)
    assert (found.owner == label).all()
    assert found.said() is not None and "masks are off by a pixel or more: " in str(found.said())
