"""How often one client may ask: a sliding window a client, kept in memory."""

import ipaddress
import math
import time

from limits import parse
from limits.storage import MemoryStorage
from limits.strategies import SlidingWindowCounterRateLimiter

from ..wire.problems import RateLimitedError

_IPV6_PREFIX = 64


class RateLimit:
    """At most so many requests of each client in a time, such as `120/minute`."""

    def __init__(self, text: str) -> None:
        self._item = parse(text)
        self._limiter = SlidingWindowCounterRateLimiter(MemoryStorage())

    def hit(self, name: str | None, address: str) -> dict[str, str]:
        """Count a request of the client with this name, else of this address; returns the headers that tell.

        Raises
        ------
        RateLimitedError
            It has asked as often as it may for now.
        """
        client = ("name", name) if name is not None else ("address", _household(address))
        allowed = self._limiter.hit(self._item, *client)
        window = self._limiter.get_window_stats(self._item, *client)
        seconds = max(1, math.ceil(window.reset_time - time.time()))
        n_requests, period = self._item.amount, self._item.get_expiry()
        headers = {
            "RateLimit-Policy": f'"client";q={n_requests};w={period}',
            "RateLimit": f'"client";r={window.remaining};t={seconds}',
        }
        if not allowed:
            message = f"{n_requests} requests in {period} s are the limit of this service for one client"
            raise RateLimitedError(message, headers | {"Retry-After": str(seconds)})
        return headers


def _household(address: str) -> str:
    """The address, or of IPv6 the network that one subscriber has for himself.

    A proxy may write an IPv4 address as one of IPv6, `::ffff:192.0.2.1`: all of these are in one network.
    """
    try:
        parsed = ipaddress.ip_address(address)
    except ValueError:
        return address
    if isinstance(parsed, ipaddress.IPv4Address):
        return address
    if parsed.ipv4_mapped is not None:
        return str(parsed.ipv4_mapped)
    return str(ipaddress.ip_network((parsed, _IPV6_PREFIX), strict=False))
