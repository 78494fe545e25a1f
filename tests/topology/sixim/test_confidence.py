"""What is told of pairs and supports is believed as often as it was counted to be true."""

import json
from importlib.resources import files

import pytest

from topple.topology.sixim.confidence import EDGES, RISING, Evidence, bin_of, confidence

VIEWS = {"whole": 0, "one": 1, "several": 3}
COUNTED = json.loads(files("topple.topology.sixim").joinpath("confidence.json").read_text(encoding="utf-8"))[
    "counted"
]


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize("kind", Evidence)
def test_better_evidence_is_never_believed_less_and_none_is_certain(view, kind):
    edges = EDGES.get(kind, ())
    measures = [0.0, *edges]
    assert [bin_of(kind, measure) for measure in measures] == list(range(len(COUNTED[view][kind])))
    shares = [confidence(kind, VIEWS[view], measure) for measure in measures]
    assert all(0.0 < share < 1.0 for share in shares)
    assert shares == sorted(shares, reverse=kind not in RISING)


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize("kind", Evidence)
def test_on_the_whole_as_many_are_believed_as_were_true(view, kind):
    cases = COUNTED[view][kind]
    believed = sum(
        sum(case) * confidence(kind, VIEWS[view], measure)
        for case, measure in zip(cases, [0.0, *EDGES.get(kind, ())], strict=True)
    )
    assert believed == pytest.approx(sum(right for right, _ in cases), abs=0.5 * len(cases))


def test_what_cameras_saw_apart_is_believed_more_than_what_they_did_not():
    assert confidence(Evidence.APART, 1, 20.0) > confidence(Evidence.APART_UNSEEN, 1, 0.001)
    assert confidence(Evidence.CARRIES, 1) > confidence(Evidence.CARRIES_UNSEEN, 1, 0.05)
