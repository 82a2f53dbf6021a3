"""How tests ask a guarded service, and what a refusal holds."""

import socket

import httpx

from tests.app.serving import ALICE, PATIENCE

BEARER = {"Authorization": f"Bearer {ALICE}"}


def is_problem(response: httpx.Response, status: int, slug: str) -> None:
    assert response.status_code == status, response.text
    assert response.json()["type"] == f"urn:primfit:problem:{slug}"
    assert response.json()["instance"] == f"/requests/{response.headers['x-request-id']}"


def unfinished(port: int, *headers: str) -> bytes:
    """What comes back for the head of a request whose body never comes."""
    lines = [
        "POST /fit HTTP/1.1",
        "Host: localhost",
        "Content-Type: text/csv",
        "Content-Length: 1000000",
        *headers,
    ]
    with socket.create_connection(("127.0.0.1", port), timeout=PATIENCE) as connection:
        connection.sendall("\r\n".join([*lines, "", ""]).encode())
        return connection.recv(65536)
