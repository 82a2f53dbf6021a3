"""Names from outside, made fit to be shown and to name a result: never a path, printable, not endless."""

import re
from collections import Counter

LONGEST = 80
_FILE_LENGTH, _LABEL_LENGTH = 50, 22
# What a file name may not hold on one system or another.
_UNWANTED = re.compile(r'[/\\:*?"<>|]')


def base_name(name: str | None) -> str | None:
    """The last component of the name that came with a file, or None where nothing of it is left."""
    return plain(re.split(r"[/\\]", name or "")[-1]) or None


def plain(text: str, length: int = LONGEST) -> str:
    """The first characters of a text, those that cannot stand in the name of a file as `_`."""
    shown = "".join(letter if letter.isprintable() else "_" for letter in _UNWANTED.sub("_", text[:length]))
    return shown.strip(" .")


class Ids:
    """Hands out ids of at most 80 characters; no two are the same, not even with other capitals."""

    def __init__(self) -> None:
        self._given: set[str] = set()
        self._repeated: Counter[str] = Counter()

    def of_file(self, name: str | None, number: int) -> str:
        """The id of the file of this name, or of this number where it has none."""
        return self.unique(name[:_FILE_LENGTH] if name else f"file-{number}")

    def of_segment(self, file_id: str, label: int | str) -> str:
        """The id of a segment of a file."""
        return self.unique(f"{file_id[:_FILE_LENGTH]}#{plain(str(label), _LABEL_LENGTH)}")

    def unique(self, wanted: str) -> str:
        """The text, with `~2`, `~3`, ... behind it where it was given before."""
        found = wanted
        while found.casefold() in self._given:
            self._repeated[wanted.casefold()] += 1
            found = f"{wanted}~{self._repeated[wanted.casefold()] + 1}"
        self._given.add(found.casefold())
        return found
