"""The methods that are measured: one small file each, one protocol, one dict.

A method is imported and constructed in the child process of `benchmark.runner` alone, once, so that its
package need not be installed where the benchmark is started, and a crash of it ends nothing else.
"""

from dataclasses import dataclass
from importlib import import_module
from typing import Literal, Protocol

from primfit.fitting.geometry.vectors import Array
from primfit.fitting.primitives.primitive import Primitive

Status = Literal["fitted", "ambiguous", "no_fit"]


@dataclass(frozen=True)
class Answer:
    """What a method says of a cloud.

    Attributes
    ----------
    status : `fitted`; `ambiguous` where several kinds explain the cloud; `no_fit` where none does. Methods
        that know only the first answer `fitted`, or `no_fit` where they found nothing
    primitive : the answer in the units of the input; None where there is none
    note : what the record keeps besides; may be empty
    attempts : the kinds that were fitted, in order, where the method tells
    alternatives : the other kinds that an `ambiguous` answer names, the likeliest first
    normals_seconds : of the processor, that normals took which the method cannot do without
    """

    status: Status
    primitive: Primitive | None
    note: str = ""
    attempts: tuple[str, ...] = ()
    alternatives: tuple[str, ...] = ()
    normals_seconds: float = 0.0


class Method(Protocol):
    """A way to get from points to a primitive, constructed without arguments.

    Attributes
    ----------
    name : as in `METHODS` and in the report
    package : the distribution whose version is recorded
    decides_kind : whether it finds the kind; where not, the true kind is given to `fit`
    kinds : the kinds that it can answer; a method that is given the kind is not asked for any other
    settings : one sentence for the report: the settings used and how they scale with the cloud
    """

    name: str
    package: str
    decides_kind: bool
    kinds: tuple[str, ...]
    settings: str

    def fit(self, points: Array, kind: str | None) -> Answer:
        """The answer for one cloud.

        Parameters
        ----------
        points : (N, 3) float64, C order, any unit; not to be written to
        kind : the true kind where `decides_kind` is False, else None

        Raises
        ------
        Exception : whatever the package raises is recorded as an error of the method on this cloud
        """
        ...


METHODS: dict[str, str] = {
    "primfit": "primfit.benchmark.methods.primfit:Primfit",
    "primfit-knn": "primfit.benchmark.methods.primfit:PrimfitKnn",
    "primfit-none": "primfit.benchmark.methods.primfit:PrimfitNone",
    "primfit-reversed": "primfit.benchmark.methods.primfit:PrimfitReversed",
    "engeom": "primfit.benchmark.methods.engeom:Engeom",
    "mesh2cad": "primfit.benchmark.methods.mesh2cad:Mesh2cad",
    "cgal": "primfit.benchmark.methods.cgal:Cgal",
    "pyransac3d": "primfit.benchmark.methods.pyransac3d:Pyransac3d",
    "scikit-spatial": "primfit.benchmark.methods.scikit_spatial:ScikitSpatial",
    "open3d": "primfit.benchmark.methods.open3d:Open3d",
    "trimesh": "primfit.benchmark.methods.trimesh:Trimesh",
    "m1": "primfit.benchmark.methods.paper:M1",
    "m2": "primfit.benchmark.methods.paper:M2",
    "m3": "primfit.benchmark.methods.paper:M3",
    "m4": "primfit.benchmark.methods.paper:M4",
    "m5": "primfit.benchmark.methods.paper:M5",
    "m6": "primfit.benchmark.methods.paper:M6",
}
"""Name -> "module:Class", imported by `load` alone. The first is primfit as it is shipped."""

PAPER = ("m1", "m2", "m3", "m4", "m5", "m6")
"""The methods of the benchmark's paper, made again ..."""
NETWORKS = PAPER[2:]
"""... and those of them that need torch: the extra `train`, which `make .venv-torch/.torch` installs."""

PUBLISHED = tuple(f"{name}-published" for name in PAPER)
"""The answers of the authors of these methods, where they stand beside clouds of the track; never asked."""

PEERS = tuple(name for name in METHODS if name.split("-")[0] != "primfit" and name not in PAPER)
"""What others make; their packages are installed by `make bench-peers`, from `benchmark/peers.txt`."""


def load(name: str) -> Method:
    """The method of that name, constructed.

    Raises
    ------
    ImportError : its package is not installed
    """
    module, _, attribute = METHODS[name].partition(":")
    method: Method = getattr(import_module(module), attribute)()
    return method
