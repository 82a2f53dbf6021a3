"""Hostile bodies, texts, packed files, meshes: a clear 4xx, little work, little memory, and life goes on."""

import contextlib
import os
import socket
import sys
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import httpx
import pytest

from primfit.app.readers import UnreadableFileError, read
from tests.app.hostile.bodies import (
    BOUNDARIES,
    CASES,
    CSV,
    GRID,
    MIB,
    PACKED_BODIES,
    QUERIES,
    REQUEST,
    UPLOADS,
    VALUES,
    Make,
    glb,
    named_part,
    upload,
)
from tests.app.hostile.measure import MEMORY, refused
from tests.app.serving import PATIENCE, Service, running, workers

AS_JSON = {"Content-Type": "application/json"}
CANARY = b"canary"
needs_proc = pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="watches memory in /proc")


@pytest.mark.parametrize(("make", "field"), CASES.values(), ids=CASES)
def test_hostile_bytes_are_refused_with_little_work_and_memory_and_the_field_named(
    make: Make, field: str
) -> None:
    error = refused(make())
    assert error.field == field
    assert "s3cret" not in error.message


# What the service refuses, and that it goes on working.


@pytest.fixture(scope="module")
def alone(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    """A service with one worker, whose memory can be watched, and bodies of at most 32 MiB."""
    with running(tmp_path_factory.mktemp("bodies"), workers=1, max_body_bytes=32 * MIB) as started:
        yield started


def _refused_by(service: Service, send: Callable[[], httpx.Response]) -> dict[str, Any]:
    """The problem that a request ends in, after checking what it cost and that the next one works."""
    watched = [service.pid, *workers(service.pid)]
    before = [_forget_peak(pid) for pid in watched]
    response = send()
    assert all(_peak(pid) - was < MEMORY for pid, was in zip(watched, before, strict=True))
    assert response.headers["content-type"] == "application/problem+json", response.text
    assert 400 <= response.status_code < 500
    assert len(response.content) <= 24 * 1024
    assert b"s3cret" not in response.content
    assert service.client.post("/fit", content=REQUEST, headers=AS_JSON).status_code == 200
    assert workers(service.pid) == watched[1:]
    problem: dict[str, Any] = response.json()
    assert len(problem["errors"]) <= 20
    return problem


def _forget_peak(pid: int) -> int:
    """Bytes that a process holds; what it held before is no longer counted."""
    with contextlib.suppress(OSError):
        Path(f"/proc/{pid}/clear_refs").write_text("5")
    return _peak(pid)


def _peak(pid: int) -> int:
    status = Path(f"/proc/{pid}/status").read_text()
    return 1024 * int(status.partition("VmHWM:")[2].split()[0])


@needs_proc
@pytest.mark.parametrize(("make", "field"), CASES.values(), ids=CASES)
def test_the_service_refuses_hostile_bytes_and_goes_on(alone: Service, make: Make, field: str) -> None:
    body = make()
    problem = _refused_by(alone, lambda: alone.post(body, "application/octet-stream", missing="error"))
    assert problem["errors"][0]["field"] == field


@needs_proc
@pytest.mark.parametrize(("make", "field"), VALUES.values(), ids=VALUES)
def test_hostile_values_beside_the_points_are_refused(alone: Service, make: Make, field: str) -> None:
    body = make()
    assert _refused_by(alone, lambda: alone.post(body, "application/json"))["errors"][0]["field"] == field


@needs_proc
@pytest.mark.parametrize(("query", "field"), QUERIES.items(), ids=[query[:20] for query in QUERIES])
def test_hostile_values_in_the_query_are_refused(alone: Service, query: str, field: str) -> None:
    headers = {"Content-Type": "text/csv"}
    problem = _refused_by(alone, lambda: alone.client.post(f"/fit?{query}", content=CSV, headers=headers))
    assert problem["errors"][0]["field"] == field


@needs_proc
@pytest.mark.parametrize(
    ("coding", "media_type", "make", "status", "field"), PACKED_BODIES.values(), ids=PACKED_BODIES
)
def test_hostile_packed_bodies_are_refused(
    alone: Service, coding: str, media_type: str, make: Make, status: int, field: str
) -> None:
    body = make()
    headers = {"Content-Type": media_type, "Content-Encoding": coding}
    problem = _refused_by(alone, lambda: alone.client.post("/fit", content=body, headers=headers))
    assert problem["status"] == status
    assert problem["errors"][0]["field"] == field


@needs_proc
@pytest.mark.parametrize(("make", "field"), UPLOADS.values(), ids=UPLOADS)
def test_hostile_uploads_are_refused(alone: Service, make: Make, field: str) -> None:
    body = make()
    problem = _refused_by(alone, lambda: alone.post(body, "multipart/form-data; boundary=x"))
    assert problem["errors"][0]["field"] == field


@needs_proc
@pytest.mark.parametrize("boundary", BOUNDARIES, ids=["none", "empty", "long", "many"])
def test_uploads_without_a_usable_boundary_are_refused(alone: Service, boundary: str) -> None:
    body = upload(named_part(b"file"))
    problem = _refused_by(alone, lambda: alone.post(body, f"multipart/form-data{boundary}"))
    assert problem["errors"][0]["field"] == "Content-Type"


@pytest.mark.parametrize("name", ["../../etc/passwd", "/etc/passwd", "n" * 300, "a%00b.ply", "..\\a.stl"])
def test_the_name_of_a_file_is_never_used(alone: Service, name: str) -> None:
    response = alone.client.post("/fit", files={"file": (name, CSV)})
    assert response.json()["primitive"]["kind"] == "cylinder"
    assert not list(alone.temporary_directory.iterdir())


def _pieces(body: bytes) -> Iterator[bytes]:
    for start in range(0, len(body), 65536):
        yield body[start : start + 65536]


OVERSIZE: dict[str, Callable[[bytes], tuple[Any, dict[str, str]]]] = {
    "a true length": lambda body: (body, {}),
    "no length": lambda body: (_pieces(body), {}),
    "no length, packed": lambda body: (_pieces(body), {"Content-Encoding": "gzip"}),
}


@needs_proc
@pytest.mark.parametrize("send", OVERSIZE.values(), ids=OVERSIZE)
def test_a_body_over_the_limit_is_refused(alone: Service, send: Any) -> None:
    def post() -> httpx.Response:
        content, headers = send(os.urandom(MIB) * 33)
        return alone.client.post("/fit", content=content, headers={"Content-Type": "text/csv", **headers})

    problem = _refused_by(alone, post)
    assert (problem["status"], problem["errors"][0]["field"]) == (413, "body")
    assert not list(alone.temporary_directory.iterdir())


@pytest.mark.parametrize("length", [b"33554433", b"1000000000000", b"9" * 400, b"-1", b"1e3", b"0x10", b""])
def test_a_length_that_lies_is_refused_before_the_body_comes(alone: Service, length: bytes) -> None:
    head = b"POST /fit HTTP/1.1\r\nHost: localhost\r\nContent-Type: text/csv\r\nContent-Length: %s\r\n\r\n"
    with socket.create_connection(("127.0.0.1", alone.port), timeout=PATIENCE) as connection:
        connection.sendall(head % length)
        assert connection.recv(65536).split(b" ")[1].startswith(b"4")
    assert alone.client.post("/fit", content=REQUEST, headers=AS_JSON).status_code == 200


# What is named inside a file is not opened.

_opened: list[str] = []
sys.addaudithook(lambda event, args: _opened.append(str(args[0])) if event == "open" else None)


def _outside(path: Path) -> dict[str, Make]:
    uris = {"path": str(path), "traversal": os.path.relpath(path), "uri": path.as_uri()}
    made: dict[str, Make] = {}
    for name, uri in uris.items():
        image: dict[str, Any] = {"images": [{"uri": uri}], "textures": [{"source": 0}]}
        made[f"glb image by {name}"] = partial(glb, GRID, **image)
        made[f"glb buffer by {name}"] = partial(glb, GRID, buffers=[{"byteLength": 600, "uri": uri}])
        made[f"glb second buffer by {name}"] = partial(
            glb,
            GRID,
            buffers=[{"byteLength": 600}, {"byteLength": 600, "uri": uri}],
            bufferViews=[{"buffer": 1, "byteLength": 600}],
        )
        text = f"mtllib {uri}\nusemtl {uri}\nmap_Kd {uri}\nv 1 2 3\nv 4 5 6\nv 7 8 10\n"
        made[f"obj material by {name}"] = text.encode
    return made


OUTSIDE = list(_outside(Path(__file__)))


@pytest.mark.parametrize("case", OUTSIDE)
def test_files_named_inside_a_mesh_are_never_opened(alone: Service, tmp_path: Path, case: str) -> None:
    canary = tmp_path / "canary.bin"
    canary.write_bytes(CANARY * 100)
    body = _outside(canary)[case]()
    del _opened[:]
    with contextlib.suppress(UnreadableFileError):
        assert len(read(body).points) in (3, 50)
    assert not [name for name in _opened if "canary" in name]
    response = alone.post(body, "application/octet-stream")
    assert response.status_code == (422 if "buffer" in case else 200)
    assert b"canary" not in response.content
