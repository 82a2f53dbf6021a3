"""What each binary file is refused for: `REFUSALS`, the status and the field by its name, kept in a file.

`python -m tests.app.hostile.refusals` writes the file anew, to be looked at before it is kept.
"""

import json
from pathlib import Path

from primfit.app.wire.problems import problem
from tests.app.hostile.binary import CASES
from tests.app.hostile.measure import refused

_FILE = Path(__file__).with_suffix(".json")
Refusal = list[int | str]
REFUSALS: dict[str, Refusal] = json.loads(_FILE.read_text()) if _FILE.exists() else {}


def refusal(data: bytes) -> Refusal:
    """The status of the answer, and the field that is named first."""
    error = refused(data)
    return [problem(error, "/requests/1").status, error.field]


def _main() -> None:
    lines = [f"{json.dumps(name)}: {json.dumps(refusal(data))}" for name, data in CASES.items()]
    _FILE.write_text("{\n" + ",\n".join(lines) + "\n}\n")


if __name__ == "__main__":
    _main()
