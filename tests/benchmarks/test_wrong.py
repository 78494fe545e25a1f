from pathlib import Path

from PIL import Image

from topple.benchmarks.wrong import EXAMPLES, shown


def test_a_picture_shows_the_pile_before_during_and_after_a_lift(tmp_path: Path) -> None:
    roll = next(example for example in EXAMPLES if example.kind == "roll")
    found = shown(roll, tmp_path)
    assert found["first"] == "ball_2" and found["then"] == "can_1"
    moved = found["moved"]
    assert isinstance(moved, list) and moved[0] > 0.01
    with Image.open(tmp_path / "roll.png") as image:
        assert image.size == (3 * 360, 300)
        assert len(image.convert("RGB").getcolors() or ()) > 5
