import pytest
from PIL import Image

from topple.benchmarks.wrong import EXAMPLES, Example, shown
from topple.topology.base.errors import InvalidInput


def test_a_picture_shows_the_pile_before_during_and_after_a_lift(tmp_path):
    roll = next(example for example in EXAMPLES if example.kind == "roll")
    found = shown(roll, tmp_path)
    assert found["first"] == "ball_2" and found["then"] == "box_1" and not found["said"]
    moved = found["moved"]
    assert isinstance(moved, list) and moved[0] > 0.01
    with Image.open(tmp_path / "roll.png") as image:
        assert image.size == (3 * 360, 300)
        assert len(image.convert("RGB").getcolors() or ()) > 5


@pytest.mark.slow
def test_a_pair_that_is_right_is_no_example(tmp_path):
    with pytest.raises(InvalidInput, match="right by now"):
        shown(Example("roll", 7_400_073, "ball_2", "can_1"), tmp_path)
    assert not list(tmp_path.iterdir())
