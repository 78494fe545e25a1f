from itertools import product

import numpy as np
import pytest

from topple.topology.base.errors import InvalidInput
from topple.topology.sixim.table import (
    COINCIDENT,
    ONE_SIDED_CONTACT,
    TABLE_1,
    Relation,
    classify,
    converse_matrix,
    kind_of,
)

PATTERNS = [p for p in product((0, 1), repeat=6) if any(p[:3]) and any(p[3:])]


def matching_rows(pattern: tuple[int, ...]) -> list[Relation]:
    return [
        relation
        for relation, mask in TABLE_1
        if all(w == "*" or (w == "T") == bool(bit) for w, bit in zip(mask, pattern, strict=True))
    ]


def test_49_patterns_are_possible():
    assert len(PATTERNS) == 49


@pytest.mark.parametrize("pattern", PATTERNS, ids=lambda p: "".join(map(str, p)))
def test_each_possible_pattern_matches_exactly_one_row_of_table_1(pattern):
    rows = matching_rows(pattern)
    assert len(rows) == 1
    assert classify(np.reshape(pattern, (2, 3))) is rows[0]


@pytest.mark.parametrize("pattern", PATTERNS, ids=lambda p: "".join(map(str, p)))
def test_the_converse_matrix_has_the_converse_relation(pattern):
    matrix = np.reshape(pattern, (2, 3))
    assert classify(converse_matrix(matrix)) is classify(matrix).converse
    assert kind_of(converse_matrix(matrix)) == kind_of(matrix)


@pytest.mark.parametrize("relation", list(Relation))
def test_the_converse_of_the_converse_is_the_relation(relation):
    assert relation.converse.converse is relation


@pytest.mark.parametrize("row", [0, 1])
def test_an_empty_row_is_refused(row):
    matrix = np.ones((2, 3), dtype=int)
    matrix[row] = 0
    with pytest.raises(InvalidInput, match="no two non-empty clouds"):
        classify(matrix)


def test_counts_and_truth_values_classify_alike():
    assert classify([[7, 0, 93], [0, 5, 95]]) is classify([[True, False, True], [False, True, True]])


def test_contact_seen_from_one_side_only_is_named():
    assert kind_of([[0, 0, 1], [0, 1, 1]]) == ONE_SIDED_CONTACT
    assert kind_of([[0, 1, 1], [0, 0, 1]]) == ONE_SIDED_CONTACT
    assert kind_of([[0, 0, 1], [0, 0, 1]]) is None


def test_two_objects_in_the_same_place_are_named_coincident():
    assert classify([[0, 1, 0], [0, 1, 0]]) is Relation.TOUCH
    assert kind_of([[0, 1, 0], [0, 1, 0]]) == COINCIDENT
    assert kind_of([[0, 1, 1], [0, 1, 0]]) is None
