"""API keys: who holds which; only their digests are kept."""

import hmac
import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path

_FORM = re.compile(r"(?:(?P<name>[A-Za-z0-9._-]{1,40}):)?(?P<key>[A-Za-z0-9._~+/-]{16,200}={0,2})")


@dataclass(frozen=True)
class Keys:
    """The SHA-256 of each key by the name of its client."""

    digests: dict[str, bytes] = field(default_factory=dict, repr=False)

    @classmethod
    def read(cls, given: Iterable[str], file: Path | None = None) -> "Keys":
        """Keys as `KEY` or `NAME:KEY`, given or one a line of a file; those without a name are named by
        their digest.

        Raises
        ------
        ValueError
            One is not of this form, or a name or a key is there twice. The message does not show the key.
        OSError
            The file cannot be read.
        """
        digests: dict[str, bytes] = {}
        for place, text in _places(given, file):
            if not text or text.startswith("#"):
                continue
            found = _matched(place, text)
            digest = _digest(found["key"])
            name = found["name"] or f"key-{digest.hex()[:8]}"
            if name in digests or digest in digests.values():
                raise ValueError(f"{place}: the name or the key is there already")
            digests[name] = digest
        if file is not None and not digests:
            raise ValueError(f"{file}: it holds no key; without any, everybody could ask")
        return cls(digests)

    def __bool__(self) -> bool:
        return bool(self.digests)

    def owner(self, key: str) -> str | None:
        """The name of the client that holds this key; takes the same time whichever it is."""
        offered, owner = _digest(key), None
        for name, digest in self.digests.items():
            if hmac.compare_digest(offered, digest):
                owner = name
        return owner


def _places(given: Iterable[str], file: Path | None) -> list[tuple[str, str]]:
    """Where each text stands, and the text."""
    places = [(f"api_keys[{index}]", text) for index, text in enumerate(given)]
    if file is not None:
        try:
            lines = enumerate(file.read_text(encoding="utf-8").splitlines(), 1)
        except UnicodeDecodeError:
            raise ValueError(f"{file}: it is no text in UTF-8") from None
        places += [(f"{file}, line {number}", line.strip()) for number, line in lines]
    return places


def _matched(place: str, text: str) -> re.Match[str]:
    found = _FORM.fullmatch(text)
    if found is None:
        raise ValueError(
            f"{place}: KEY or NAME:KEY is needed, the KEY of 16 to 200 letters, digits or ._~+/-, "
            "the NAME of at most 40 letters, digits or ._-"
        )
    return found


def _digest(key: str) -> bytes:
    return sha256(key.encode()).digest()
