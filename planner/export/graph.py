"""The partial order of a plan's steps as a graph: DOT and GraphML."""

import networkx as nx

from topple.planner.planning.plan_format import Plan


def step_graph(plan: Plan) -> "nx.DiGraph[str]":
    """Steps as nodes, "has to be done before" as edges.

    Args:
        plan: The plan.

    Returns:
        A directed graph; nodes are named by step number and object, edges carry the reason where known.
    """
    reasons = {(edge.first, edge.then): edge.reason for edge in plan.dependencies}
    graph: nx.DiGraph[str] = nx.DiGraph(goal=plan.goal, robot=plan.robot)
    names = [f"{index + 1} {step.object}" for index, step in enumerate(plan.steps)]
    for name, step in zip(names, plan.steps, strict=True):
        graph.add_node(
            name, object=step.object, action=step.action, reason=step.reason, grasp=step.grasp.kind
        )
    for index, step in enumerate(plan.steps):
        for before in step.after:
            reason = reasons.get((plan.steps[before].object, step.object), "")
            graph.add_edge(names[before], names[index], reason=reason)
    return graph


def graphml(plan: Plan) -> str:
    """The step graph as GraphML."""
    return "\n".join(nx.generate_graphml(step_graph(plan))) + "\n"


def dot(plan: Plan) -> str:
    """The step graph in Graphviz's language."""
    graph = step_graph(plan)
    lines = ["digraph plan {", f"  label={_quote(plan.goal)};", "  rankdir=LR; node [shape=box];"]
    for name, data in graph.nodes(data=True):
        lines.append(f"  {_quote(name)} [label={_quote(data['action'] + ' ' + data['object'])}];")
    for first, then, data in graph.edges(data=True):
        lines.append(f"  {_quote(first)} -> {_quote(then)} [label={_quote(data['reason'])}];")
    return "\n".join([*lines, "}"]) + "\n"


def _quote(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", " ")
    return f'"{escaped}"'
