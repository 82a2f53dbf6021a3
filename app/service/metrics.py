"""What the service counts, as Prometheus reads it; each application has a registry of its own."""

from collections.abc import Iterator, Mapping
from importlib.metadata import version
from typing import Any

from prometheus_client import (
    CollectorRegistry,
    Counter,
    Gauge,
    Histogram,
    ProcessCollector,
    disable_created_metrics,
    generate_latest,
)
from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily, Metric
from prometheus_client.registry import Collector

from ..workers.pool import WorkerPool

MEDIA_TYPE = "text/plain; version=0.0.4; charset=utf-8"
_SECONDS = (0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0, 10.0, 30.0, 60.0)
_POINTS = (30, 100, 300, 1e3, 3e3, 1e4, 3e4, 1e5, 3e5, 1e6, 3e6, 1e7)


class Metrics:
    """Counters and histograms of requests and fits, and what the pool of workers tells of itself."""

    def __init__(self) -> None:
        disable_created_metrics()
        self.registry = registry = CollectorRegistry()
        ProcessCollector(registry=registry)
        Gauge("primfit_info", "The version that runs; always 1.", ["version"], registry=registry).labels(
            version("primfit")
        ).set(1)
        self._requests = Histogram(
            "primfit_request_seconds",
            "Seconds from the head of a request to the end of its answer.",
            ["route", "status"],
            buckets=_SECONDS,
            registry=registry,
        )
        self._received = Counter(
            "primfit_received_bytes", "Bytes of bodies received.", ["route"], registry=registry
        )
        self._clients = Counter(
            "primfit_client_requests", "Requests that came with an API key.", ["client"], registry=registry
        )
        self._problems = Counter("primfit_problems", "Problems answered.", ["type"], registry=registry)
        self._fits = Histogram(
            "primfit_fit_seconds",
            "Seconds of fitting, without receiving and reading.",
            ["kind"],
            buckets=_SECONDS,
            registry=registry,
        )
        self._points = Histogram(
            "primfit_cloud_points", "Points of the clouds fitted.", buckets=_POINTS, registry=registry
        )
        self._answers = Counter("primfit_answers", "Clouds answered.", ["status", "kind"], registry=registry)
        self._refinements = Counter("primfit_refinements", "Kinds tried.", registry=registry)
        self._backtracks = Counter(
            "primfit_backtracks", "Kinds tried after the first one of a cloud.", registry=registry
        )

    def watch(self, pool: WorkerPool) -> None:
        """Ask this pool about itself whenever the metrics are read."""
        self.registry.register(_Pool(pool))

    def requested(self, route: str, status: int, seconds: float, facts: Mapping[str, Any]) -> None:
        """Count a request that was answered, and the cloud that its facts are of, if one was fitted."""
        self._requests.labels(route, str(status)).observe(seconds)
        self._received.labels(route).inc(facts["received_bytes"])
        if facts.get("client") is not None:
            self._clients.labels(facts["client"]).inc()
        self.answered(facts)

    def answered(self, facts: Mapping[str, Any]) -> None:
        """Count a cloud, fitted or refused, by the facts that its worker handed back."""
        if "problem" in facts:
            self._problems.labels(facts["problem"]).inc()
        if "fit_status" not in facts:
            return
        kind = facts["fit_kind"] or "none"
        self._fits.labels(kind).observe(facts["fit_seconds"])
        self._points.observe(facts["n_points"])
        self._answers.labels(facts["fit_status"], kind).inc()
        self._refinements.inc(facts["attempts"])
        self._backtracks.inc(max(0, facts["attempts"] - 1))

    def text(self) -> bytes:
        """Everything in the text format of Prometheus."""
        return generate_latest(self.registry)


class _Pool(Collector):
    """The pool's own figures at the moment they are asked for."""

    def __init__(self, pool: WorkerPool) -> None:
        self._pool = pool

    def collect(self) -> Iterator[Metric]:
        pool = self._pool
        yield GaugeMetricFamily("primfit_workers_warm", "Workers that are warm.", pool.n_warm)
        yield GaugeMetricFamily("primfit_workers_busy", "Workers that read or fit now.", pool.n_busy)
        queue = GaugeMetricFamily(
            "primfit_queue_length", "Requests, and items of batches, that wait for a worker.", labels=["lane"]
        )
        for lane, n_waiting in pool.n_waiting.items():
            queue.add_metric([lane], n_waiting)
        yield queue
        yield CounterMetricFamily(
            "primfit_worker_restarts", "Workers started in place of one that ended.", pool.n_restarts
        )
