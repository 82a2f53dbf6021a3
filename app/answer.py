"""The answer of `POST /fit` and of `primfit fit --json`, built in one place and byte for byte the same."""

from collections.abc import Mapping
from dataclasses import asdict
from functools import cache
from hashlib import sha256
from importlib.metadata import version
from typing import Any

import numpy as np
import orjson

from app.readers.cloud import Array, Cloud
from fitting.constraints import Constraints
from fitting.guess import guess_of
from fitting.primitives import KINDS, Primitive, parameters
from fitting.result import Attempt, ErrorSummary, NoiseSummary, Recognition
from fitting.uncertainty import Uncertainty
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
        "extents": recognition.extents and recognition.extents.values(),
        "uncertainty": _uncertainty(recognition.uncertainty),
        "error": _summary(recognition.error),
        "noise": _summary(recognition.noise),
        "active_constraints": dict(recognition.active_constraints),
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
    constraints, guess = options.get("constraints"), options.get("initial_guess")
    counts = cloud.standard_deviations if cloud.weights is None else cloud.weights
    return {
        "input_sha256": _sha256(cloud.points),
        "weights_sha256": None if counts is None else _sha256(counts),
        "n_points": len(cloud.points),
        "format": cloud.format,
        "columns": list(cloud.columns),
        "options": {
            "kinds": list(KINDS if kinds is None else kinds),
            "classifier": classifier,
            "criterion": options.get("criterion", "robust"),
            "max_error": options.get("max_error"),
            "seed": options.get("seed", 0),
            "constraints": None if constraints is None else Constraints.of(constraints).plain(),
            "initial_guess": None if guess is None else parameters(guess_of(guess)),
        },
        "versions": versions(classifier),
    }


def _sha256(numbers: Array) -> str:
    return sha256(np.ascontiguousarray(numbers, "<f8").data).hexdigest()


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
        "error": _summary(attempt.error),
        "noise": _summary(attempt.noise),
    }


def _primitive(primitive: Primitive | None) -> dict[str, Any] | None:
    return None if primitive is None else parameters(primitive)


def _summary(summary: ErrorSummary | NoiseSummary | None) -> dict[str, float | None] | None:
    return None if summary is None else asdict(summary)


def _uncertainty(found: Uncertainty | None) -> dict[str, Any] | None:
    """In lists, as JSON has it."""
    return None if found is None else orjson.loads(to_json(asdict(found)))
