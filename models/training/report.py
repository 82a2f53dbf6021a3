"""Tables and learning curves of the classifiers: what `make training-figures` runs last.

Reads the cards of the shipped weights and what `models.training.pointnet` printed, and writes
docs/training-figures.md and docs/images/learning_curves.png. Needs matplotlib for the picture.
"""

import argparse
import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from ..weights import DIRECTORY
from .dataset import FAMILIES

Scores = Mapping[str, Any]
"""By family, as `models.training.metrics.metrics` returns them."""

HEAD = """# Figures of the classifiers

<!-- Written by `python -m primfit.models.training.report`; change that file, not this one. -->

Measured on held-back seeds; those of network and k-NN stand in the cards beside their weights, too.
[training.md](training.md) says what they mean.
"""


def percent(share: float | None) -> str:
    return "" if share is None else f"{100 * share:.1f}%"


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(cells) + " |" for cells in lines) + "\n"


def columns(methods: Mapping[str, Scores], families: Sequence[str] = FAMILIES) -> list[tuple[str, Scores]]:
    return [
        (f"{name}, {family}", scores[family])
        for name, scores in methods.items()
        for family in families
        if family in scores
    ]


def overview(methods: Mapping[str, Scores]) -> str:
    named = columns(methods)
    measures = {
        "top-1": "top1",
        "truth in top-2": "top2",
        "expected calibration error": "calibration_error",
        "the same before scaling": "calibration_error_before",
    }
    rows = [
        [title, *(percent(scores.get(measure)) for _, scores in named)] for title, measure in measures.items()
    ]
    return table(["", *(name for name, _ in named)], rows)


def broken_down(methods: Mapping[str, Scores], by: str, families: Sequence[str] = FAMILIES) -> str:
    named = columns(methods, families)
    groups = list(dict.fromkeys(group for _, scores in named for group in scores[f"top1_by_{by}"]))
    rows = [
        [group, *(percent(scores[f"top1_by_{by}"].get(group)) for _, scores in named)] for group in groups
    ]
    return table(["", *(name for name, _ in named)], rows)


def draw(curves: Mapping[str, Sequence[Mapping[str, float]]], file: Path) -> None:
    """Loss and accuracy by epoch, a color a design."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, (left, right) = pyplot.subplots(1, 2, figsize=(10, 3.6), layout="constrained")
    for index, (name, rows) in enumerate(curves.items()):
        epochs, color = [row["epoch"] for row in rows], f"C{index}"
        left.plot(epochs, [row["loss"] for row in rows], "--", color=color, label=f"{name}, training")
        left.plot(epochs, [row["validation_loss"] for row in rows], color=color, label=f"{name}, validation")
        right.plot(epochs, [100 * row["validation_top1"] for row in rows], color=color, label=name)
    left.set(xlabel="epoch", ylabel="cross-entropy", yscale="log")
    right.set(xlabel="epoch", ylabel="top-1 on validation clouds [%]")
    left.legend(frameon=False)
    right.legend(frameon=False)
    figure.savefig(file, dpi=110)


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--pointnet", type=Path, required=True, help="what models.training.pointnet printed")
    parser.add_argument("--curves", type=Path, nargs=2, required=True, help="of network and PointNet")
    parser.add_argument("--out", type=Path, default=Path("docs"))
    given = parser.parse_args(arguments)
    methods: dict[str, Scores] = {
        name: json.loads((DIRECTORY / f"{name}.json").read_text(encoding="utf-8"))["metrics"]
        for name in ("network", "knn")
    }
    methods["pointnet"] = json.loads(given.pointnet.read_text(encoding="utf-8"))
    text = [
        HEAD,
        overview(methods),
        "Top-1 by kind:\n",
        broken_down(methods, "kind"),
        "Top-1 by perturbation:\n",
        broken_down(methods, "perturbation", ("benchmark",)),
        "Top-1 by sensor:\n",
        broken_down(methods, "sensor", ("sensor",)),
        "Top-1 by number of points:\n",
        broken_down(methods, "size"),
    ]
    (given.out / "training-figures.md").write_text("\n".join(text), encoding="utf-8")
    curves = {
        name: json.loads(file.read_text(encoding="utf-8"))
        for name, file in zip(("MLP", "PointNet"), given.curves, strict=True)
    }
    draw(curves, given.out / "images" / "learning_curves.png")


if __name__ == "__main__":
    main()
