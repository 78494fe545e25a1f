"""What kind a gripper is, no file asks but those of the kinds: others ask the gripper."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
KINDS = {"ParallelJaw", "HingedJaw", "SuctionCup", "HandShape", "Jaw", "CupShape"}
NAMES = {"'fingers'", "'suction'", "'pinch'", "'rim'", "FINGERS", "SUCTION", "PINCH", "RIM"}
ASKING = ("isinstance", "issubclass", "hasattr", "getattr", "type")
OWN = {
    *(f"robots/arm/{name}.py" for name in ("jaw", "hinged", "cup")),
    *(f"planner/grasp/{name}.py" for name in ("jaw", "hand", "pinch", "widen", "suction", "grasp")),
}
"""Files of one kind each, and the one where the ways to take hold have their names."""
FILES = sorted(path for layer in ("robots", "planner") for path in (ROOT / layer).rglob("*.py"))


def asks(tree: ast.AST) -> list[int]:
    """Lines that ask whether a gripper is of a class, or whether a tool or a grasp is called so."""
    found = list[int]()
    for node in ast.walk(tree):
        words = set[str]()
        if isinstance(node, ast.Call) and ast.unparse(node.func) in ASKING:
            words = {x.id for x in ast.walk(node) if isinstance(x, ast.Name)} & KINDS
        if isinstance(node, ast.Compare):
            words = {word for part in (node.left, *node.comparators) for word in _words(part)} & NAMES
        if isinstance(node, ast.MatchClass):
            words = set(_words(node.cls)) & KINDS
        if isinstance(node, ast.MatchValue):
            words = set(_words(node.value)) & NAMES
        found += [node.lineno] if words else []
    return found


def _words(node: ast.expr) -> list[str]:
    parts = node.elts if isinstance(node, (ast.Tuple, ast.Set, ast.List)) else [node]
    return [ast.unparse(part).rpartition(".")[2] for part in parts]


def test_nobody_else_asks_what_kind_a_gripper_is():
    assert len(FILES) > 300 and {str(path.relative_to(ROOT)) for path in FILES} >= OWN
    asked = {
        f"{path.relative_to(ROOT)}:{line}"
        for path in FILES
        if str(path.relative_to(ROOT)) not in OWN
        for line in asks(ast.parse(path.read_text()))
    }
    assert asked == set()


@pytest.mark.parametrize(
    "line",
    ["isinstance(held, ParallelJaw)", "tool == FINGERS", "kind in ('pinch', 'rim')", "FINGERS in arm.tools"],
)
def test_a_question_would_be_found(line):
    assert asks(ast.parse(line)) == [1]
