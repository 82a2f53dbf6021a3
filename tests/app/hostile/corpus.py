"""Every hostile request by its name: what is sent, and what it may be answered.

A plain list, for whoever attacks a service: `CORPUS`. Bodies are made when they are asked for, since some are
large. None of them may cost a worker a second of the processor or 200 MB, and none may be answered by a 5xx.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from urllib.parse import quote

from tests.app.hostile import binary, bodies
from tests.app.hostile.bodies import CSV, Make, named_part, upload
from tests.app.hostile.refusals import REFUSALS

REFUSED = frozenset({413, 422})
_FORM = "multipart/form-data; boundary=x"
_JSON = "application/json"
_FILE = "application/octet-stream"
_CSV = "text/csv"


@dataclass(frozen=True)
class Hostile:
    """One request.

    Attributes
    ----------
    name : unique, `family: what it is`
    make : makes the body
    path : with the query
    headers : those beside Host and Content-Length
    statuses : that it may be answered by
    field : the first field that the problem document names, or None where any will do
    """

    name: str
    make: Make
    path: str = "/fit"
    headers: Mapping[str, str] = field(default_factory=dict)
    statuses: frozenset[int] = REFUSED
    field: str | None = None

    @property
    def body(self) -> bytes:
        return self.make()

    def request(self, host: str = "localhost") -> bytes:
        """The whole request, as it goes over a connection."""
        body = self.body
        lines = {"Host": host, **self.headers, "Content-Length": str(len(body))}
        head = "".join(f"{name}: {value}\r\n" for name, value in lines.items())
        return f"POST {self.path} HTTP/1.1\r\n{head}\r\n".encode("latin-1") + body


def _files() -> Iterator[Hostile]:
    """Files of every format, as the body itself."""
    path, headers = "/fit?missing=error", {"Content-Type": _FILE}
    for name, data in binary.CASES.items():
        status, named = REFUSALS[name]
        statuses = frozenset({int(status)})
        yield Hostile(f"binary: {name}", lambda data=data: data, path, headers, statuses, str(named))
    for name, (make, named) in bodies.CASES.items():
        yield Hostile(name, make, path, headers, field=named)


def _packed_bodies() -> Iterator[Hostile]:
    for name, (coding, media_type, make, status, named) in bodies.PACKED_BODIES.items():
        headers = {"Content-Type": media_type, "Content-Encoding": coding}
        yield Hostile(f"packed body: {name}", make, "/fit", headers, frozenset({status}), named)


def _uploads() -> Iterator[Hostile]:
    for name, (make, named) in bodies.UPLOADS.items():
        yield Hostile(f"upload: {name}", make, headers={"Content-Type": _FORM}, field=named)
    for boundary in bodies.BOUNDARIES:
        headers = {"Content-Type": f"multipart/form-data{boundary}"}
        name = f"upload: boundary {boundary[:20]!r} of {len(boundary)} characters"
        yield Hostile(name, lambda: upload(named_part(b"file")), headers=headers, field="Content-Type")


def _options() -> Iterator[Hostile]:
    for name, (make, named) in bodies.VALUES.items():
        yield Hostile(f"options: {name}", make, headers={"Content-Type": _JSON}, field=named)
    for query, named in bodies.QUERIES.items():
        name = f"query: {query[:40]} of {len(query)} characters"
        yield Hostile(name, lambda: CSV, f"/fit?{query}", {"Content-Type": _CSV}, field=named)


def _heads() -> Iterator[Hostile]:
    """Heads beyond what a head may be, however small the body is."""
    usual, too_large = {"Content-Type": _CSV}, frozenset({431})
    for name, path, headers in (
        ("a header of 40 KiB", "/fit", {"X-Long": "a" * 40 * 1024}),
        ("a header of 1 MiB", "/fit", {"X-Long": "a" * 2**20}),
        ("a name of 40 KiB", "/fit", {"X" * 40 * 1024: "a"}),
        ("101 headers", "/fit", {f"X-{i}": "a" for i in range(101)}),
        ("10,000 headers", "/fit", {f"X-{i}": "a" for i in range(10_000)}),
        ("a cookie of 100 KB", "/fit", {"Cookie": "a=b; " * 20_000}),
        ("a query of 40 KiB", "/fit?" + "kinds=plane&" * 3500, {}),
        ("a path of 40 KiB", "/" + quote("\u00e9" * 7000), {}),
    ):
        yield Hostile(f"head: {name}", lambda: CSV, path, {**usual, **headers}, too_large)


CORPUS = [case for cases in (_files, _packed_bodies, _uploads, _options, _heads) for case in cases()]
