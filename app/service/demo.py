"""The first thing a newcomer sees: an example cloud posted to the running service, and its answer."""

import json
import time
import urllib.request
from pathlib import Path
from typing import Any

EXAMPLE = Path(__file__).parents[1] / "examples" / "cylinder.csv"
PATIENCE = 60.0


def show(url: str) -> None:
    """Wait until the service is ready, post the example, and print the answer and the curl line for it."""
    try:
        _wait(f"{url}/readyz")
        request = urllib.request.Request(
            f"{url}/fit", EXAMPLE.read_bytes(), {"Content-Type": "text/csv"}, method="POST"
        )
        with _open(request, PATIENCE) as reply:
            body = json.load(reply)
    except OSError as error:
        print(f"The example could not be fitted: {error}", flush=True)
        return
    print(f"\ncurl --header 'Content-Type: text/csv' --data-binary @{_near(EXAMPLE)} {url}/fit\n")
    print(layout(body))
    print(
        f"\nprimfit serves on {url}: open it in a browser (the API: {url}/docs). Ctrl-C stops it.\n",
        flush=True,
    )


def layout(body: dict[str, Any]) -> str:
    """JSON with one member a line and one attempt a line: short enough to read, whole enough to paste."""
    members = []
    for name, value in body.items():
        text = json.dumps(value)
        if isinstance(value, list) and value:
            text = "[\n" + ",\n".join(f"    {json.dumps(item)}" for item in value) + "\n  ]"
        members.append(f'  "{name}": {text}')
    return "{\n" + ",\n".join(members) + "\n}"


def _wait(url: str) -> None:
    deadline = time.monotonic() + PATIENCE
    while True:
        try:
            with _open(urllib.request.Request(url), 2.0):
                return
        except OSError:
            if time.monotonic() > deadline:
                raise
            time.sleep(0.1)


def _open(request: urllib.request.Request, timeout: float) -> Any:
    """Open a local address directly: a proxy for the outside world does not know it."""
    return urllib.request.build_opener(urllib.request.ProxyHandler({})).open(request, timeout=timeout)


def _near(path: Path) -> Path:
    """The path from here, where the file lies below."""
    return path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path
