"""Brings onto the site what stands outside docs/, and what the program says of itself.

CONTRIBUTING and CHANGELOG come from the root; a page a command from its help; examples of JSON from
commands that run as the site is built; the fields of a plan from its schema. Links on pages lead through the
checkout, so that they work there too. Here they become links of the site; those to code, benches and licence,
which it does not hold, become plain text.
"""

import contextlib
import io
import json
import os
import posixpath
import re
import tempfile
from pathlib import Path
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

ROOT = Path(__file__).resolve().parents[1]
OUTSIDE = ("CONTRIBUTING.md", "CHANGELOG.md", "SECURITY.md")
ROW = re.compile(r"\[[-\d.,\s]+\]")  # of numbers
CODE = re.compile(r"<code>([^<]*)</code>")
OPTION = re.compile(r"(?<![\w-])--?[a-z][\w-]*")
LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\((?!\w+:|#)([^)#\s]+)(#[^)\s]+)?\)")


CALLS = (
    "relate scene.npz",
    "order scene.npz cup",
    "order scene.npz --build",
    "check scene.npz",
    "rank scene.npz grasps.npz --robot panda",
    "run scene.npz --target cup --robot panda-suction",
    "score scene.npz --labels labels.json",
    "robot panda --no-grasp",
)
"""Commands whose JSON is shown, of a cup on a book on a table, a grasp of each and labels."""


TASKS = {
    "Read a scene": "views geometry merging scene io situation",
    "Relate": "sixim relations",
    "Order": "decide order next_view order_all",
    "Does it stand": "stability",
    "Rank grasps": "grasp",
    "Plan": "planning",
    "Build and rearrange": "building rearranging",
    "Run": "execution formats world driver arm engines scenarios catalog",
    "Draw": "report",
    "Errors and workers": "base errors",
}
"""Rooms, or names, of each task of the reference."""


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """Add a page a command, and the pages of JSON, to the menu."""
    from topple.planner.cli.main import COMMANDS

    reference: list[Any] = next(part["Reference"] for part in config.nav or () if "Reference" in part)
    commands = {"A page a command": [{f"topple {name}": f"commands/{name}.md"} for name in COMMANDS]}
    reference[1:1] = [
        commands,
        {"API by task": "api/tasks.md"},
        {"JSON by example": "json-examples.md"},
        {"Fields of a plan": "plan-fields.md"},
    ]
    return config


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages from outside docs/, and those that are made."""
    from topple.planner.cli.main import COMMANDS

    made = {f"commands/{name}.md": _help(name, purpose) for name, purpose in COMMANDS.items()}
    made |= {"json-examples.md": _documents(), "plan-fields.md": _fields(), "api/tasks.md": _tasks()}
    for place, text in made.items():
        files.append(File.generated(config, place, content=text))
    for pattern in OUTSIDE:
        for path in sorted(ROOT.glob(pattern)):
            place = path.relative_to(ROOT).as_posix()
            files.append(File.generated(config, place, abs_src_path=str(path)))
    return files


def _help(name: str, purpose: str) -> str:
    """The page of a command: what its help prints."""
    os.environ["COLUMNS"] = "80"
    return (
        f"# topple {name}\n\n{purpose[0].upper()}{purpose[1:]}.\n\n```text\n{_printed([name, '--help'])}```\n"
    )


def _printed(arguments: list[str]) -> str:
    """What a command prints."""
    from topple.planner.cli.main import main

    with contextlib.redirect_stdout(io.StringIO()) as out, contextlib.redirect_stderr(io.StringIO()):
        with contextlib.suppress(SystemExit):
            main(arguments)
    return out.getvalue()


def _documents() -> str:
    """Each command of `CALLS` with its JSON, long lists cut after their first entry."""
    import numpy as np

    def box(x: float, z: float, *size: float) -> Any:
        points, side = np.random.default_rng(1).uniform(-0.5, 0.5, (12_000, 3)), np.arange(12_000) % 3
        points[np.arange(12_000), side] = np.sign(points[np.arange(12_000), side]) * 0.5
        return points * size + (x, 0, z)

    def cut(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: cut(each) for key, each in value.items()}
        if not isinstance(value, list):
            return round(value, 4) if isinstance(value, float) else value
        whole = all(isinstance(each, (int, float, str)) for each in value) or len(json.dumps(value)) < 200
        return (
            [cut(each) for each in value]
            if whole
            else [cut(value[0]), f"... {len(value)} in all"][: len(value)]
        )

    page = "# JSON by example\n\nOf a cup on a book on a table. [What the keys say](json.md).\n"
    with tempfile.TemporaryDirectory() as folder:
        parts = {"table": box(0.5, -0.01, 0.8, 0.8, 0.02), "book": box(0.5, 0.02, 0.2, 0.15, 0.04)}
        np.savez(f"{folder}/scene.npz", **parts, cup=box(0.5, 0.08, 0.06, 0.06, 0.08), up=[0, 0, 1])
        grasps = np.tile(np.diag([1.0, -1.0, -1.0, 1.0]), (2, 1, 1))  # from above, across each
        grasps[:, :3, 3] = (0.5, 0, 0.03), (0.5, 0, 0.09)
        np.savez(f"{folder}/grasps.npz", poses=grasps, scores=[0.9, 0.8])
        Path(folder, "labels.json").write_text('{"book": {"cup": 1}, "cup": {"book": 0}}', encoding="utf-8")
        for call in CALLS:
            words = re.sub(r"\w+\.(?=npz|json)", rf"{folder}/\g<0>", call).split()
            told = cut(json.loads(_printed([*words, "--json"]).replace(f"{folder}/", "")))
            shown = ROW.sub(
                lambda row: " ".join(row[0].split()), json.dumps(told, indent=1, ensure_ascii=False)
            )
            page += f"\n## topple {call} --json\n\n```json\n{shown}\n```\n"
    return page


def _tasks() -> str:
    """The public names by task, each with what it is for and a link to its example."""
    from importlib import import_module

    rows: dict[str, list[str]] = {task: [] for task in TASKS}
    of = {word: task for task, words in TASKS.items() for word in words.split()}
    for layer in ("topology", "robots", "planner"):
        package = import_module(f"topple.{layer}")
        for name in package.__all__:
            public = getattr(package, name)
            task = of.get(name) or of[public.__module__.split(".")[2]]
            about = (public.__doc__ or "").strip().partition("\n")[0]
            rows[task].append(f"| [`{name}`]({layer}.md#topple.{layer}.{name}) | {about} |")
    parts = [f"\n## {task}\n\n| | |\n| --- | --- |\n" + "\n".join(rows[task]) + "\n" for task in TASKS]
    return "# API by task\n\nEach name leads to its arguments, errors and an example.\n" + "".join(parts)


def _fields() -> str:
    """The structs of a plan with the fields of each, from its schema."""
    from topple.planner.planning.plan_format import plan_schema

    page = "# Fields of a plan\n\nOf `plan.json`, from its published schema `plan.schema.json`.\n"
    for name, struct in plan_schema()["$defs"].items():
        about, _, told = struct.get("description", "").partition("Attributes:")
        says = dict(re.findall(r"^    (\w+): (.*(?:\n {8}.*)*)", told, re.MULTILINE))
        words = " ".join([*about.split(), *(f"`{word}`" for word in struct.get("enum", ()))])
        page += f"\n## {name}\n\n{words}\n\n| field | type | |\n| --- | --- | --- |\n"
        for field, kind in struct.get("properties", {}).items():
            page += f"| `{field}` | {_kind(kind)} | {' '.join(says.get(field, '').split())} |\n"
    return page


def _kind(schema: dict[str, Any]) -> str:
    """The type of a field, in a word or two."""
    if "anyOf" in schema:
        return " or ".join(_kind(each) for each in schema["anyOf"])
    if "$ref" in schema:
        name = schema["$ref"].rpartition("/")[2]
        return f"[{name}](#{name.lower()})"
    return (
        f"list of {_kind(schema['items'])}"
        if isinstance(schema.get("items"), dict)
        else str(schema.get("type", "any"))
    )


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Turn links through the checkout into links of the site."""
    place = page.file.src_uri
    inside = (ROOT / "docs" / place).exists()
    here = posixpath.dirname(posixpath.join("docs", place) if inside else place)

    def link(match: re.Match[str]) -> str:
        shown, words, target, heading = match.groups()
        path = posixpath.normpath(posixpath.join(here, target))  # from the root of the checkout
        uri = path.removeprefix("docs/")
        if files.get_file_from_path(uri) is not None:
            away = posixpath.relpath(uri, posixpath.dirname(place) or ".")
            return f"{shown}[{words}]({away}{heading or ''})"
        return words if (ROOT / path).exists() else match[0]

    return LINK.sub(link, markdown)


def on_page_content(html: str, **_: object) -> str:
    """Keep options in one piece, and take the backslash away that a bar needs in a table on GitHub."""

    def code(match: re.Match[str]) -> str:
        text = OPTION.sub(r'<span class="whole">\g<0></span>', match[1].replace("\\|", "|"))
        return f"<code>{text}</code>"

    return CODE.sub(code, html)


def on_post_page(output: str, **_: object) -> str:
    """Name the search dialog, which the theme leaves without a name to those who do not see it."""
    return output.replace(
        'data-md-component="search" role="dialog"',
        'data-md-component="search" role="dialog" aria-label="Search"',
    )
