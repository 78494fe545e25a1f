"""Tables of Markdown, as the pages of the docs have them."""

from collections.abc import Collection, Sequence


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
