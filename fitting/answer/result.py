"""What `recognize` hands back: values, never exceptions, for every expected outcome."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from html import escape
from typing import TYPE_CHECKING, Any, Literal, Self

import numpy as np
import orjson
from numpy.typing import NDArray

from ..errors import InvalidPointCloudError
from ..extents.values import Extents
from ..geometry.vectors import Array
from ..names import ANSWER_PARTS, Unit
from ..plain import plain
from ..primitives import parameters
from ..primitives.primitive import Primitive
from ..uncertainty.values import Uncertainty
from ..verdict.judge import Status
from .conformance import Conformance
from .residuals import InlierRule
from .summary import summary
from .values import ErrorSummary, NoiseSummary

if TYPE_CHECKING:
    from k3d.plot import Plot
    from matplotlib.axes import Axes

Outcome = Literal["accepted", "refused", "failed"]


@dataclass(frozen=True)
class Attempt:
    """One kind that was tried: what it reached and why it was accepted, refused, or failed.

    Attributes
    ----------
    reason : why, in sentences
    probability : what the classifier gave it; None where it was not asked
    evidence : natural logarithm of the kind's probability over that of the best kind: 0 for that one,
        negative for the others, but for those refused by themselves or equal within `tolerance`; None if the
        kind was not weighed

    Examples
    --------
    >>> import numpy as np, primfit
    >>> azimuth, polar = np.random.default_rng(0).random((2, 300)) * np.array([[6.0], [3.0]])
    >>> points = primfit.Sphere([0, 0, 0], 2.0).surface(azimuth, polar)
    >>> [(attempt.kind, attempt.outcome) for attempt in primfit.fit(points, kinds=["sphere"]).attempts]
    [('sphere', 'accepted')]
    """

    kind: str
    probability: float | None
    outcome: Outcome
    reason: str
    primitive: Primitive | None
    error: ErrorSummary | None
    noise: NoiseSummary | None
    evidence: float | None = None

    def to_dict(self) -> dict[str, Any]:
        """Plain values, as in `attempts` of the body of `POST /fit`."""
        return {
            "kind": self.kind,
            "probability": plain(self.probability),
            "outcome": self.outcome,
            "reason": self.reason,
            "primitive": self.primitive and parameters(self.primitive),
            "error": plain(self.error),
            "noise": plain(self.noise),
            "evidence": plain(self.evidence),
        }


@dataclass(frozen=True)
class Alternative:
    """Another kind that explains an ambiguous cloud, too.

    Attributes
    ----------
    extents : where it begins and ends; None if its points span no surface, or where they were not asked for
    uncertainty : how well its parameters are known; None where that was not asked for
    evidence : natural logarithm of its probability over that of the best kind, as in its attempt: 0 for that
        one, negative for the others, but for those refused by themselves or equal within `tolerance`; None if
        the kind was not weighed
    active_constraints : how each constraint acts on it, as those of the answer

    Examples
    --------
    Two rings lie on a sphere and on a cone:

    >>> import numpy as np, primfit
    >>> angle = np.linspace(0.0, 6.0, 60)
    >>> ring = np.stack([np.cos(angle), np.sin(angle), np.zeros(60)], axis=1)
    >>> points = np.vstack([ring, [2, 2, 1] * (ring + [0, 0, 1])])
    >>> recognition = primfit.fit(points, kinds=["sphere", "cone"])
    >>> recognition.status, [other.primitive.kind for other in recognition.alternatives]
    ('ambiguous', ['cone'])
    """

    primitive: Primitive
    error: ErrorSummary
    extents: Extents | None
    uncertainty: Uncertainty | None
    evidence: float | None
    active_constraints: Mapping[str, str] = field(default_factory=dict)

    def to_dict(self) -> dict[str, Any]:
        """The parameters, with what stands beside `primitive` in the answer."""
        return {
            **parameters(self.primitive),
            "error": plain(self.error),
            "extents": self.extents and self.extents.values(),
            "uncertainty": plain(self.uncertainty),
            "evidence": plain(self.evidence),
        }


@dataclass(frozen=True)
class Source:
    """Where the points of an answer are from, for reports: the name of the file, its format and its columns.

    `name` is None where there was no file.
    """

    name: str | None
    format: str
    columns: tuple[str, ...]


@dataclass(frozen=True)
class Recognition:
    """The answer for one cloud; `print` shows it in words and aligned numbers, a notebook with a picture.

    It keeps the points that it is about, by reference, for `inliers`, `residuals` and pictures. They take no
    part in a comparison, and are left behind when it is pickled: `with_points` gives them again.

    Attributes
    ----------
    status : `fitted`; `ambiguous`: `alternatives` explain the cloud as well; `no_fit`: nothing is good enough
    primitive : the accepted one; the first of several of an `ambiguous` cloud, the best try with `no_fit`,
        and None only if every attempt failed
    alternatives : the other kinds that explain an `ambiguous` cloud, the likelier first: of each its
        parameters, error, extents, uncertainty and evidence
    attempts : every kind that was tried, in order
    message : the status in sentences, with lengths in the unit of the input; for people, as texts may change
    active_constraints : how each constraint acts on `primitive`, by its name: `at its upper bound 5.0`, or
        `not applicable: a plane has no radius` where its kind has no such parameter
    extents : where `primitive` begins and ends; None without one, if its points span no surface, or where
        they were not asked for (`include`)
    uncertainty : how well `primitive` is known; None with `no_fit`, and with `minimum_zone`,
        `minimum_circumscribed` and `maximum_inscribed`, or where it was not asked for (`include`)
    conformance : `form_tolerance` and `nominal` held against what was found; None where neither was given
    inlier_rule : which points belong to `primitive`, these or others; None without one
    include : which of the parts `extents` and `uncertainty` were asked for
    warnings : what to know of the points, as that some are missing, a sentence each
    unit : of all lengths, where it is known
    points : (N, 3) that were given, NaN where one was missing; None where they were left behind
    source : of these points, where `fit` had them from; None where that is not known. No part of a comparison

    Examples
    --------
    >>> import numpy as np, primfit
    >>> azimuth, height = np.random.default_rng(0).random((2, 300)) * np.array([[6.0], [9.0]])
    >>> points = primfit.Cylinder(axis=[0, 0, 1], point=[0, 0, 0], radius=2.0).surface(azimuth, height)
    >>> recognition = primfit.fit(points)
    >>> recognition
    <Recognition: fitted, cylinder, 300 points>
    >>> int(recognition.inliers.sum()), recognition.residuals.shape
    (300, (300,))
    """

    status: Status
    primitive: Primitive | None
    alternatives: tuple[Alternative, ...]
    error: ErrorSummary | None
    noise: NoiseSummary | None
    attempts: tuple[Attempt, ...]
    message: str
    n_points: int
    active_constraints: Mapping[str, str] = field(default_factory=dict)
    extents: Extents | None = None
    uncertainty: Uncertainty | None = None
    conformance: Conformance | None = None
    inlier_rule: InlierRule | None = None
    include: tuple[str, ...] = ANSWER_PARTS
    warnings: tuple[str, ...] = ()
    unit: Unit | None = None
    points: Array | None = field(default=None, repr=False, compare=False)
    source: Source | None = field(default=None, repr=False, compare=False)

    @property
    def residuals(self) -> Array:
        """(N,) signed distances of all points from `primitive` [length]; NaN without one."""
        points = self.kept_points()
        return (
            np.full(len(points), np.nan) if self.primitive is None else self.primitive.signed_distance(points)
        )

    @property
    def inliers(self) -> NDArray[np.bool_]:
        """(N,) which of the points belong to `primitive`: those that were not rejected as outliers."""
        points = self.kept_points()
        return np.zeros(len(points), bool) if self.inlier_rule is None else self.inlier_rule.among(points)

    def kept_points(self) -> Array:
        """`points`; raises `InvalidPointCloudError` where they were left behind."""
        if self.points is None:
            raise InvalidPointCloudError(
                "the answer left its points behind when it was pickled; with_points gives them again"
            )
        return self.points

    def with_points(self, points: object) -> Self:
        """The same answer with the points (N, 3) that it is about."""
        array = np.asarray(points, np.float64)
        if array.ndim != 2 or array.shape[1] != 3:
            raise InvalidPointCloudError(f"points have shape {array.shape}; (N, 3) is needed")
        return replace(self, points=array, source=None)

    def __getstate__(self) -> dict[str, Any]:
        """Without the points: an answer is small, whatever the cloud."""
        return self.__dict__ | {"points": None}

    def to_dict(self) -> dict[str, Any]:
        """Plain values: the body of `POST /fit` without its receipt."""
        return {
            "status": self.status,
            "primitive": self.primitive and parameters(self.primitive),
            "alternatives": [other.to_dict() for other in self.alternatives],
            "message": self.message,
            "warnings": list(self.warnings),
            "extents": self.extents and self.extents.values(),
            "uncertainty": plain(self.uncertainty),
            "error": plain(self.error),
            "noise": plain(self.noise),
            "active_constraints": dict(self.active_constraints),
            "conformance": plain(self.conformance),
            "attempts": [attempt.to_dict() for attempt in self.attempts],
        }

    def to_json(self) -> str:
        """`to_dict` in one line of JSON; numbers read back to the same float64."""
        return orjson.dumps(self.to_dict()).decode()

    def __str__(self) -> str:
        return summary(self.to_dict() | {"receipt": {"n_points": self.n_points, "unit": self.unit}})

    # What draws and writes files stands above this package: it is asked for by its public name, as users do.

    def export(self, artifacts: Any, **options: Any) -> Any:
        """`primfit.export` of this answer and its points."""
        import primfit

        return primfit.export(self, artifacts, **options)

    def plot(self, axes: "Axes | None" = None) -> "Axes":
        """`primfit.plot`: the points in 3D, colored by their residuals, with the outline of the primitive."""
        import primfit

        return primfit.plot(self, axes)

    def show(self) -> "Plot":
        """`primfit.show`: in a notebook, a 3D picture of the points and the primitive that can be turned."""
        import primfit

        return primfit.show(self)

    def _repr_html_(self) -> str:
        import primfit

        words = f"<pre>{escape(str(self))}</pre>"
        if self.points is None:
            return words
        return f'<div style="max-width: 24rem">{primfit.picture(self)}</div>{words}'

    def __repr__(self) -> str:
        found = (self.primitive, *(other.primitive for other in self.alternatives))
        kinds = " or ".join(each.kind for each in found if each)
        best = "best try " if kinds and self.status == "no_fit" else ""
        said = [self.status, best + kinds, f"{self.n_points} points"]
        return f"<Recognition: {', '.join(filter(None, said))}>"
