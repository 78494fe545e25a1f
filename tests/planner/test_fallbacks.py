"""Every way out stands in one list, with when it applies."""

import ast
import inspect

from topple.planner.fallbacks import Fallback


def test_every_fallback_is_told_of_in_words_of_its_own() -> None:
    (listed,) = ast.parse(inspect.getsource(Fallback)).body
    assert isinstance(listed, ast.ClassDef)
    names, words = listed.body[1::2], listed.body[2::2]
    told = [ast.literal_eval(each.value) for each in words if isinstance(each, ast.Expr)]
    assert len(names) == len(told) == len(Fallback) and all(isinstance(each, ast.Assign) for each in names)
    assert all(": " in each for each in told) and len(set(told)) == len(told)
    assert len({str(each) for each in Fallback}) == len(Fallback)
