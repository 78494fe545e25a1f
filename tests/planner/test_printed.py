"""What `print` shows of scene, relations, order, plan and run: short, as the command line says it."""

import pytest
from on_table import on_table

import topple
from topple.planner.formats.run_record import RunRecord, StepRecord
from topple.robots.shapes import box
from topple.topology import Scene


@pytest.fixture(scope="module")
def scene() -> Scene:
    book, mug = box("book", (0.2, 0.15, 0.04)), box("mug", (0.08, 0.08, 0.1))
    far = box("far", (0.05, 0.05, 0.1))
    return on_table((book, (0, 0, 0)), (mug, (0, 0, 0.04)), (far, (0.3, 0.3, 0)), points=600)


def test_a_scene_says_its_objects_and_what_never_moves(scene):
    assert str(scene).splitlines()[:2] == ["3 objects: book, mug, far", "fixed: table"]


def test_relations_are_asked_by_two_names_and_print_the_pairs_that_meet(scene):
    relations = topple.relate(scene)
    assert relations["mug", "book"] == relations.between("mug", "book")
    assert str(relations["mug", "book"]).startswith("mug touch book ")
    head, *pairs, last = str(relations).splitlines()
    assert head.startswith("4 objects, deviation ")
    told = {tuple(line.split()[:3]) for line in pairs}
    assert told == {("table", "touch", "book"), ("book", "touch", "mug"), ("table", "touch", "far")}
    assert last == "disjoint: 3 of 6 pairs"


def test_an_order_gives_its_steps_and_prints_what_the_command_line_says(scene, tmp_path, typed):
    found = topple.order(scene, "book")
    mug, book = found
    assert found.next == mug == ("mug", "it rests on book.", found.risk["mug"], ())
    assert (book.object, book.risk, book.before) == ("book", found.risk["book"], ("mug",))
    assert found.as_taken(()).next is None
    path = str(tmp_path / "scene.npz")
    scene.save(path)
    said, printed = typed("order", path, "--target", "book").out, str(found).splitlines()
    assert said.startswith(f"{path}: {printed[0]}\n") and len(str(found)) < 400
    assert all(word in said for line in printed[1:] for word in line.split())


@pytest.mark.parametrize(
    ("goal", "violations", "missing", "said"),
    [
        ("free plate", (), (), "Plate freed in 2 moves. Nothing else moved."),
        ("free plate", ("cup: box_4 fell by 9 cm",), (), "Plate freed, but box_4 fell by 9 cm in step 1."),
        ("free plate", ("cup: a moved", "b moved"), (), "Plate freed, but a moved in step 1, and 1 more."),
        ("free plate", ("it is not",), ("it is not",), "Plate not freed: it is not."),
        ("lemon within bowl", (), (), "lemon within bowl: reached in 2 moves. Nothing else moved."),
    ],
)
def test_a_run_comes_to_one_line(goal, violations, missing, said):
    steps = (StepRecord("cup", "remove", True), StepRecord("plate", "free", True))
    record = RunRecord(goal, "panda", 0, not violations, violations, steps, missing=missing)
    assert record.summary == said
    assert str(record).splitlines()[1].split()[:3] == ["1", "cup", "remove"]


def test_the_document_of_a_run_has_what_stopped_a_lift_and_what_came_in_unseen():
    stopped = StepRecord("plate", "free", False, stopped_by={"cup": 0.00312})
    found = RunRecord("free plate", "panda", 0, False, steps=(stopped, StepRecord("cup", "remove", True)))
    assert found.to_json()["stops"] == [{"object": "plate", "moved": "cup", "mm": 3.1}]
    assert [step["unseen"] for step in found.to_json()["steps"]] == [False, False]
    fell = [StepRecord("cup", "remove", True, severity={"can": (drop, 2 * drop)}) for drop in (0.1, 0.3, 0.2)]
    document = RunRecord("free plate", "panda", 0, False, steps=tuple(fell)).to_json()
    assert document["severity"] == {"can": {"drop": 0.3, "energy": 0.6}}
    unseen = StepRecord("cup", "remove", True, fallbacks=("unseen",))
    assert unseen.to_json()["unseen"] is True
