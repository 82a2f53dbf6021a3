"""What people and browsers do first: `/`, HEAD, curl's own media type, names of downloads, other origins."""

import re
from collections.abc import Iterator

import httpx
import pytest

from primfit.app.service.browsers import Addressee
from primfit.app.wire.disposition import attachment
from tests.app.service.asking import is_problem
from tests.app.service.connections import answer as answer_of
from tests.app.service.connections import statuses
from tests.app.serving import ALICE, Service, running
from tests.paths import EXAMPLES

CSV = (EXAMPLES / "few.csv").read_bytes()
ORIGIN = "https://viewer.example.com"


@pytest.fixture(scope="module")
def shared_service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    """A service with a key, which a page of another origin may ask."""
    folder = tmp_path_factory.mktemp("bodies")
    with running(folder, workers=1, api_keys=f"alice:{ALICE}", cors_origins=ORIGIN.upper()) as started:
        yield started


def _preflight(service: Service, origin: str) -> httpx.Response:
    asked = {"Origin": origin, "Access-Control-Request-Method": "POST"}
    asked["Access-Control-Request-Headers"] = "authorization,content-type,if-none-match,x-request-id"
    return service.client.options("/fit", headers=asked)


@pytest.mark.parametrize("name", ["service", "guarded_service"])
def test_the_page_and_its_parts_need_no_key_and_no_prefix(request: pytest.FixtureRequest, name: str) -> None:
    """All that it names lies beside it: a proxy may have taken a prefix away."""
    client = request.getfixturevalue(name).client
    page = client.get("/")
    assert page.headers["content-type"].startswith("text/html")
    parts = re.findall(r'(?:src|href)="([^"]+)"', page.text)
    assert {"docs", "viewer/viewer.js", "viewer/viewer.css"} <= set(parts)
    for part in parts:
        assert part == "data:," or client.get(f"/{part}").status_code == 200


@pytest.mark.parametrize(
    "path", ["/", "/docs", "/openapi.json", "/livez", "/readyz", "/version", "/capabilities", "/metrics"]
)
def test_head_is_get_without_a_body(service: Service, path: str) -> None:
    got, head = service.client.get(path), service.client.head(path)
    assert (head.status_code, head.content) == (got.status_code, b"")
    assert head.headers["x-request-id"]
    assert head.headers.get("content-type") == got.headers.get("content-type")


def test_head_is_for_what_can_be_got(service: Service) -> None:
    assert service.client.head("/fit").status_code == 405
    assert service.client.head("/nothing").status_code == 404
    paths = service.client.get("/openapi.json").json()["paths"]
    assert "/" not in paths and not any("head" in operations for operations in paths.values())


def test_what_curl_sends_by_itself_is_told_what_to_send(service: Service) -> None:
    answer = service.post(CSV, "application/x-www-form-urlencoded")
    is_problem(answer, 415, "unsupported-media-type")
    detail = answer.json()["detail"]
    assert "curl --data-binary @FILE -H 'Content-Type: application/octet-stream'" in detail
    assert "curl -F file=@FILE" in detail and "curl -d" in detail


@pytest.mark.parametrize("copies", [1, 200])
def test_a_cloud_without_line_ends_is_told_so(service: Service, copies: int) -> None:
    answer = service.post(CSV.replace(b"\n", b"") * copies, "text/csv")
    is_problem(answer, 422, "unreadable-input")
    assert answer.json()["detail"].endswith("curl -d takes the line ends out of a file: use --data-binary")


@pytest.mark.parametrize(
    ("uploaded", "header"),
    [
        ("scan.csv", 'filename="scan.zip"'),
        ("C:\\clouds\\part 7.xyz.gz", 'filename="part 7.zip"'),
        ("../../etc/passwd", 'filename="passwd.zip"'),
        (".csv", 'filename="csv.zip"'),
        ("größe 5%.ply", "filename=\"gr__e 5_.zip\"; filename*=UTF-8''gr%C3%B6%C3%9Fe%205%25.zip"),
        ("a\r\nSet-Cookie: b.csv", "filename=\"a_0D_0ASet-Cookie_ b.zip\"; filename*=UTF-8''"),
    ],
)
def test_an_export_is_named_after_the_upload(service: Service, uploaded: str, header: str) -> None:
    files = {"file": (uploaded, CSV)}
    answer = service.client.post("/fit/export", files=files, params={"artifacts": "csv"})
    assert answer.status_code == 200, answer.text
    assert answer.headers["content-disposition"].startswith(f"attachment; {header}")


def test_a_name_cannot_end_its_quotes() -> None:
    assert attachment('a"; b\\c.zip').startswith('attachment; filename="a_; b_c.zip"; filename*=')


def test_an_export_of_a_nameless_cloud_has_a_name(service: Service) -> None:
    headers = {"Content-Type": "text/csv"}
    answer = service.client.post("/fit/export?artifacts=csv", content=CSV, headers=headers)
    assert answer.headers["content-disposition"] == 'attachment; filename="primfit.zip"'


def test_a_page_of_another_origin_may_ask_where_it_is_allowed(shared_service: Service) -> None:
    allowed = _preflight(shared_service, ORIGIN)
    assert (allowed.status_code, allowed.headers["access-control-allow-origin"]) == (200, ORIGIN)
    headers = {"Origin": ORIGIN, "Authorization": f"Bearer {ALICE}", "Content-Type": "text/csv"}
    answer = shared_service.client.post("/fit", content=CSV, headers=headers)
    assert (answer.status_code, answer.headers["access-control-allow-origin"]) == (200, ORIGIN)
    seen = answer.headers["access-control-expose-headers"].lower().split(", ")
    assert {"etag", "server-timing", "x-request-id", "retry-after", "content-disposition"} <= set(seen)


def test_a_page_of_an_allowed_origin_sees_why_it_is_refused(shared_service: Service) -> None:
    answer = shared_service.client.post("/fit", content=CSV, headers={"Origin": ORIGIN})
    is_problem(answer, 401, "unauthorized")
    assert answer.headers["access-control-allow-origin"] == ORIGIN


def test_other_pages_may_not_ask(shared_service: Service, service: Service) -> None:
    for asked, origin in ((shared_service, "https://other.example.com"), (service, ORIGIN)):
        for answer in (_preflight(asked, origin), asked.client.get("/livez", headers={"Origin": origin})):
            is_problem(answer, 403, "foreign-origin")
            assert "access-control-allow-origin" not in answer.headers


# Under which names it is asked.


async def _nobody(*_: object) -> None:
    raise AssertionError


@pytest.fixture(scope="module")
def named_service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    """A service that may be asked under two names, whose probes nobody told of them."""
    folder = tmp_path_factory.mktemp("bodies")
    with running(folder, workers=1, allowed_hosts="primfit.example.com, *.internal") as started:
        yield started


def _by(service: Service, host: str, path: str = "/version", **headers: str) -> httpx.Response:
    return service.client.get(path, headers={"Host": host, **headers})


@pytest.mark.parametrize(
    ("host", "allowed"),
    [
        ("localhost", True),
        ("LOCALHOST:8000", True),
        ("localhost.:80", True),
        ("primfit.localhost", True),
        ("127.0.0.1", True),
        ("127.1.2.3:9999", True),
        ("[::1]:8000", True),
        ("[::ffff:127.0.0.1]:8000", True),
        ("[::FFFF:7f00:1]", True),
        ("", False),
        ("evil.example.com", False),
        ("localhost.evil.example.com", False),
        ("evillocalhost", False),
        ("127.0.0.1.evil.example.com", False),
        ("127.0.0.1@evil.example.com", False),
        ("192.168.0.1", False),
        ("0.0.0.0", False),
        ("[::2]", False),
        ("[::ffff:192.168.0.1]", False),
        ("[::1", False),
        ("::1", False),
        ("localhost:80:80", False),
        ("localhost/", False),
    ],
)
def test_on_a_loopback_address_it_is_asked_by_a_name_of_it(
    service: Service, host: str, allowed: bool
) -> None:
    answer = _by(service, host)
    if allowed:
        assert answer.status_code == 200
    else:
        is_problem(answer, 421, "wrong-host")


@pytest.mark.parametrize(
    ("host", "allowed"),
    [
        ("primfit.example.com", True),
        ("PRIMFIT.example.com.:443", True),
        ("a.internal", True),
        ("a.b.internal:80", True),
        ("internal", False),
        ("xinternal", False),
        ("a.primfit.example.com", False),
        ("localhost", False),
    ],
)
def test_names_that_are_allowed_take_the_place_of_those(
    named_service: Service, host: str, allowed: bool
) -> None:
    assert _by(named_service, host).status_code == (200 if allowed else 421)
    assert _by(named_service, host, "/readyz").status_code == 200


@pytest.mark.parametrize("host", ["10.42.0.7:8000", "primfit", "evil.example.com", "[fd00::1]:80", "a_b"])
def test_on_other_addresses_every_name_is_taken(host: str) -> None:
    """As in a container, which is asked by its name, its address, or that of a published port."""
    scope = {"type": "http", "http_version": "1.1", "path": "/fit", "headers": [(b"host", host.encode())]}
    for hosts, local, refused in (((), False, False), (("*",), True, False), ((), True, True)):
        assert (Addressee(_nobody, hosts, local, ())._refusal(scope) is not None) == refused


@pytest.mark.parametrize(
    "hosts", ["", "Host: localhost\r\nHost: localhost\r\n", "Host: localhost\r\nHost: x\r\n"]
)
def test_one_host_is_needed(service: Service, hosts: str) -> None:
    answered = answer_of(service.port, f"GET /version HTTP/1.1\r\n{hosts}Connection: close\r\n\r\n".encode())
    assert statuses(answered) == [400] and b"malformed-request" in answered


# By which pages.


def test_pages_of_the_service_itself_may_ask(service: Service) -> None:
    host = f"localhost:{service.port}"
    for origin in (f"http://{host}", f"https://{host}".upper()):
        assert _by(service, host, Origin=origin).status_code == 200
    # A proxy has changed Host, and a browser says that it is the same page.
    same = {"Origin": "https://primfit.example.com", "Sec-Fetch-Site": "same-origin"}
    assert _by(service, host, **same).status_code == 200


@pytest.mark.parametrize(
    ("host", "origin", "same"),
    [
        ("localhost:80", "http://localhost", True),
        ("localhost:443", "https://LOCALHOST", True),
        ("localhost", "https://localhost:443", True),
        ("[::1]:80", "http://[::1]", True),
        ("localhost:8080", "http://localhost", False),
        ("localhost:80", "http://localhost:8000", False),
        ("localhost:80", "http://localhost.evil.example.com", False),
        ("localhost:80", "http://127.0.0.1", False),
        (":80", "null", False),
        (":80", "http://:80", False),
    ],
)
def test_the_default_port_may_be_left_out(host: str, origin: str, same: bool) -> None:
    """As browsers do; a proxy (nginx: `$host:$server_port`) may put it in."""
    headers = [(b"host", host.encode()), (b"origin", origin.encode())]
    scope = {"type": "http", "http_version": "1.1", "path": "/fit", "headers": headers}
    assert (Addressee(_nobody, (), False, ())._refusal(scope) is None) == same


@pytest.mark.parametrize("site", [{}, {"Sec-Fetch-Site": "cross-site"}, {"Sec-Fetch-Site": "same-site"}])
@pytest.mark.parametrize(
    "origin", ["null", "", "http://evil.example.com", "http://localhost", "http://localhost:1", "localhost"]
)
def test_pages_of_elsewhere_may_not(service: Service, origin: str, site: dict[str, str]) -> None:
    headers = {"Host": f"localhost:{service.port}", "Origin": origin, "Content-Type": "text/csv", **site}
    is_problem(service.client.post("/fit", content=CSV, headers=headers), 403, "foreign-origin")


def test_every_page_may_where_all_origins_are_allowed() -> None:
    headers = [(b"host", b"primfit"), (b"origin", b"https://anywhere.example.com")]
    scope = {"type": "http", "http_version": "1.1", "path": "/fit", "headers": headers}
    assert Addressee(_nobody, (), False, ("*",))._refusal(scope) is None


# What it tells them.


@pytest.mark.parametrize(
    ("path", "methods"),
    [
        ("/fit", "OPTIONS, POST"),
        ("/fit/batch", "OPTIONS, POST"),
        ("/livez", "GET, HEAD, OPTIONS"),
        ("/openapi.json", "GET, HEAD, OPTIONS"),
        ("/docs", "GET, HEAD, OPTIONS"),
        ("/", "GET, HEAD, OPTIONS"),
    ],
)
@pytest.mark.parametrize("name", ["service", "guarded_service", "shared_service"])
def test_options_tell_the_methods(request: pytest.FixtureRequest, name: str, path: str, methods: str) -> None:
    answer = request.getfixturevalue(name).client.options(path)
    assert (answer.status_code, answer.content, answer.headers["allow"]) == (204, b"", methods)


@pytest.mark.parametrize(
    ("method", "path", "methods"),
    [
        ("PUT", "/docs", "GET, HEAD, OPTIONS"),
        ("GET", "/fit", "OPTIONS, POST"),
        ("PUT", "/jobs", "GET, HEAD, OPTIONS, POST"),
        ("PATCH", "/jobs/1", "DELETE, GET, HEAD, OPTIONS"),
        ("LOCK", "/livez", "GET, HEAD, OPTIONS"),
    ],
)
def test_another_method_is_told_those_that_there_are(
    service: Service, method: str, path: str, methods: str
) -> None:
    answer = service.client.request(method, path)
    is_problem(answer, 405, "method-not-allowed")
    assert answer.headers["allow"] == methods


def test_options_are_for_paths_that_there_are(service: Service) -> None:
    is_problem(service.client.options("/nothing"), 404, "not-found")
    paths = service.client.get("/openapi.json").json()["paths"]
    assert not any("options" in operations for operations in paths.values())


@pytest.mark.parametrize("path", ["/livez", "/docs", "/nothing", "/fit", "/metrics"])
def test_nothing_is_taken_for_what_it_is_not(service: Service, path: str) -> None:
    answer = service.client.get(path)
    assert answer.headers["x-content-type-options"] == "nosniff"
    if path == "/docs" or answer.status_code >= 400:
        assert "default-src 'none'" in answer.headers["content-security-policy"]
