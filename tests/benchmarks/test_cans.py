"""The can shelves: what stands before a can goes first, told from pictures that look in from the front."""

import pytest

from topple.benchmarks.cans import rows
from topple.topology.base.errors import InvalidInput


def test_cans_before_others_go_first_and_cans_beside_them_stay(tmp_path):
    places = ("0.92 0.0 1.16", "1.10 0.02 1.16", "1.10 0.30 1.16")  # the first stands before the second
    folder = tmp_path / "examples/3/1"
    folder.mkdir(parents=True)
    lines = [line for number, place in enumerate(places) for line in (str(number), place)]
    (folder / "instance_info.txt").write_text("\n".join(lines))
    (row,) = rows(False, 0, lambda text: None, tmp_path)
    assert (row["tried"], row["held"]) == (3, 3)
    assert row["baseline_value"] == pytest.approx(200 / 3)


def test_without_a_checkout_it_says_what_it_needs(tmp_path):
    with pytest.raises(InvalidInput, match="cans needs --data DIR"):
        rows(False, 0, lambda text: None, tmp_path)
