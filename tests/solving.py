"""Planning problems in PDDL, solved by a planner of another project."""

import pytest

pytest.importorskip("unified_planning", reason="needs unified-planning (dev extra)")
pytest.importorskip("up_pyperplan", reason="needs up-pyperplan (dev extra)")


def solved(domain: str, problem: str) -> list[str]:
    """The steps that pyperplan finds, quantifiers and negations compiled away by unified-planning."""
    from unified_planning.engines import CompilationKind
    from unified_planning.io import PDDLReader
    from unified_planning.shortcuts import Compiler, OneshotPlanner, get_environment

    get_environment().credits_stream = None
    task, back = PDDLReader().parse_problem_string(domain, problem), []
    for kind in (CompilationKind.QUANTIFIERS_REMOVING, CompilationKind.NEGATIVE_CONDITIONS_REMOVING):
        with Compiler(problem_kind=task.kind, compilation_kind=kind) as compiler:
            made = compiler.compile(task, kind)
        task, back = made.problem, [made.map_back_action_instance, *back]
    with OneshotPlanner(name="pyperplan") as planner:
        plan = planner.solve(task).plan
    assert plan is not None
    for each in back:
        plan = plan.replace_action_instances(each)
    return [str(step) for step in plan.actions]
