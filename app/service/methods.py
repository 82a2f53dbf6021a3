"""HEAD and OPTIONS, for all paths that there are, and what they say of other methods."""

from collections import defaultdict

from fastapi import APIRouter, FastAPI
from fastapi.routing import APIRoute
from starlette.exceptions import HTTPException
from starlette.responses import Response
from starlette.routing import Route
from starlette.types import Receive, Scope, Send


def answer_head_and_options(app: FastAPI, *routers: APIRouter) -> None:
    """HEAD wherever GET is, and for each path OPTIONS, which tells its methods; `routers` are the app's."""
    methods: defaultdict[str, set[str]] = defaultdict(set)
    routes = [*app.routes, *(route for router in routers for route in router.routes)]
    for route in routes:
        if not isinstance(route, Route):
            continue
        allowed = set(route.methods or ())
        if isinstance(route, APIRoute) and "GET" in allowed:
            app.head(route.path, include_in_schema=False)(route.endpoint)
            allowed.add("HEAD")
        methods[route.path] |= allowed
    for path, allowed in methods.items():
        app.router.routes.append(Route(path, _Others(allowed | {"OPTIONS"}), include_in_schema=False))


class _Others:
    """Answers OPTIONS, and refuses the methods that a path does not know; both tell those that it knows."""

    def __init__(self, allowed: set[str]) -> None:
        self._headers = {"Allow": ", ".join(sorted(allowed))}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["method"] != "OPTIONS":
            raise HTTPException(405, headers=self._headers)
        await Response(status_code=204, headers=self._headers)(scope, receive, send)
