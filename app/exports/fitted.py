"""What artifacts are made of: an answer, and the cloud and the options that it came from."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from inspect import signature
from typing import Any

import numpy as np

from primfit.fitting.answer.form import Form, form_of
from primfit.fitting.answer.residuals import Residuals
from primfit.fitting.answer.result import Alternative, Recognition, Source
from primfit.fitting.cloud.cloud import check_coordinates, check_points
from primfit.fitting.errors import InvalidOptionError
from primfit.fitting.extents.values import Extents
from primfit.fitting.names import Unit
from primfit.fitting.primitives import parameters
from primfit.fitting.primitives.primitive import Primitive

from ..engine.arrays import FORMAT, as_cloud, as_floats
from ..engine.fit import config_of
from ..readers import without_missing
from ..readers.cloud import PER_POINT, Array, Cloud
from ..readers.columns import XYZ
from .drawing import Shape, shape_of

OPTIONS = tuple(signature(config_of).parameters)
ROUNDINGS = 16
"""Roundings of a coordinate that a distance may hold."""

COUNTS = ("weights", "standard_deviations")
_ARRAY = Source(None, FORMAT, XYZ.names)


class NothingToExportError(ValueError):
    """There is no primitive, or no extents to trim it to.

    Examples
    --------
    >>> import primfit
    >>> flat = [[x, y, 0.0] for x in range(9) for y in range(9)]
    >>> try:
    ...     primfit.export(primfit.fit(flat, kinds=["torus"]), "step", unit="mm")
    ... except primfit.NothingToExportError:
    ...     print("no torus was found")
    no torus was found
    """


@dataclass(frozen=True, eq=False)
class Fitted:
    """A recognition with what it was made from.

    Attributes
    ----------
    cloud : that was fitted; artifacts of points need it
    options : keyword options that `engine.fit` had, or None where they are not known
    name : of the file that the cloud was read from, without folders; None where it had none
    """

    recognition: Recognition
    cloud: Cloud | None = None
    options: Mapping[str, Any] | None = None
    name: str | None = None

    @property
    def primitive(self) -> Primitive:
        """The first of an ambiguous answer, the best try of `no_fit`.

        Raises `NothingToExportError` where there is none.
        """
        found = self.recognition
        if found.primitive is None:
            raise NothingToExportError(f"the answer is {found.status} and holds no primitive to export")
        return found.primitive

    @property
    def extents(self) -> Extents:
        """Of the primitive.

        Raises `NothingToExportError` where its points span no surface, `InvalidOptionError` where the extents
        were not asked for.
        """
        check_extents(self.recognition.include)
        kind, extents = self.primitive.kind, self.recognition.extents
        if extents is None:
            raise NothingToExportError(f"the {kind} cannot be trimmed: it has no extents")
        return extents

    @cached_property
    def shape(self) -> Shape:
        """The primitive within its extents; raises `NothingToExportError` where there is nothing to trim."""
        return shape_of(self.primitive, self.extents)

    @property
    def given(self) -> Cloud:
        """The cloud; raises `InvalidOptionError` where there is none."""
        if self.cloud is None:
            raise InvalidOptionError(
                "points are missing: this artifact is about them. An answer leaves its points behind when it "
                "is pickled; with_points gives them again",
                "points",
            )
        return self.cloud

    @property
    def points(self) -> Array:
        """All points (N, 3) in the order of the input."""
        return self.given.points

    @cached_property
    def size(self) -> float:
        """Diagonal of the bounding box of the inliers, of all points where none fits."""
        points = self.points
        if self.recognition.status != "no_fit" and self.residuals.inlier.any():
            points = points[self.residuals.inlier]
        return float(np.linalg.norm(np.ptp(points, axis=0)))

    @cached_property
    def rounding(self) -> float:
        """What distances from a surface may be by the rounding of float64 alone."""
        return ROUNDINGS * float(np.finfo(np.float64).eps) * float(np.abs(self.points).max())

    @cached_property
    def residuals(self) -> Residuals:
        """Of all points."""
        points, rule = self.points, self.recognition.inlier_rule
        distance = self.primitive.signed_distance(points)
        assert rule
        return Residuals(distance, rule.among(points))

    @cached_property
    def form(self) -> Form:
        """Of the inliers."""
        return form_of(self.primitive, self.points[self.residuals.inlier])


def of_kind(fitted: Fitted, kind: str | None) -> Fitted:
    """With the primitive of this kind out of those of the answer; None leaves the first.

    Raises `NothingToExportError` where there is none of the kind.
    """
    found = fitted.recognition
    if kind is None or (found.primitive and found.primitive.kind == kind):
        return fitted
    chosen = next((other for other in found.alternatives if other.primitive.kind == kind), None)
    if chosen is None:
        kinds = [each.kind for each in (found.primitive, *(o.primitive for o in found.alternatives)) if each]
        raise NothingToExportError(f"the answer holds no {kind}; it holds {' and '.join(kinds) or 'nothing'}")
    assert found.inlier_rule and found.primitive and found.error
    tried = {attempt.kind: attempt for attempt in found.attempts}
    evidence = tried[found.primitive.kind].evidence
    first = Alternative(
        found.primitive, found.error, found.extents, found.uncertainty, evidence, found.active_constraints
    )
    recognition = replace(
        found,
        primitive=chosen.primitive,
        error=chosen.error,
        extents=chosen.extents,
        uncertainty=chosen.uncertainty,
        noise=tried[kind].noise,
        inlier_rule=replace(found.inlier_rule, surface=chosen.primitive),
        alternatives=(first, *(other for other in found.alternatives if other is not chosen)),
        active_constraints=chosen.active_constraints,
    )
    return replace(fitted, recognition=recognition)


def check_extents(include: Collection[str]) -> None:
    """Raise `InvalidOptionError` where the answer was or will be without extents."""
    if "extents" not in include:
        found = ", ".join(include) or "nothing"
        raise InvalidOptionError(
            f"include names {found}; STEP files and meshes need extents, where the primitive ends", "include"
        )


def fitted_points(
    recognition: Recognition, points: Any = None, options: Mapping[str, Any] | None = None
) -> Fitted:
    """An answer with points from Python, and the keyword arguments that `fit` had beside them.

    Without points those that the answer has kept count. Missing ones do not.

    Raises `InvalidPointCloudError` and `InvalidOptionError` for what `fit` would not have taken.
    """
    coordinates = recognition.points if points is None else as_cloud(points).points
    if coordinates is None:
        return Fitted(recognition)
    source = (recognition.source if points is None else None) or _ARRAY
    if options is None:
        return Fitted(recognition, _cloud_in(recognition.unit, coordinates, source), None, source.name)
    for name in options:
        if name not in OPTIONS and name not in PER_POINT:
            raise InvalidOptionError(
                f"options holds {name!r:.40}; allowed are {', '.join(OPTIONS)}", "options"
            )
    arrays = {name: as_floats(options[name], name) for name in COUNTS if options.get(name) is not None}
    cloud = _cloud_in(recognition.unit, coordinates, source, **arrays)
    return Fitted(recognition, cloud, _used(options), source.name)


def _cloud_in(unit: Unit | None, points: Array, source: Source, **beside: Any) -> Cloud:
    """The points as they were fitted: checked, without those that are missing, in their unit."""
    cloud = without_missing(replace(_cloud_of(points, source, **beside), unit=unit))
    check_points(cloud.points)
    return cloud


def _used(options: Mapping[str, Any]) -> dict[str, Any]:
    """Those that are not about single points, checked, in plain values."""
    used = {name: value for name, value in options.items() if name not in PER_POINT}
    guess = config_of(**used).initial_guess
    return used if guess is None else used | {"initial_guess": parameters(guess)}


def _cloud_of(points: Array, source: Source = _ARRAY, **beside: Any) -> Cloud:
    return Cloud(points, source.columns, None, source.format, **beside)


def residuals(recognition: Recognition, points: Any = None) -> Residuals:
    """Signed distances of points from the answered primitive, and which of them belong to it.

    Parameters
    ----------
    recognition : what `fit` found; of an ambiguous answer the first primitive counts
    points : (N, 3) in the unit that was fitted, the same ones or others, and however few;
        an array or another object that `fit` takes. None for those that were fitted, where the answer still
        has them

    Raises
    ------
    NothingToExportError
        The answer holds no primitive.
    InvalidPointCloudError
        The points are not finite (N, 3), or the answer has left its own behind.

    Examples
    --------
    >>> import numpy as np, primfit
    >>> azimuth, polar = np.random.default_rng(0).random((2, 300)) * np.array([[6.0], [3.0]])
    >>> recognition = primfit.fit(primfit.Sphere([0, 0, 0], 2.0).surface(azimuth, polar))
    >>> primfit.residuals(recognition, [[2.25, 0, 0], [0, 1.5, 0]]).distance.round(9)
    array([ 0.25, -0.5 ])
    """
    given = recognition.kept_points() if points is None else check_coordinates(as_cloud(points).points)
    return Fitted(recognition, _cloud_of(given)).residuals


def form_errors(recognition: Recognition, points: Any = None) -> Form:
    """Form errors of the points that belong to the answered primitive; parameters as in `residuals`.

    Examples
    --------
    >>> import numpy as np, primfit
    >>> x, y = np.random.default_rng(0).random((2, 300))
    >>> recognition = primfit.fit(np.stack([x, y, 1e-3 * np.sin(9.0 * x)], axis=1), tolerance=0.01)
    >>> form = primfit.form_errors(recognition)
    >>> form.name, round(form.minimum_zone.form_error, 4)
    ('flatness', 0.002)
    """
    return fitted_points(recognition, points).form
