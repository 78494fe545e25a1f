"""Labels of others: each format says of the same stack the same, under the names that a scene has."""

import json
from pathlib import Path

import numpy as np
import pytest

from topple.benchmarks.guesses import Guess
from topple.benchmarks.labels import read_truth
from topple.benchmarks.scores import judged
from topple.topology.base.errors import InvalidInput

STACK = {("3", "1"), ("3", "2"), ("2", "1")}
"""The third object lies on the second, that on the first; a fourth stands alone."""


def vmrd(path: Path) -> Path:
    rows = {1: ("notebook", [], [2]), 2: ("box", [1], [3]), 3: ("mouse", [2], []), 4: ("cup", [], [])}
    objects = "".join(
        f"<object><name>{kind}</name><index>{index}</index>"
        f"<father>{''.join(f'<num>{n}</num>' for n in fathers)}</father>"
        f"<children>{''.join(f'<num>{n}</num>' for n in children)}</children></object>"
        for index, (kind, fathers, children) in rows.items()
    )
    path.write_text(f"<annotation>{objects}</annotation>", encoding="utf-8")
    return path


def regrad(path: Path) -> Path:
    tree = {"notebook-1": [], "box-2": ["notebook-1"], "mouse-3": ["box-2"], "cup-4": []}
    path.write_text(json.dumps(tree), encoding="utf-8")
    return path


def metagraspnet(path: Path) -> Path:
    path.write_text("00,-1,00,00\n01,00,-1,00\n00,00,00,00\n00,00,00,00\n", encoding="utf-8")
    return path


def plain(path: Path) -> Path:
    rows = {y: {x: int((x, y) in STACK) for x in "1234" if x != y} for y in "1234"}
    path.write_text(json.dumps(rows), encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("write", "name", "format"),
    [
        (vmrd, "00001.xml", "VMRD"),
        (regrad, "mrt.json", "REGRAD"),
        (metagraspnet, "0_order.csv", "MetaGraspNet"),
        (plain, "labels.json", "labels"),
    ],
)
def test_every_format_says_that_what_lies_on_top_goes_first(write, name, format, tmp_path):
    truth = read_truth(write(tmp_path / name))
    assert truth.format == format
    labels = truth.named(["1", "2", "3", "4", "table"])
    assert {(x, y) for y, row in labels.items() for x, value in row.items() if value == 1} == STACK
    assert sum(len(row) for row in labels.values()) == 12  # all else is denied, not left open


def test_matrices_of_half_and_of_both_triangles_say_the_same(tmp_path):
    both, half = tmp_path / "both.csv", tmp_path / "half.csv"
    both.write_text("0,1\n-1,0\n", encoding="utf-8")
    half.write_text("0.0e+00,0.0e+00\n-1.0e+00,0.0e+00\n", encoding="utf-8")
    assert read_truth(both).labels == read_truth(half).labels == {"1": {"2": 0}, "2": {"1": 1}}


@pytest.mark.parametrize(
    ("write", "name", "objects"),
    [
        (vmrd, "a.xml", ("notebook", "box", "mouse", "cup")),
        (vmrd, "a.xml", ("notebook_1", "box_2", "mouse_3", "cup_4")),
        (regrad, "mrt.json", ("notebook-1", "box-2", "mouse-3", "cup-4")),
        (regrad, "mrt.json", ("11", "21", "31", "41")),
    ],
)
def test_objects_are_found_under_the_names_a_scene_gives_them(write, name, objects, tmp_path):
    labels = read_truth(write(tmp_path / name)).named(("table", *objects))
    first, second, third, _ = objects
    assert (labels[first][third], labels[second][first], labels[second][third]) == (1, 0, 1)


def test_a_frame_leaves_open_what_its_annotator_was_not_sure_of(tmp_path):
    document = {
        "removal_constraints": [[3, 2], [4, 2]],
        "doubtful": {"removal_constraints": [1]},
        "uncertain_pairs": [[2, 5]],
        "relations": [[5, 1, "touch"]],
    }
    (tmp_path / "f.gt.json").write_text(json.dumps(document), encoding="utf-8")
    labels = read_truth(tmp_path / "f.gt.json").labels
    assert (labels["2"]["3"], labels["2"]["4"], labels["2"]["5"], labels["5"]["2"]) == (1, None, None, None)


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("a.json", "[]", "is no object of names"),
        ("a.json", '{"a": 1}', "neither labels nor a tree"),
        ("a.json", '{"a": {"b": 2}}', "label 'b' before 'a' is 2"),
        ("a.json", '{"a": ["b"]}', "has the parent 'b'"),
        ("a.csv", "0,1\n", "expected a square one"),
        ("a.csv", "0,x\n1,0\n", "no table of numbers"),
        ("a.xml", "<a", "is not XML"),
        ("a.xml", "<a><object><index>1</index><father><num>2</num></father></object></a>", "names objects"),
        ("a.xml", "<a/>", "has no <object>"),
        ("a.txt", "", "cannot tell what labels these are"),
        ("a.json", '{"removal_constraints": [[1, 2, 3]]}', "is no annotated frame"),
        (
            "a.json",
            '{"removal_constraints": [["a", "b"]], "doubtful": {"removal_constraints": [7]}}',
            "no annotated",
        ),
        ("a.json", '{"removal_constraints": null}', "is no annotated frame"),
    ],
)
def test_what_is_no_label_is_refused_in_a_line_that_names_the_file(name, text, words, tmp_path):
    (tmp_path / name).write_text(text, encoding="utf-8")
    with pytest.raises(InvalidInput, match=words) as refused:
        read_truth(tmp_path / name)
    assert str(tmp_path / name) in str(refused.value)


def test_labels_of_another_scene_are_refused(tmp_path):
    with pytest.raises(InvalidInput, match="unknown labelled objects '1, 2, 3, 4': the scene has cup, plate"):
        read_truth(plain(tmp_path / "a.json")).named(["plate", "cup"])


def test_what_has_no_row_of_its_own_counts_where_it_is_named(tmp_path):
    (tmp_path / "a.json").write_text('{"cup": {"lid": 1}}', encoding="utf-8")
    labels = read_truth(tmp_path / "a.json").named(["cup", "lid"])
    assert labels == {"cup": {"lid": 1}, "lid": {}}
    found = judged(Guess(frozenset({("lid", "cup")}), ("lid", "cup"), ()), labels, ("cup", "lid"))
    assert (found.right, found.false, found.missed) == ((("lid", "cup"),), (), ())


def test_an_archive_without_labels_is_none(tmp_path):
    np.savez(tmp_path / "a.npz", cup=np.zeros((4, 3)))
    with pytest.raises(InvalidInput, match="holds no text called labels"):
        read_truth(tmp_path / "a.npz")


def test_an_annotation_is_read_in_the_encoding_that_it_declares(tmp_path):
    text = vmrd(tmp_path / "a.xml").read_text(encoding="utf-8").replace("cup", "Löffel")
    for encoding in ("ISO-8859-1", "utf-16"):
        (tmp_path / "b.xml").write_text(
            f'<?xml version="1.0" encoding="{encoding}"?>{text}', encoding=encoding
        )
        assert read_truth(tmp_path / "b.xml").aliases[0]["4"] == "Löffel"


def test_a_table_may_begin_with_a_byte_order_mark(tmp_path):
    (tmp_path / "a.csv").write_text("0,-1\n1,0\n", encoding="utf-8-sig")
    assert read_truth(tmp_path / "a.csv").labels["1"]["2"] == 1
