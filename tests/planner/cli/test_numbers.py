import pytest

from topple.planner.cli.tables import print_order, print_relations
from topple.planner.decide.words import millimetres
from topple.planner.motion.collision import Contact
from topple.planner.motion.planner import _says
from topple.topology.base.values import decimal


@pytest.mark.parametrize(("value", "digits", "text"), [(-0.0, 0, "0"), (-0.4, 0, "0"), (-0.04, 1, "0.0"),
                                                       (-0.6, 0, "-1"), (12.34, 1, "12.3")])  # fmt: skip
def test_what_rounds_to_nothing_has_no_sign(value, digits, text):
    assert decimal(value, digits) == text


@pytest.mark.parametrize("distance", [0.0, -0.0, 0.003, -1e-5])
def test_what_just_touches_is_0_mm_deep(distance):
    assert _says((Contact("link", "cup", distance),)) == "link touches cup (0 mm deep)"


def test_gaps_of_nothing_have_no_sign(capsys):
    assert millimetres(-1e-6) == "0.0 mm"
    pair = {"a": "a", "b": "b", "relation": "touch", "matrix": [[1, 1, 0], [1, 1, 0]], "gap": -1e-6}
    pair |= {"gap_exact": True, "confidence": 1.0, "observed": True}
    print_relations("scene", {"objects": ["a", "b"], "deviation": 0.001, "relations": [pair]})
    assert "-0" not in capsys.readouterr().out


def test_the_table_of_supports_shows_the_kind_of_each_pair(capsys):
    carried = {"supporter": "bowl", "supported": "lemon", "kind": "contained", "inferred": True}
    document = {"order": ["lemon"], "targets": [], "risk": {}, "dependencies": [], "explanation": []}
    print_order(
        "scene", {**document, "groups": [], "supports": [{**carried, "confidence": 0.7}]}, explain=True
    )
    lines = capsys.readouterr().out.splitlines()
    assert "What carries what:" in lines
    row = next(line for line in lines if "bowl" in line)
    assert row.split() == ["lemon", "is", "inside", "bowl", "0.70", "inferred"]
