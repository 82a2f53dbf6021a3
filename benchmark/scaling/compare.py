"""Whether two runs left the same bytes, and each segment once."""

from filecmp import cmp
from pathlib import Path

from . import asked as app
from .records import RunRecord


def compared(left: RunRecord, right: RunRecord, folder: Path) -> tuple[bool, str]:
    """Whether all is as it should be, and what there is to say of it."""
    differ = different_files(*(folder / "runs" / record.asked.name for record in (left, right)))
    same = left.digest == right.digest and not differ
    lines = [f"parts of {left.asked.name} and {right.asked.name}: {len(left.tasks)} and {len(right.tasks)}"]
    lines.append(
        "equal byte for byte" if same else f"different: {', '.join(differ[:5]) or 'by their SHA-256'}"
    )
    lines += [_once(record) for record in (left, right)]
    return same and all(record.once for record in (left, right)), "\n".join(lines)


def different_files(left: Path, right: Path) -> list[str]:
    """The names of parts that are not the same, or that only one of two folders has; none where a folder is
    gone, of which the records tell."""
    if not (left.is_dir() and right.is_dir()):
        return []
    names = [{file.name for file in app.part_files(folder)} for folder in (left, right)]
    both = names[0] & names[1]
    differ = {name for name in both if not cmp(left / name, right / name, shallow=False)}
    return sorted((names[0] ^ names[1]) | differ)


def _once(record: RunRecord) -> str:
    once = "each segment exactly once" if record.once else "NOT each segment once"
    return f"{record.asked.name}: {record.rows:,} rows for {record.expected:,} segments, {once}"
