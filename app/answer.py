"""The answer of `POST /fit` and of `primfit fit --json`, built in one place and byte for byte the same."""

from collections.abc import Mapping
from dataclasses import asdict
from functools import cache
from hashlib import sha256
from importlib.metadata import version
from typing import Any

import numpy as np
import orjson

from app.readers.cloud import Cloud
from fitting.primitives import KINDS, Primitive, parameters
from fitting.result import Attempt, ErrorSummary, Recognition
from models import load_classifier


def answer(recognition: Recognition, cloud: Cloud, options: Mapping[str, Any]) -> dict[str, Any]:
    """The JSON-ready answer for one cloud.

    Parameters
    ----------
    recognition : what `engine.fit` returned
    cloud : what was read, for the receipt
    options : the keyword options given to `engine.fit`; those left out stand at their defaults
    """
    return {
        "status": recognition.status,
        "primitive": _primitive(recognition.primitive),
        "alternatives": [parameters(primitive) for primitive in recognition.alternatives],
        "message": recognition.message,
        "extents": None,
        "uncertainty": None,
        "error": _error(recognition.error),
        "attempts": [_attempt(attempt) for attempt in recognition.attempts],
        "receipt": receipt(cloud, options),
    }


def to_json(content: Mapping[str, Any]) -> bytes:
    """One line of JSON; floats in the fewest digits that read back to the same value."""
    return orjson.dumps(content, option=orjson.OPT_SERIALIZE_NUMPY)


def receipt(cloud: Cloud, options: Mapping[str, Any]) -> dict[str, Any]:
    """What was fitted and how: enough to repeat it."""
    kinds = options.get("kinds")
    classifier = options.get("classifier", "network")
    points = np.ascontiguousarray(cloud.points, "<f8")
    return {
        "input_sha256": sha256(points.data).hexdigest(),
        "n_points": len(points),
        "format": cloud.format,
        "columns": list(cloud.columns),
        "options": {
            "kinds": list(KINDS if kinds is None else kinds),
            "classifier": classifier,
            "criterion": options.get("criterion", "robust"),
            "max_error": options.get("max_error"),
            "seed": options.get("seed", 0),
        },
        "versions": versions(classifier),
    }


@cache
def versions(classifier: str) -> dict[str, str | None]:
    """Versions that decide the numbers; `weights` is the SHA-256 of the classifier's weights."""
    return {
        "primfit": version("primfit"),
        "weights": getattr(load_classifier(classifier), "sha256", None),
        "numpy": version("numpy"),
        "scipy": version("scipy"),
    }


def _attempt(attempt: Attempt) -> dict[str, Any]:
    return {
        "kind": attempt.kind,
        "probability": attempt.probability,
        "outcome": attempt.outcome,
        "reason": attempt.reason,
        "primitive": _primitive(attempt.primitive),
        "error": _error(attempt.error),
    }


def _primitive(primitive: Primitive | None) -> dict[str, Any] | None:
    return None if primitive is None else parameters(primitive)


def _error(error: ErrorSummary | None) -> dict[str, float] | None:
    return None if error is None else asdict(error)
