import numpy as np
import pytest

from topple.topology.image import DepthImage
from topple.topology.views.borders import border_share, mend_masks


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
