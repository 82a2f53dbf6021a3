"""The tools by the official client, over standard input and output and over HTTP, of real servers."""

import asyncio
import base64
import json
import os
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest

import primfit
from tests.app.agents.clients import (
    SLOW,
    Client,
    Server,
    asked,
    http_server,
    http_with,
    stdio,
    words,
    write_cylinder,
    write_slow_cloud,
)
from tests.app.processes import needs_proc, ticks
from tests.app.serving import wait_for, workers
from tests.paths import EXAMPLES

TOOLS = {"fit", "fit_segments", "explain", "export"}
LIMITS = {"max_body_bytes": 40 * 2**20, "max_points": 1_450_000}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A root with some clouds, and a folder for exports beside it."""
    made = tmp_path_factory.mktemp("agents")
    (made / "in").mkdir()
    (made / "out").mkdir()
    write_cylinder(made / "in" / "pipe.npy")
    write_slow_cloud(made / "in" / "slow.npy")
    (made / "in" / "few.csv").write_text("1,2,3\n4,5,6\n")
    (made / "in" / "scan.csv").write_bytes((EXAMPLES / "segments.csv").read_bytes())
    return made


@pytest.fixture(scope="module")
def server(folder: Path) -> Iterator[Server]:
    """Over HTTP, with a root."""
    flags = ("--root", str(folder / "in"), "--output", str(folder / "out"))
    with http_server(folder / "log", *flags, temporary_directory=folder, **LIMITS) as started:
        yield started


@pytest.fixture(scope="module", params=["auto", "legacy"])
def mode(request: pytest.FixtureRequest) -> str:
    """The newest version of the protocol, and the one that begins with a handshake."""
    return str(request.param)


def _call(server: Server, tool: str, mode: str = "auto", **arguments: Any) -> Any:
    return asked(server, lambda client: client.call_tool(tool, arguments), mode)


def test_stdio_serves_the_working_directory(folder: Path) -> None:
    async def run() -> None:
        async with stdio(folder / "in") as client:
            assert {tool.name for tool in (await client.list_tools()).tools} == TOOLS
            found = await client.call_tool("fit", {"path": "pipe.npy"})
            expected = primfit.fit(folder / "in" / "pipe.npy")
            assert found.structured_content["primitive"] == expected.to_dict()["primitive"]
            refused = await client.call_tool("fit", {"path": str(EXAMPLES / "cylinder.csv")})
            assert refused.is_error and f"allowed are files under {folder / 'in'}" in words(refused)
            refused = await client.call_tool("fit", {"ticket": "x"})
            assert "tickets are for servers over HTTP" in words(refused)
            refused = await client.call_tool("export", {"path": "pipe.npy", "artifacts": ["csv"]})
            assert "started without --output" in words(refused)
            explained = await client.call_tool("explain", {"path": "pipe.npy"})
            assert [each.type for each in explained.content] == ["text", "image"]

    asyncio.run(run())


def test_tools_state_their_limits_and_units(server: Server, mode: str) -> None:
    async def ask(client: Client) -> Any:
        return client.instructions, (await client.list_tools()).tools

    instructions, tools = asked(server, ask, mode)
    assert {tool.name for tool in tools} == {*TOOLS, "upload"}
    for limit in (
        f"{LIMITS['max_body_bytes']} bytes",
        f"{LIMITS['max_points']} points",
        "60 seconds",
        "radians",
    ):
        assert limit in instructions
    for tool in tools:
        assert tool.description and tool.output_schema and "base64" not in json.dumps(tool.input_schema)


def test_a_fit_is_short_and_that_of_the_package(server: Server, folder: Path, mode: str) -> None:
    found = _call(server, "fit", mode, path="pipe.npy", options={"unit": "mm", "kinds": ["cylinder", "cone"]})
    expected = primfit.fit(folder / "in" / "pipe.npy", unit="mm", kinds=["cylinder", "cone"]).to_dict()
    told = found.structured_content
    for name in ("status", "message", "primitive", "error", "noise"):
        assert told[name] == expected[name]
    assert told["uncertainty"]["intervals"] == expected["uncertainty"]["intervals"]
    assert "covariance" not in told["uncertainty"] and told["unit"] == "mm"
    assert json.loads(words(found)) == told and len(words(found)) < 4000


def test_an_explanation_has_words_and_a_picture(server: Server, mode: str) -> None:
    found = _call(server, "explain", mode, path="pipe.npy")
    text, image = found.content
    assert "radius" in text.text and "±" in text.text and "cylinder: accepted." in text.text
    png = base64.b64decode(image.data)
    assert image.mime_type == "image/png" and png.startswith(b"\x89PNG") and len(png) <= 60_000
    assert found.structured_content["n_inliers"] == 400


def test_segments_come_in_pages(server: Server) -> None:
    expected = primfit.fit_segments(primfit.read(EXAMPLES / "segments.csv", labels="auto"))
    rows: list[Any] = []
    offset: int | None = 0
    while offset is not None:
        page = _call(server, "fit_segments", path="scan.csv", offset=offset, limit=2).structured_content
        assert page["n_segments"] == sum(page["counts"].values()) == len(expected) and len(page["rows"]) <= 2
        rows += page["rows"]
        offset = page["next_offset"]
    for row, segment in zip(rows, expected, strict=True):
        assert (row["label"], row["n_points"]) == (segment.label, len(segment.rows))
        found = segment.recognition
        assert row.get("kind") == (found and found.primitive and found.primitive.kind)
        assert row.get("problem") == (segment.problem or None)


def test_progress_is_told_of_segments(server: Server) -> None:
    told: list[tuple[float, float | None]] = []

    async def note(progress: float, total: float | None, message: str | None) -> None:
        told.append((progress, total))

    options = {"seed": 7}  # not kept from before
    asked(
        server,
        lambda client: client.call_tool(
            "fit_segments", {"path": "scan.csv", "options": options}, progress_callback=note
        ),
        "legacy",
    )
    assert told and told[-1][0] == told[-1][1]


def test_exports_are_written_once(server: Server, folder: Path) -> None:
    asked_for = {"path": "pipe.npy", "artifacts": ["step", "residuals_csv"], "options": {"unit": "mm"}}
    told = _call(server, "export", **asked_for).structured_content
    assert [Path(file["path"]).name for file in told["files"]] == [
        "pipe-primitive.step",
        "pipe-residuals.csv",
    ]
    for file in told["files"]:
        assert Path(file["path"]).stat().st_size == file["n_bytes"]
    assert (folder / "out" / "pipe-primitive.step").read_bytes().startswith(b"ISO-10303-21;")
    again = _call(server, "export", **asked_for)
    assert again.is_error and "exists; give `overwrite: true`" in words(again)
    assert not _call(server, "export", **asked_for, overwrite=True).is_error
    assert not _call(server, "export", **asked_for, name="other").is_error
    assert {file.name[:1] for file in (folder / "out").iterdir()} == {"p", "o"}


@pytest.mark.parametrize(
    ("tool", "arguments", "said"),
    [
        ("fit", {"path": "none.npy"}, "'none.npy' leads to no file"),
        ("fit", {"path": "../log"}, "leads to no file under an allowed root"),
        ("fit", {"path": "few.csv"}, "2 points given; at least 3 are needed"),
        ("fit", {}, "give either a path or a ticket"),
        ("fit", {"path": "pipe.npy", "ticket": "x"}, "give either a path or a ticket"),
        ("fit", {"ticket": "x"}, "this ticket is unknown"),
        (
            "fit",
            {"path": "pipe.npy", "options": {"seed": -1}},
            "options.seed: seed is -1; it must be at least 0",
        ),
        ("explain", {"path": "pipe.npy", "options": {"kind": ["cone"]}}, "unknown option; allowed are kinds"),
        ("fit_segments", {"path": "pipe.npy"}, "no column has a usual name of labels"),
        ("fit_segments", {"path": "scan.csv", "labels": "part"}, "labels: there is no such column"),
        (
            "export",
            {"path": "pipe.npy", "artifacts": ["dxf"]},
            "artifacts[0]: unknown artifact; allowed are step",
        ),
        (
            "export",
            {"path": "pipe.npy", "artifacts": ["step"], "name": "new"},
            "unit is not known, and a STEP file needs one",
        ),
        (
            "export",
            {"path": "pipe.npy", "artifacts": ["csv"], "name": "../x"},
            "not fit for the name of a file",
        ),
        (
            "fit",
            {"path": "pipe.npy", "kinds": ["cone"]},
            "kinds: unknown argument; allowed are path, ticket, options",
        ),
        ("explain", {"path": 5}, "path: Input should be a valid string"),
        (
            "fit_segments",
            {"path": "scan.csv", "limit": 201},
            "limit: Input should be less than or equal to 200",
        ),
    ],
)
def test_mistakes_are_told_in_the_words_of_the_service(
    server: Server, tool: str, arguments: dict[str, Any], said: str
) -> None:
    refused = _call(server, tool, **arguments)
    assert refused.is_error and said in words(refused)
    assert refused.structured_content["type"].startswith("urn:primfit:problem:")


def test_limits_are_told_with_what_is_over_them(server: Server, folder: Path) -> None:
    (folder / "in" / "large.csv").write_bytes(bytes(LIMITS["max_body_bytes"] + 1))
    refused = _call(server, "fit", path="large.csv")
    most = LIMITS["max_body_bytes"]
    assert f"'large.csv' holds {most + 1} bytes; the limit is {most} (max_body_bytes)" in words(refused)
    most = LIMITS["max_points"]
    np.save(folder / "in" / "many.npy", np.zeros((most + 1, 3), np.float32))
    assert f"{most + 1} points; the limit is {most}" in words(_call(server, "fit", path="many.npy"))


def test_a_file_is_uploaded_with_a_ticket(server: Server, folder: Path, mode: str) -> None:
    cloud = (folder / "in" / "pipe.npy").read_bytes()

    async def ask(client: Client) -> Any:
        told = (await client.call_tool("upload", {})).structured_content
        assert told["url"].startswith(f"{server.origin}/uploads/") and told["url"] in told["command"]
        assert told["max_bytes"] == LIMITS["max_body_bytes"]
        too_early = await client.call_tool("fit", {"ticket": told["ticket"]})
        assert "nothing was uploaded with this ticket yet" in words(too_early)
        assert httpx.put(told["url"], content=bytes(told["max_bytes"] + 1)).status_code == 413
        sent = httpx.put(told["url"], content=cloud)
        assert (sent.status_code, sent.json()["n_bytes"]) == (201, len(cloud))
        assert httpx.put(told["url"], content=cloud).status_code == 409
        return [await client.call_tool("fit", {"ticket": told["ticket"]}) for _ in range(2)]

    first, second = asked(server, ask, mode)
    assert first.structured_content == second.structured_content
    assert first.structured_content["primitive"]["kind"] == "cylinder"
    assert httpx.put(f"{server.origin}/uploads/guess", content=cloud).status_code == 404


@pytest.mark.parametrize("header", [{"Host": "evil.example"}, {"Origin": "http://evil.example"}], ids=str)
def test_foreign_names_and_pages_are_refused(server: Server, header: dict[str, str]) -> None:
    headers = {"Content-Type": "application/json", **header}
    for method, path in (("POST", "/mcp"), ("PUT", "/uploads/x")):
        refused = httpx.request(method, f"{server.origin}{path}", content=b"{}", headers=headers)
        assert refused.status_code in (403, 421)


def test_others_are_answered_while_a_fit_runs(server: Server) -> None:
    async def ask(client: Client) -> bool:
        slow = asyncio.create_task(client.call_tool("fit", {"path": "slow.npy", "options": SLOW}))
        await asyncio.sleep(0)
        await client.list_tools()
        await client.call_tool("upload", {})
        waited = not slow.done()
        await slow
        return waited

    assert asked(server, ask)


@needs_proc
def test_a_call_that_is_given_up_ends_the_work(server: Server, mode: str) -> None:
    async def ask(client: Client) -> Any:
        await client.call_tool("fit", {"path": "pipe.npy"})
        (worker,) = workers(server.pid)
        used = ticks(worker)
        slow = asyncio.create_task(client.call_tool("fit", {"path": "slow.npy", "options": SLOW}))
        while ticks(worker) < used + 30:  # it is at work, for 0.3 s
            await asyncio.sleep(0.05)
        slow.cancel()
        await asyncio.gather(slow, return_exceptions=True)
        return worker, await client.call_tool("fit", {"path": "pipe.npy"})

    before, found = asked(server, ask, mode)
    assert found.structured_content["status"] == "fitted"
    wait_for(lambda: before not in workers(server.pid))


def test_the_time_limit_is_kept(folder: Path) -> None:
    async def run() -> str:
        async with stdio(folder / "in", fit_time_limit=0.05) as client:
            while "waiting" in (said := words(await client.call_tool("fit", {"path": "slow.npy"}))):
                await asyncio.sleep(0.2)
            return said

    assert "not done within 0.05 s; the work was stopped" in asyncio.run(run())


def test_nothing_is_left_of_uploads_in_the_end(tmp_path: Path) -> None:
    with http_server(tmp_path / "log", temporary_directory=tmp_path) as server:
        url = _call(server, "upload").structured_content["url"]
        assert httpx.put(url, content=bytes(500_000)).status_code == 201
        assert list(tmp_path.glob("primfit-*"))
    assert not list(tmp_path.glob("primfit-*"))


def test_keys_are_asked_for_but_by_uploads(tmp_path: Path) -> None:
    key = "0123456789abcdef"
    with http_server(tmp_path / "log", api_keys=key, temporary_directory=tmp_path) as server:
        headers = {"Content-Type": "application/json"}
        assert httpx.post(server.url, content=b"{}", headers=headers).status_code == 401
        assert httpx.put(f"{server.origin}/uploads/x", content=b"").status_code == 404
        with_key = httpx.post(
            server.url, content=b"{}", headers={**headers, "Authorization": f"Bearer {key}"}
        )
        assert with_key.status_code == 400  # it is let in, and told that this is no message

        async def ask() -> Any:
            async with http_with({"X-API-Key": key}, server) as client:
                return (await client.call_tool("upload", {})).structured_content

        assert asyncio.run(ask())["ticket"]
    assert "Traceback" not in (tmp_path / "log").read_text()


@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="needs SIGHUP")
def test_sighup_has_keys_read_again_and_keeps_tickets(tmp_path: Path) -> None:
    """Without keys left, nothing changes: nobody is let in who was not before."""
    old, new = "0123456789abcdef", "fedcba9876543210"
    keys = tmp_path / "keys"
    keys.write_text(old)
    with http_server(tmp_path / "log", api_keys_file=keys) as server:

        def status(key: str) -> int:
            headers = {"Content-Type": "application/json", "X-API-Key": key}
            return httpx.post(server.url, content=b"{}", headers=headers).status_code

        def renewed(text: str, said: str) -> None:
            keys.write_text(text)
            os.kill(server.pid, signal.SIGHUP)
            wait_for(lambda: said in server.log.read_text())

        async def ask(key: str, tool: str, **arguments: Any) -> Any:
            async with http_with({"X-API-Key": key}, server) as client:
                return (await client.call_tool(tool, arguments)).structured_content

        ticket = asyncio.run(ask(old, "upload"))
        assert httpx.put(ticket["url"], content=b"1 2 3\n").status_code == 201
        renewed(new, "settings and keys are read again")
        assert (status(old), status(new)) == (401, 400)
        assert "1 point" in asyncio.run(ask(new, "fit", ticket=ticket["ticket"]))["detail"]
        renewed("", "nothing is changed")
        assert (status(old), status(new)) == (401, 400)
