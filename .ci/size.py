"""Size and shape of the source against the ceilings in pyproject.toml, `[tool.size]`: `python .ci/size.py`.

Counted by syntax tree and token in topology, robots and planner:

- code: lines with a token that belongs to no docstring, comment or import; files; types: public classes
- numbers: named numbers of modules, and fields with a number as default of classes that hold settings
- literals: floats inside functions but 0, 0.5, 1 and 2; wide: functions of seven or more parameters
- longest: lines of the longest function; knots: rooms (folders two deep) in a circle of imports
- scripts: lines of js, css and html; kernels: lines of C and C++; bench, tests: code lines of these folders

Exit 1 where a figure passes its ceiling, or a commit raised one without a line in CHANGELOG.md that begins
with "- Ceiling NAME" and says what it bought.
"""

import argparse
import ast
import io
import re
import subprocess
import sys
import tokenize
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

LAYERS = ("topology", "robots", "planner")
SETTINGS = re.compile("Settings|Tolerances|Limits|Options|Control")
NAMES = tuple("code files types numbers literals wide longest knots scripts kernels bench tests".split())
PLAIN = (0.0, 0.5, 1.0, 2.0)
WIDE = 7  # parameters
FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)
QUIET = {
    tokenize.COMMENT,
    tokenize.NL,
    tokenize.NEWLINE,
    tokenize.INDENT,
    tokenize.DEDENT,
    tokenize.ENDMARKER,
}


def code_lines(text: str, tree: ast.Module) -> int:
    """Lines that hold a token outside docstrings, comments and imports."""
    left_out: set[int] = set()
    for node in ast.walk(tree):
        if isinstance(node, (ast.Import, ast.ImportFrom)):
            left_out.update(range(node.lineno, (node.end_lineno or 0) + 1))
        if isinstance(node, (ast.Module, ast.ClassDef, *FUNCTIONS)):
            for part in node.body:
                if isinstance(part, ast.Expr) and isinstance(getattr(part.value, "value", None), str):
                    left_out.update(range(part.lineno, (part.end_lineno or 0) + 1))
    held: set[int] = set()
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type not in QUIET:
            held.update(range(token.start[0], token.end[0] + 1))
    return len(held - left_out)


def figures(root: Path) -> dict[str, int]:
    """Count everything below a checkout."""
    found = Counter(dict.fromkeys(NAMES, 0))
    arrows: dict[str, set[str]] = {}
    for path in sorted(path for layer in LAYERS for path in (root / layer).rglob("*")):
        if path.suffix in (".c", ".cc", ".cpp", ".h", ".hpp"):
            bare = re.sub(r"/\*.*?\*/", "", path.read_text(), flags=re.S)
            found["kernels"] += sum(
                bool(line.strip()) and line.strip()[:2] != "//" for line in bare.splitlines()
            )
        elif path.suffix in (".js", ".css", ".html"):
            found["scripts"] += sum(bool(line.strip()) for line in path.read_text().splitlines())
        elif path.suffix == ".py":
            text = path.read_text()
            tree = ast.parse(text)
            found["files"] += 1
            found["code"] += code_lines(text, tree)
            _count(tree, found)
            if path.name != "__init__.py":
                room = _room(path.relative_to(root).parts)
                arrows.setdefault(room, set()).update(_imported(tree, root) - {room})
    found["knots"] = sum(room in _reached(room, arrows) for room in arrows)
    for folder, name in (("tests", "tests"), ("benchmarks", "bench")):
        for path in (root / folder).rglob("*.py"):
            found[name] += code_lines(text := path.read_text(), ast.parse(text))
    return dict(found)


def _count(tree: ast.Module, found: Counter[str]) -> None:
    for part in tree.body:
        target = part.targets[0] if isinstance(part, ast.Assign) else getattr(part, "target", None)
        if isinstance(target, ast.Name) and target.id.strip("_").isupper():
            found["numbers"] += _has_number(getattr(part, "value", None))
    within = {id(x) for node in ast.walk(tree) if isinstance(node, FUNCTIONS) for x in ast.walk(node)}
    for node in ast.walk(tree):
        if isinstance(node, ast.ClassDef):
            found["types"] += not node.name.startswith("_")
            if SETTINGS.search(node.name):
                found["numbers"] += sum(
                    isinstance(x, ast.AnnAssign) and _has_number(x.value) for x in node.body
                )
        elif isinstance(node, FUNCTIONS):
            given = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
            found["wide"] += sum(x.arg not in ("self", "cls") for x in given) >= WIDE
            found["longest"] = max(found["longest"], (node.end_lineno or 0) - node.lineno + 1)
        elif isinstance(node, ast.Constant) and isinstance(node.value, float):
            found["literals"] += id(node) in within and abs(node.value) not in PLAIN


def _has_number(node: ast.AST | None) -> bool:
    return node is not None and any(
        isinstance(x, ast.Constant) and isinstance(x.value, (int, float)) and not isinstance(x.value, bool)
        for x in ast.walk(node)
    )


def _room(parts: tuple[str, ...]) -> str:
    return "/".join(parts[:2]) if len(parts) > 2 else f"{parts[0]}/."


def _imported(tree: ast.Module, root: Path) -> set[str]:
    """Rooms that a module imports from, inside functions too, for type checkers alone not."""
    typing = {
        id(x)
        for node in ast.walk(tree)
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test)
        for x in ast.walk(node)
    }
    names: list[str] = []
    for node in ast.walk(tree):
        if id(node) not in typing and isinstance(node, ast.ImportFrom):
            names.append(node.module or "")
        elif id(node) not in typing and isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
    parts = [name.split(".")[1:] for name in names if name.startswith("topple.")]
    return {
        f"{p[0]}/{p[1]}" if len(p) > 1 and (root / p[0] / p[1]).is_dir() else f"{p[0]}/."
        for p in parts
        if p[0] in LAYERS
    }


def _reached(room: str, arrows: dict[str, set[str]]) -> set[str]:
    seen: set[str] = set()
    left = list(arrows[room])
    while left:
        there = left.pop()
        if there not in seen:
            seen.add(there)
            left += arrows.get(there, ())
    return seen


def ceilings(text: str) -> dict[str, int]:
    """Ceilings of a pyproject.toml."""
    return tomllib.loads(text).get("tool", {}).get("size", {})


def raised(root: Path) -> Iterator[str]:
    """Commits that raised a ceiling without saying what it bought, and what is not committed likewise."""

    def git(*words: str) -> str:
        done = subprocess.run(["git", "-C", str(root), *words], capture_output=True, text=True, check=False)
        return done.stdout if done.returncode == 0 else ""

    commits = git("log", "--format=%H", "-S[tool.size]", "--", "pyproject.toml").split()
    if not commits:
        return
    first = commits[-1]
    # of branches side by side each sees its own ceilings: what was merged counts as one change
    mainline = "log", "--first-parent", "--reverse", "--format=%H"
    touched = git(*mainline, f"{first}..HEAD", "--", "pyproject.toml").split()
    before = ceilings(git("show", f"{first}:pyproject.toml"))
    for commit in [*touched, ""]:
        source = git("show", f"{commit}:pyproject.toml") if commit else (root / "pyproject.toml").read_text()
        change = (
            git("show", "-m", "--first-parent", commit, "--", "CHANGELOG.md")
            if commit
            else git("diff", "HEAD", "--", "CHANGELOG.md")
        )
        now = ceilings(source)
        for name, value in now.items():
            said = re.search(rf"^\+- Ceiling {name}\b", change, flags=re.M)
            if value > before.get(name, value) and not said:
                yield f"{commit[:8] or 'what is not committed'}: {name} {before[name]} -> {value}"
        before = now


def main() -> int:
    """Print every figure beside its ceiling."""
    parser = argparse.ArgumentParser(description="Size of the source against its ceilings.")
    parser.add_argument("--root", type=Path, default=Path(__file__).resolve().parents[1])
    root: Path = parser.parse_args().root
    found, most = figures(root), ceilings((root / "pyproject.toml").read_text())
    for name, value in found.items():
        ceiling = most.get(name)
        verdict = (
            "" if ceiling is None or value <= ceiling else "  OVER: make it smaller, or say what it buys"
        )
        print(f"{name:9}{value:7}{'' if ceiling is None else f' of {ceiling:6}'}{verdict}")  # noqa: T201
    silent = [f"a ceiling was raised in silence, {one}" for one in raised(root)]
    print(*silent, sep="\n", end="\n" if silent else "")  # noqa: T201
    return bool(silent) or any(found.get(name, 0) > ceiling for name, ceiling in most.items())


if __name__ == "__main__":
    sys.exit(main())
