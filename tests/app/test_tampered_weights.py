"""Weights that are not those of their card are not loaded, and nothing in them is unpickled."""

import io
import os
import pickle
import shutil
import zipfile
from pathlib import Path

import numpy as np
import pytest

from tests.app.serving import running, wait_for
from tests.paths import EXAMPLES, ROOT

TRACE = "0af7651916cd43dd8448eb211c80319c"


class _Bomb:
    """Makes a directory when it is unpickled."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __reduce__(self) -> tuple[object, tuple[str]]:
        return os.mkdir, (str(self.path),)


def _tampered(directory: Path, name: str) -> Path:
    """A copy of the code whose weights of this name hold a bomb, which would make `directory/unpickled`."""
    code = directory / "code"
    shutil.copytree(ROOT / "src", code, ignore=shutil.ignore_patterns("__pycache__", "training"))
    file = code / "primfit" / "models" / "weights" / f"{name}.npz"
    with np.load(file) as arrays:
        first = arrays.files[0]
    array = io.BytesIO()
    np.lib.format.write_array(array, np.array([_Bomb(directory / "unpickled")], dtype=object))
    inside = zipfile.ZipFile(file)
    entries = {entry.filename: inside.read(entry) for entry in inside.infolist()}
    inside.close()
    with zipfile.ZipFile(file, "w") as changed:
        for entry, content in (entries | {f"{first}.npy": array.getvalue()}).items():
            changed.writestr(entry, content)
    return code


def test_the_bomb_is_one(tmp_path: Path) -> None:
    pickle.loads(pickle.dumps(_Bomb(tmp_path / "unpickled")))
    assert (tmp_path / "unpickled").is_dir()


def test_a_service_with_tampered_weights_is_never_ready_and_says_why(tmp_path: Path) -> None:
    code = _tampered(tmp_path, "network")
    with running(tmp_path / "bodies", ready=False, code=code, workers=1) as service:
        wait_for(lambda: service.log.read_text().count("SHA-256") >= 2)
        response = service.client.get("/readyz")
        assert response.status_code == 503
        assert response.json()["type"] == "urn:primfit:problem:not-ready"
        assert service.client.get("/livez").status_code == 200
    line = next(line for line in service.log.read_text().splitlines() if "SHA-256" in line)
    assert " ERROR a worker did not start: WeightsMismatchError: weights network: " in line
    assert not (tmp_path / "unpickled").exists()


@pytest.mark.parametrize("classifier", ["knn"])
def test_tampered_weights_of_another_classifier_fail_the_requests_that_ask_for_it(
    tmp_path: Path, classifier: str
) -> None:
    body = (EXAMPLES / "cylinder.csv").read_bytes()
    code = _tampered(tmp_path, classifier)
    with running(tmp_path / "bodies", code=code, workers=1) as service:
        assert service.post(body, "text/csv").status_code == 200
        headers = {"Content-Type": "text/csv", "traceparent": f"00-{TRACE}-b7ad6b7169203331-01"}
        asked = {"content": body, "headers": headers, "params": {"classifier": classifier}}
        response = service.client.post("/fit", **asked)
        assert response.status_code == 500
        request_id = response.headers["x-request-id"]
        assert response.json()["instance"] == f"/requests/{request_id}"
        assert b"SHA" not in response.content
        many = service.client.post("/fit/batch", **asked)
        assert many.status_code == 200 and b'"status":500' in many.content.replace(b" ", b"")
    log = service.log.read_text()
    assert f" ERROR the request failed request_id={request_id} trace_id={TRACE}\nTraceback" in log
    of_an_item = f" ERROR the request failed request_id={many.headers['x-request-id']} trace_id={TRACE}\n"
    assert of_an_item in log
    assert f"WeightsMismatchError: weights {classifier}: the card's SHA-256" in log
    assert not (tmp_path / "unpickled").exists()
