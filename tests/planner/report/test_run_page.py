import io
import json
import re

import numpy as np
import pytest
from PIL import Image

from topple.planner.execution.look import find_unexpected
from topple.planner.formats.pictures import picture
from topple.planner.formats.run_record import RunRecord, StepRecord
from topple.planner.report.limits import LIMITS
from topple.planner.report.run_page import run_page
from topple.planner.report.tables import Change, relation_changes
from topple.topology.base.errors import InvalidInput
from topple.topology.relations.relate import relate


def test_every_step_has_a_section_and_a_mark_on_the_timeline(run_record):
    page = run_page(run_record)
    assert page.count('<section class="step">') == len(run_record.steps) + 1
    assert (
        len(re.findall(r'<li><button type="button" class="(?:ok|failed)">', page))
        == len(run_record.steps) + 1
    )
    assert "beside moved 20 mm" in page and "reached with violations" in page
    assert "not reached" not in page


def test_a_picture_two_steps_share_is_embedded_once(run_record):
    data = json.loads(re.search(r'id="data">(.*?)</script>', run_page(run_record), re.DOTALL).group(1))
    assert len(data["pictures"]) == 3
    assert len(data["views"]) == 3
    assert len(data["views"][0]["path"]) == LIMITS.path_points


def test_what_moved_too_far_is_marked(run_record):
    page = run_page(run_record)
    assert '<tr class="bad"><td>beside</td><td class=number>20 mm</td><td class=number>17.2°</td>' in page
    assert page.count("<td>beside</td><td class=number>") == 1
    assert "<td class=number>120 mm, 0.30 J</td></tr>" in page
    assert "<p>Nothing: the others moved by 1.2 mm and 0.6° at most.</p>" in page


def test_differences_from_the_prediction_are_listed_whatever_the_orientation():
    def relations(a, b, relation, observed=True):
        return {"relations": [{"a": a, "b": b, "relation": relation, "observed": observed}]}

    assert relation_changes(relations("a", "b", "within"), relations("b", "a", "contain")) == []
    changes = relation_changes(relations("a", "b", "touch"), relations("b", "a", "disjoint"))
    assert changes == [Change("a", "b", "touch", "disjoint", counts=True)]
    unsure = relation_changes(relations("a", "b", "touch"), relations("b", "a", "disjoint", observed=False))
    assert unsure == [Change("a", "b", "touch", "disjoint", counts=False)]
    kind = relation_changes(relations("a", "b", "touch"), relations("a", "b", "within"))
    assert kind == [Change("a", "b", "touch", "within", counts=False)]
    gone = relation_changes(relations("a", "b", "touch"), {"relations": []})
    assert gone == [Change("a", "b", "touch", "not seen", counts=True)]


def test_the_page_and_the_loop_call_the_same_differences_contradictions(stack):
    scene, relations, _ = stack
    moved = scene.with_cloud("beside", scene.clouds["beside"] + (0, 0, 0.1))
    observed = relate(moved).with_relation("crate", "tin", "partial within")
    changes = relation_changes(relations.to_json(), observed.to_json())
    counted = [change for change in changes if change.counts]
    assert len(changes) > len(counted) == len(find_unexpected(relations, observed)) > 0


def test_a_run_without_steps_pictures_or_scenes_has_a_page():
    bare = StepRecord(object="", action="look again", success=False)
    for steps in ((), (bare,)):
        page = run_page(RunRecord(goal="free plate", robot="panda", seed=0, success=not steps, steps=steps))
        assert "free plate" in page


def test_the_record_gives_the_run_document(run_record):
    document = json.loads(json.dumps(run_record.to_json()))
    assert document["format"] == "topple.run" and document["format_version"] == 1
    assert document["steps"][1]["disturbed"] == {"beside": [0.02, 0.3]}
    keys = {"object", "action", "success", "attempts", "disturbed", "relations_as_predicted", "seconds"}
    assert keys <= set(document["steps"][0])


def test_a_picture_keeps_its_pixels():
    rgb = np.random.default_rng(0).integers(0, 256, (20, 30, 3), dtype=np.uint8)
    assert np.array_equal(np.asarray(Image.open(io.BytesIO(picture(rgb)))), rgb)


@pytest.mark.parametrize(
    "rgb", [np.zeros((4, 4), np.uint8), np.zeros((4, 4, 3)), np.zeros((0, 4, 3), np.uint8)]
)
def test_what_is_no_image_is_refused(rgb):
    with pytest.raises(InvalidInput, match=r"\(H, W, 3\) uint8"):
        picture(rgb)
