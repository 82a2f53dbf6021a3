"""The sixteen networks, in the order in which they are trained, and with what."""

from dataclasses import asdict, dataclass
from typing import Any

from primfit.models.rough import KINDS

from ..parts.numbers import ROW
from ..parts.pointnet import Widths


@dataclass(frozen=True)
class Stage:
    """A network and its training.

    Attributes
    ----------
    name : of its weights: the method, and the kind that it regresses, or "kind" where it classifies
    network : what `parts.stored.built` builds it from
    epochs : of `learning.EPOCH` clouds each, or of all clouds of its kind if these are fewer
    kind : whose numbers it regresses; None for a classifier
    points : of each cloud that it sees at a time
    turned : the axes that clouds are turned about at random
    shifted : whether some points are moved, as M5 does it
    rate : the largest learning rate, of Adam
    batch : clouds of a step
    seed : added to that of the command
    """

    name: str
    network: dict[str, Any]
    epochs: int
    kind: str | None = None
    points: int = 512
    turned: str = ""
    shifted: bool = False
    rate: float = 2e-3
    batch: int = 16
    seed: int = 0

    @property
    def method(self) -> str:
        """ "m3" to "m6"."""
        return self.name.partition("-")[0]

    @property
    def recipe(self) -> dict[str, Any]:
        """What the card says of it, beside the name and the seed."""
        return {name: value for name, value in asdict(self).items() if name not in ("name", "seed")}


def pointnet(outputs: int, dropout: float, **widths: tuple[int, ...]) -> dict[str, Any]:
    """A PointNet of these widths and else of those by default."""
    return {
        "design": "pointnet",
        "outputs": outputs,
        "dropout": dropout,
        "widths": {name: list(sizes) for name, sizes in asdict(Widths(**widths)).items()},
    }


def voxels(outputs: int, dropout: float) -> dict[str, Any]:
    """M4's network."""
    return {"design": "voxels", "outputs": outputs, "dropout": dropout}


def views(outputs: int, dropout: float) -> dict[str, Any]:
    """M6's network."""
    return {"design": "views", "outputs": outputs, "dropout": dropout}


def classifiers() -> list[Stage]:
    """One each of M3, M4 and M6, three of M5."""
    return [
        Stage("m4-kind", voxels(len(KINDS), 0.2), epochs=70, points=1024, turned="xyz"),
        Stage("m3-kind", pointnet(len(KINDS), 0.3), epochs=120, points=256, batch=32),
        *(
            Stage(
                f"m5-{number}",
                pointnet(len(KINDS), 0.3, **widths),
                epochs=40,
                turned="z",
                shifted=True,
                seed=number,
            )
            for number, widths in enumerate(BUNDLE, 1)
        ),
        Stage("m6-kind", views(len(KINDS), 0.5), epochs=60, points=2048, batch=32),
    ]


BUNDLE: tuple[dict[str, tuple[int, ...]], ...] = (
    {},
    {"first": (32, 32), "second": (32, 96, 512)},
    {"first": (64, 64), "second": (64, 128, 256)},
)
"""Widths of M5's three networks."""


HARD = {"m4-cone": 40, "m4-torus": 40}
"""Epochs of those from which least squares most often does not find the surface: they learn longer."""


def regressors() -> list[Stage]:
    """Five each of M4 and M3."""
    return [
        Stage(
            f"{method}-{kind}",
            voxels(ROW, 0.0) if method == "m4" else pointnet(ROW, 0.0),
            epochs=HARD.get(f"{method}-{kind}", 16),
            kind=kind,
            points=1024 if method == "m4" else 512,
            turned="xyz" if method == "m4" else "",
        )
        for method in ("m4", "m3")
        for kind in KINDS
    ]


def stages() -> list[Stage]:
    """All of them."""
    return classifiers() + regressors()
