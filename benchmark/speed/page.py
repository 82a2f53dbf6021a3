"""The parts of docs/performance.md that are measured: each between two lines of its own."""

from pathlib import Path

from ..sources import ROOT

PAGE = ROOT / "docs" / "performance.md"


class PageError(ValueError):
    """The page lacks the lines that a part stands between."""


def lines_about(part: str) -> tuple[str, str]:
    """The lines before and after a part."""
    return f"<!-- {part}: written by `primfit bench {part} --write` -->\n", f"<!-- end of {part} -->\n"


def write(part: str, text: str, command: str, page: Path = PAGE) -> None:
    """Put a part in the place of the one before; raises `PageError`."""
    begin, end = lines_about(part)
    before, found, rest = page.read_text().partition(begin)
    _, closed, after = rest.partition(end)
    if not (found and closed):
        raise PageError(f"{page} has no lines `{begin.strip()}` and `{end.strip()}`")
    page.write_text(f"{before}{begin}\n`{command}`\n\n{text}\n\n{end}{after}")
