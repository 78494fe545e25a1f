"""DepthImage: pixels to points, and parts that do not fit together."""

import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from topple.topology.base.errors import InvalidInput
from topple.topology.views.image import DepthImage

K = np.array([[500.0, 0.0, 31.5], [0.0, 510.0, 23.5], [0.0, 0.0, 1.0]])
DEPTH = np.full((48, 64), 0.8)
LABEL = np.zeros((48, 64), dtype=np.uint8)
LABEL[10:20, 10:20] = 4
LABEL[30:40, 10:20] = 2


@given(st.integers(0, 63), st.integers(0, 47), st.floats(0.1, 5.0))
def test_a_lifted_pixel_projects_back_onto_itself(column, row, depth):
    distances = np.zeros((48, 64))
    distances[row, column] = depth
    points = DepthImage(distances, K, LABEL).points()
    assert np.isfinite(points).all(axis=2).sum() == 1
    x, y, w = K @ points[row, column]
    off = 1e-6 + 2e-9 * K[0, 0] / depth  # points are rounded to a nanometre
    assert x / w == pytest.approx(column, abs=off)
    assert y / w == pytest.approx(row, abs=off)
    assert points[row, column, 2] == pytest.approx(depth, abs=1e-9)


def test_clouds_are_the_labelled_pixels_in_the_world():
    pose = np.eye(4)
    pose[:3, 3] = [1, 2, 3]
    image = DepthImage(DEPTH, K, LABEL, pose, {2: "mug"})  # type: ignore[arg-type]
    clouds = image.clouds()
    assert list(clouds) == ["mug", "4"]
    expected = image.points()[30:40, 10:20].reshape(-1, 3)
    assert np.allclose(clouds["mug"], expected)
    assert np.allclose(clouds["mug"][:, 2], 3.8)
    assert np.allclose(image.viewpoint, [1, 2, 3])


@pytest.mark.parametrize("nothing", [0.0, np.nan, np.inf])
def test_zero_nan_and_infinity_are_no_depth(nothing):
    depth = DEPTH.copy()
    depth[10:20, 10:20] = nothing
    image = DepthImage(depth, K, LABEL)  # type: ignore[arg-type]
    assert list(image.clouds()) == ["2"]
    assert image.pixels() == {"2": 100, "4": 100}


def _matrix(row: int, column: int, value: float) -> np.ndarray:
    matrix = K.copy()
    matrix[row, column] = value
    return matrix


@pytest.mark.parametrize(
    ("matrix", "words"),
    [
        (np.eye(4), "shape"),
        (np.eye(3), "focal length is 1"),
        (np.zeros((3, 3)), "lower triangle"),
        (K.T, "lower triangle"),
        (_matrix(0, 0, -500), "focal length is -500"),
        (_matrix(0, 2, np.nan), "NaN"),
        (_matrix(2, 2, 2), "lower triangle"),
        (_matrix(1, 0, 3), "lower triangle"),
    ],
)
def test_a_matrix_that_is_not_intrinsic_is_refused(matrix, words):
    with pytest.raises(InvalidInput, match=f"^K .*{words}"):
        DepthImage(DEPTH, matrix, LABEL)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("depth", "label", "words"),
    [
        (DEPTH, LABEL[:40], "one label per depth pixel"),
        (DEPTH * 1000, LABEL, "millimetres"),
        (-DEPTH, LABEL, "negative"),
        (DEPTH[0], LABEL, "depth has shape"),
        (DEPTH, LABEL + 0.5, "whole numbers"),
        (DEPTH, LABEL.astype(int) - 1, "label -1"),
        (DEPTH, LABEL[..., None], "mask has shape"),
    ],
)
def test_depth_and_mask_have_to_fit(depth, label, words):
    with pytest.raises(InvalidInput, match=words):
        DepthImage(depth, K, label)


def test_colours_have_to_fit_and_names_to_differ():
    with pytest.raises(InvalidInput, match="rgb"):
        DepthImage(DEPTH, K, LABEL, rgb=np.zeros((48, 64), dtype=np.uint8))
    with pytest.raises(InvalidInput, match="share a name"):
        DepthImage(DEPTH, K, LABEL, names={2: "mug", 4: "mug"})


def test_an_image_travels_between_processes():
    image = DepthImage(DEPTH, K, LABEL, names={2: "mug"}, rgb=np.zeros((48, 64, 3), dtype=np.uint8))
    back = pickle.loads(pickle.dumps(image))
    assert back.names == {2: "mug"}
    assert np.array_equal(back.label, LABEL)


def test_a_place_is_in_view_within_the_edges_of_the_picture_and_ahead():
    image = DepthImage(DEPTH, K, LABEL)
    corner = image.points()[0, 0]
    beyond = corner + np.array([-0.01, 0.0, 0.0])
    behind = -image.points()[24, 32]
    places = np.array([corner, 3.0 * corner, beyond, behind, image.points()[47, 63]])
    assert image.in_view(places).tolist() == [True, True, False, False, True]


def test_a_pixel_without_depth_shows_what_those_beside_it_show_and_no_more():
    depth = np.full((40, 60), 1.0)
    depth[20, 30] = 0.0  # one is lost
    depth[5:10, 5:10] = 0.0
    K = np.array([[50.0, 0, 30], [0, 50.0, 20], [0, 0, 1]])
    image = DepthImage(depth, K, np.zeros((40, 60), np.int64))

    def at(row: int, column: int, far: float) -> list[float]:
        return [(column - 30) * far / 50.0, (row - 20) * far / 50.0, far]

    places = np.array([at(20, 30, 0.9), at(20, 30, 1.004), at(20, 30, 1.1), at(7, 7, 0.9), at(20, 90, 0.9)])
    assert image.shows(places, 0.005).tolist() == [True, True, False, False, False]
