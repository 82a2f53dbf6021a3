"""The answer of `POST /fit` and of `primfit fit --json`, built in one place and byte for byte the same."""

from collections.abc import Mapping
from functools import cache
from hashlib import sha256
from importlib.metadata import version
from typing import Any

import numpy as np
import orjson

from primfit.fitting.answer.result import Recognition
from primfit.fitting.names import ANSWER_PARTS
from primfit.fitting.primitives import parameters
from primfit.fitting.request.config import Config
from primfit.models import load_classifier
from primfit.models.names import CLASSIFIER

from ..readers.cloud import Array, Cloud
from ..readers.missing import DROPPED
from .fit import config_of, fit_prepared, prepared


def answer(recognition: Recognition, cloud: Cloud, options: Mapping[str, Any]) -> dict[str, Any]:
    """The JSON-ready answer for one cloud.

    Parameters
    ----------
    recognition : what `engine.fit` returned
    cloud : what was fitted, for the receipt
    options : the keyword options given to `engine.fit`; those left out stand at their defaults
    """
    return {**recognition.to_dict(), "receipt": receipt(cloud, options)}


def answered(cloud: Cloud, options: Mapping[str, Any]) -> tuple[Recognition, dict[str, Any]]:
    """Fit a cloud as it was read, with checked options: what was recognized, and the answer."""
    return answered_prepared(prepared(cloud, options), options)


def answered_prepared(cloud: Cloud, options: Mapping[str, Any]) -> tuple[Recognition, dict[str, Any]]:
    """`answered` for what `prepared` gave."""
    recognition = fit_prepared(cloud, options)
    return recognition, answer(recognition, cloud, options)


def to_json(content: Mapping[str, Any]) -> bytes:
    """One line of JSON; floats in the fewest digits that read back to the same value."""
    return orjson.dumps(content, option=orjson.OPT_SERIALIZE_NUMPY)


def receipt(cloud: Cloud, options: Mapping[str, Any]) -> dict[str, Any]:
    """What was fitted and how: enough to repeat it."""
    classifier = options.get("classifier", CLASSIFIER)
    config = config_of(**options)
    counts = cloud.standard_deviations if cloud.weights is None else cloud.weights
    return {
        "input_sha256": _sha256(cloud.points),
        "weights_sha256": None if counts is None else _sha256(counts),
        "n_points": len(cloud.points),
        "format": cloud.format,
        "columns": list(cloud.columns),
        "dropped": {name: cloud.dropped.get(name, 0) for name in DROPPED},
        "unit": cloud.unit,
        "unit_from": cloud.unit_from,
        "options": _used(config, classifier, options.get("constraints") is not None),
        "versions": versions(classifier),
    }


def _used(config: Config, classifier: str, constrained: bool) -> dict[str, Any]:
    """The options as used; `include` where a part is left out, and what is asked of the part where it is."""
    used: dict[str, Any] = {
        "kinds": list(config.kinds),
        "classifier": classifier,
        "criterion": config.criterion,
        "max_error": config.max_error,
        "tolerance": config.tolerance,
        "seed": config.seed,
        "constraints": config.constraints.plain() if constrained else None,
        "initial_guess": config.initial_guess and parameters(config.initial_guess),
    }
    if config.include != ANSWER_PARTS:
        used["include"] = list(config.include)
    if config.nominal is not None:
        used["nominal"] = config.nominal.plain()
    if config.form_tolerance is not None:
        used["form_tolerance"] = config.form_tolerance
    return used


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
