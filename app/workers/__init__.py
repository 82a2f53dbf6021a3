"""Parsing and fitting outside the event loop."""

PRELOAD = ["primfit.app.workers.jobs", "primfit.app.workers.batch_jobs", "primfit.app.engine.warmed"]
"""What the server imports that the workers of the service are forked from."""
