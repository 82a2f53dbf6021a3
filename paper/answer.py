"""What a method of the paper found as the answer that `primfit fit` gives, without what it does not know."""

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import replace
from importlib.metadata import version
from typing import Any

import numpy as np

from primfit.fitting.answer.result import Attempt, Outcome, Recognition
from primfit.fitting.answer.values import ErrorSummary
from primfit.fitting.cloud.frame import Frame
from primfit.fitting.extents import extents_of
from primfit.fitting.extents.values import Extents
from primfit.fitting.geometry.vectors import Array, bounds
from primfit.fitting.names import Unit
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.solver.refine import distances

from .method import DIRECTORY, Found, Method

INCLUDE = ("extents",)
"""No method knows how uncertain its parameters are, or what the noise is."""


def recognition(found: Found, points: Array, unit: Unit | None = None) -> Recognition:
    """The answer for a cloud: `fitted` where there is a primitive, for no method doubts its own.

    Distances, which are computed here, are those of all points: no method says which ones it leaves out.
    """
    answer = Recognition(
        status="no_fit" if found.primitive is None else "fitted",
        primitive=found.primitive,
        alternatives=(),
        error=None,
        noise=None,
        attempts=(),
        message=sentence(found),
        n_points=len(points),
        include=INCLUDE,
        unit=unit,
    )
    if found.primitive is None:
        return replace(answer, attempts=tuple(attempts(found, None))).with_points(points)
    error, extents = measured(found.primitive, points)
    told = tuple(attempts(found, error))
    return replace(answer, error=error, extents=extents, attempts=told).with_points(points)


def sentence(found: Found) -> str:
    """The note of a method as a sentence."""
    said = found.note or "The method answers with this kind and does not judge it"
    return said[:1].upper() + said[1:].rstrip(".") + "."


def attempts(found: Found, error: ErrorSummary | None) -> Iterator[Attempt]:
    """The kinds that were fitted; of those that are not the answer nothing more is known."""
    chances = dict(found.probabilities)
    answer = found.primitive
    for kind in found.attempts:
        outcome: Outcome = "failed" if answer is None else "refused"
        reason = sentence(found) if answer is None else "The method prefers another kind."
        if answer is not None and kind == answer.kind:
            yield Attempt(kind, chances.get(kind), "accepted", sentence(found), answer, error, None)
        else:
            yield Attempt(kind, chances.get(kind), outcome, reason, None, None, None)


def measured(primitive: Primitive, points: Array) -> tuple[ErrorSummary, Extents | None]:
    """The distances of all points, and where the primitive begins and ends about them."""
    frame = Frame.of(points)
    near, inside = frame.bring(primitive), frame.normalize(points)
    signed = frame.scale * distances(near, inside)
    far = np.abs(signed)
    rms, zone = float(np.sqrt(np.mean(signed**2))), float(np.ptp(signed))
    diagonal = float(np.linalg.norm(np.subtract(*bounds(inside)))) * frame.scale
    error = ErrorSummary(
        rms=rms,
        mean=float(far.mean()),
        p95=float(np.quantile(far, 0.95)),
        max=float(far.max()),
        zone=zone,
        relative_mean=float(far.mean()) / diagonal,
        inlier_rms=rms,
        inlier_zone=zone,
        inlier_share=1.0,
    )
    extents = extents_of(near, inside, 0.0)
    return error, extents and extents.restored(frame)


def receipt(kept: Mapping[str, Any], method: Method) -> dict[str, Any]:
    """The receipt of a cloud for a method: its name in place of options, its own weights and packages."""
    used = {name: version(name) for name in method.packages}
    return {
        **kept,
        "options": {"method": method.name},
        "versions": {**kept["versions"], "weights": weights_of(method.name), **used},
    }


def weights_of(method: str) -> str | None:
    """The SHA-256 of all weights of a method, one after the other; None where it has none."""
    files = sorted(DIRECTORY.glob(f"{method}*.npz"))
    return hashlib.sha256(b"".join(file.read_bytes() for file in files)).hexdigest() if files else None
