"""Tables of Markdown, as the pages of the docs have them."""

from collections.abc import Collection, Sequence

from topple.topology.base.errors import InvalidInput

_MARKS = "<!-- table of topple bench {} -->", "<!-- end of table -->"


def markdown_table(
    headings: Sequence[str], rows: Sequence[Sequence[str]], right: Collection[int] = ()
) -> list[str]:
    """Lay out a table.

    Args:
        headings: Of its columns.
        rows: Its cells; a bar in one is escaped.
        right: Which columns are aligned right.

    Returns:
        Its lines.
    """
    lines = [headings, ["---:" if k in right else "---" for k in range(len(headings))]]
    lines += [[cell.replace("|", "\\|") for cell in row] for row in rows]
    return [f"| {' | '.join(line)} |" for line in lines]


def replaced_table(page: str, name: str, lines: Sequence[str]) -> str:
    """Put a bench's table into a page, in place of the one that stands between the marks of its name.

    Args:
        page: Its text, with `<!-- table of topple bench NAME -->` and after it `<!-- end of table -->`.
        name: Of the bench, and of its part where it has one: `motion --part plans`.
        lines: The table.

    Returns:
        The page's new text.

    Raises:
        InvalidInput: It has not these two marks.
    """
    begin, end = _MARKS[0].format(name), _MARKS[1]
    before, found, rest = page.partition(begin)
    _, closed, after = rest.partition(end)
    if not found or not closed:
        raise InvalidInput(f"the page has no place for the table: expected {begin!r} and after it {end!r}")
    return "".join([before, begin, "\n", *(f"{line}\n" for line in lines), end, after])
