"""The segments of a cloud, each of them fitted, in Python."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from primfit.fitting.answer.result import Recognition
from primfit.fitting.equality import ByValue
from primfit.fitting.errors import InvalidOptionError, InvalidPointCloudError

from ..readers.cloud import PER_POINT
from .answer import to_json
from .arrays import as_array, as_floats
from .cut import Label, Piece, Rows, cut, pieces
from .executors import Executor, check_executor, team_of
from .fit import cloud_of, config_of, fit_cloud
from .team import chunks

if TYPE_CHECKING:
    from k3d.plot import Plot


@dataclass(frozen=True, eq=False)
class Segment(ByValue):
    """A segment that was fitted: its label, its rows in the cloud, and the `recognition`.

    Where it could not be fitted `recognition` is None and `problem` says why; it is empty otherwise.

    Examples
    --------
    >>> import primfit
    >>> primfit.fit_segments([[0, 0, 0], [1, 0, 0]], ["stray", "stray"])[0].problem
    '2 points given; at least 3 are needed'
    """

    label: Label
    rows: Rows
    recognition: Recognition | None
    problem: str = ""

    def to_dict(self) -> dict[str, Any]:
        """Plain values, the recognition as in `Recognition.to_dict`."""
        return {
            "label": self.label,
            "rows": self.rows.tolist(),
            "recognition": self.recognition and self.recognition.to_dict(),
            "problem": self.problem,
        }

    def to_json(self) -> str:
        """`to_dict` in one line of JSON."""
        return to_json(self.to_dict()).decode()

    def __str__(self) -> str:
        return f"segment {self.label}, {len(self.rows)} points: {self.recognition or self.problem}"

    def __repr__(self) -> str:
        return f"<Segment {self.label!r}, {len(self.rows)} points: {(self.recognition or self.problem)!r}>"


class Segments(list[Segment]):
    """The segments of a cloud: a list that exports as one file, and shows itself as one picture.

    Examples
    --------
    >>> import numpy as np, primfit
    >>> azimuth, polar = np.random.default_rng(0).random((2, 300)) * np.array([[6.0], [3.0]])
    >>> points = primfit.Sphere([0, 0, 0], 2.0).surface(azimuth, polar)
    >>> segments = primfit.fit_segments(np.vstack([points, points + 9.0]), [7] * 300 + [8] * 300)
    >>> len(segments), segments[0].label
    (2, 7)
    >>> segments.export("csv").count(b"fitted")
    2
    """

    def export(self, artifact: str, **options: Any) -> bytes:
        """`primfit.export_segments` of all of them: `step`, `glb`, `csv` or `report`."""
        import primfit  # what writes files stands above this package

        return primfit.export_segments(self, artifact, **options)

    def show(self) -> "Plot":
        """`primfit.show_segments`: in a notebook, a 3D picture of all of them that can be turned."""
        import primfit

        return primfit.show_segments(self)


def fit_segments(
    points: Any,
    labels: ArrayLike | None = None,
    *,
    workers: int | None = None,
    executor: Executor = "local",
    address: str | None = None,
    **options: Any,
) -> Segments:
    """`fit` each segment of a cloud: the points of one label.

    Parameters
    ----------
    points : (N, 3), any unit of length: whatever `fit` takes
    labels : (N,) whole numbers or strings; None for those that `read` found
    workers : processes that share the segments; any number of them gives the same answers. None for this one
        alone, or for all processors of a cluster
    executor : `local`: processes of this machine; `ray`: those of a Ray cluster, which gives the same answers
        and needs `pip install "primfit[ray]"`
    address : of the cluster, as `ray.init` takes it; None for one that is found, or else started
    options : those of `fit`; `normals`, `weights` and `standard_deviations` have a value for each point

    Returns
    -------
    The segments by label, in ascending order, as a list that exports as one file. One that cannot be fitted,
    with two points, say, has a `problem` and no `recognition`; it does not keep the others from theirs.

    Raises
    ------
    InvalidPointCloudError
        There are not as many labels, normals or weights as points, or labels are neither whole numbers nor
        strings.
    InvalidOptionError
        An option is unknown or out of range.
    RuntimeError
        A process was ended from outside, as for want of memory; or there is no such cluster.
    ImportError
        Ray is not installed.

    Examples
    --------
    >>> import numpy as np, primfit
    >>> azimuth, polar = np.random.default_rng(0).random((2, 300)) * np.array([[6.0], [3.0]])
    >>> points = primfit.Sphere([0, 0, 0], 2.0).surface(azimuth, polar)
    >>> for segment in primfit.fit_segments(np.vstack([points, points + 9.0]), [7] * 300 + [8] * 300):
    ...     print(segment.label, segment.recognition.primitive.kind)
    7 sphere
    8 sphere
    """
    if workers is not None and workers < 1:
        raise InvalidOptionError("workers must be at least 1", "workers")
    check_executor(executor, address)
    given = {name: options.pop(name, None) for name in PER_POINT[1:]}
    config_of(**options)
    arrays: dict[str, Any] = {
        name: as_floats(values, name) for name, values in given.items() if values is not None
    }
    cloud = replace(cloud_of(points, options.get("columns")), **arrays)
    if labels is not None:
        cloud = replace(cloud, labels=as_array(labels))
    if cloud.labels is None:
        raise InvalidPointCloudError("labels are missing; give them, or read a file with labels", "labels")
    whole = cut(cloud)
    sizes = [stop - start for start, stop in pairwise(whole.bounds)]
    with team_of(executor, workers, address, most=len(sizes)) as team:
        work, shares = partial(_fitted, options), chunks(pieces(whole, team.scratch()), sizes, team.size)
        found = list(team.in_order(team.submit(work, share) for share in shares))
    # Each segment keeps a view of its points, which no process has to send back.
    ordered = cloud.points[whole.rows]
    bounds = pairwise(whole.bounds)
    return Segments(
        Segment(
            label,
            whole.rows[start:stop],
            recognition and recognition.with_points(ordered[start:stop]),
            problem,
        )
        for label, (start, stop), (recognition, problem) in zip(whole.labels, bounds, found, strict=True)
    )


def _fitted(options: Mapping[str, Any], piece: Piece) -> tuple[Recognition | None, str]:
    try:
        return fit_cloud(piece(), options), ""
    except (InvalidPointCloudError, InvalidOptionError) as error:
        return None, str(error)
