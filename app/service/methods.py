"""HEAD and OPTIONS, for all paths that there are."""

from collections import defaultdict
from functools import partial

from fastapi import APIRouter, FastAPI, Request, Response
from fastapi.routing import APIRoute
from starlette.routing import Route


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
        told = {"Allow": ", ".join(sorted(allowed | {"OPTIONS"}))}
        app.add_route(path, partial(_nothing, told), methods=["OPTIONS"], include_in_schema=False)


async def _nothing(headers: dict[str, str], request: Request) -> Response:
    return Response(status_code=204, headers=headers)
