"""Brings onto the site what stands outside docs/: the lab notebook beside its code, CONTRIBUTING, CHANGELOG.

Links on pages lead through the checkout, so that they work there too. Here they become links of the
site; those to code and licence, which it does not hold, become plain text.
"""

import posixpath
import re
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

ROOT = Path(__file__).resolve().parents[1]
OUTSIDE = ("benchmarks/*.md", "CONTRIBUTING.md", "CHANGELOG.md", "SECURITY.md")
CODE = re.compile(r"<code>([^<]*)</code>")
OPTION = re.compile(r"(?<![\w-])--?[a-z][\w-]*")
LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\((?!\w+:|#)([^)#\s]+)(#[^)\s]+)?\)")


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages from outside docs/."""
    for pattern in OUTSIDE:
        for path in sorted(ROOT.glob(pattern)):
            place = path.relative_to(ROOT).as_posix()
            files.append(File.generated(config, place, abs_src_path=str(path)))
    return files


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
