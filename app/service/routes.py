"""The names of routes: few, however many paths clients think up."""

from collections.abc import Iterable

from starlette.routing import BaseRoute, Match, Route
from starlette.types import Scope


class RouteNames:
    """Tells which of the routes a request is for, also one that was refused before it got there."""

    def __init__(self, routes: Iterable[BaseRoute]) -> None:
        self._routes = [route for route in routes if isinstance(route, Route)]

    def name(self, scope: Scope) -> str | None:
        """The path of the route as it was declared, whatever the method; None of an unknown path."""
        if (path := getattr(scope.get("route"), "path", None)) is not None:
            return str(path)
        return next((route.path for route in self._routes if route.matches(scope)[0] is not Match.NONE), None)
