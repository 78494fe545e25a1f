"""Tables of documents: everything a person needs is in them."""

from topple.planner.cli.tables import print_order, print_relations, print_run
from topple.planner.formats.run_record import RunRecord, StepRecord


def test_a_run_is_a_line_per_action_with_what_it_disturbed(capsys):
    steps = (
        StepRecord("spoon", "remove", True, disturbed={"can": (0.0094, 0.01)}, seconds=4.0),
        StepRecord(
            "plate", "free", False, attempts=2, disturbed={"can": (0.0123, 0.5)}, seconds=3.21,
            events=("It slipped.",),
        ),
    )  # fmt: skip
    record = RunRecord("free plate", "panda", 0, False, ("plate: can was moved 12.3 mm",), steps, 7.5)
    print_run("dishes", record.to_json())
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "dishes: free plate, reached with violations after 2 actions, 7.5 s"
    (spoon,) = [line for line in lines if line.startswith("1 ")]
    plate, slipped = [line for line in lines if line.startswith("2 ")]
    assert slipped == "2 plate: It slipped."
    assert "nothing" in spoon
    for words in ("failed, attempt 2", "can 12.3 mm 28.6°", "3.2"):
        assert words in plate


def test_only_what_is_not_where_it_shall_be_is_called_not_reached(capsys):
    missing = ("plate is not free",)
    for record, word in (
        (RunRecord("free plate", "panda", 0, False, missing, missing=missing), "failed"),
        (RunRecord("free plate", "panda", 0, True), "done"),
    ):
        print_run("dishes", record.to_json())
        assert capsys.readouterr().out.startswith(f"dishes: free plate, {word} after 0 actions")


def test_relations_leave_out_what_is_apart_but_count_it(capsys):
    pair = {"a": "cup", "b": "mug", "relation": "disjoint", "matrix": [[0, 0, 9], [0, 0, 9]], "gap": 0.5}
    pair |= {"gap_exact": False, "confidence": 1.0, "observed": True}
    document = {"deviation": 0.002, "objects": ["cup", "mug"], "relations": [pair]}
    print_relations("scene.npz", document)
    assert capsys.readouterr().out == "scene.npz: 2 objects, deviation 2.00 mm\nOne pair is disjoint.\n"
    hidden = {**pair, "observed": False}
    print_relations("scene.npz", {**document, "relations": [hidden]})
    out = capsys.readouterr().out
    assert "not observed" in out
    assert "> 500.0" in out


def test_a_group_is_said_in_words(capsys):
    both = {"reason": "leaning", "confidence": 0.9}
    pairs = [{"first": first, "then": then, **both} for first, then in ("ab", "ba")]
    document = {"targets": ["a"], "order": ["b", "a"], "dependencies": pairs, "groups": [["b", "a"]]}
    print_order("scene.npz", {**document, "supports": [], "risk": {"a": 0.9, "b": 0.9}}, movable=5)
    out = capsys.readouterr().out
    assert "to free a, take 2 of 5 movable objects" in out
    assert "b and a hold each other" in out
