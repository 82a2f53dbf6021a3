"""The picture of a fit: small, of all kinds, with outliers told apart by their shape, also without a fit."""

from io import BytesIO
from typing import Any

import numpy as np
import pytest

import primfit
from primfit.app.exports.fitted import fitted_points
from primfit.app.readers.cloud import Array
from tests.paths import ROOT

pytest.importorskip("PIL", reason="needs the extra mcp: pip install 'primfit[mcp]'")
from PIL import Image

from primfit.app.agents import picture as drawing

MOST_BYTES = 60_000
SAMPLES = {
    "plane": ("floor.csv", "m"),
    "cylinder": ("pipe.ply", "mm"),
    "sphere": ("tank-end.xyz", "m"),
    "cone": ("nozzle.pcd", "mm"),
    "torus": ("handwheel.xyz", "mm"),
}


def _drawn(points: Any, **options: Any) -> tuple[primfit.Recognition, Array]:
    """An answer, and the pixels (480, 640, 3) of its picture."""
    found = primfit.fit(points, **options)
    answer = found.to_dict() | {"receipt": {"n_points": found.n_points, "unit": found.unit}}
    content = drawing.picture(fitted_points(found), answer)
    assert len(content) <= MOST_BYTES
    image = Image.open(BytesIO(content))
    assert (image.format, image.size) == ("PNG", (640, 480))
    return found, np.asarray(image.convert("RGB"), np.float64)


def _said(monkeypatch: pytest.MonkeyPatch, points: Any, **options: Any) -> list[str]:
    """All texts of the picture of an answer."""
    texts: list[str] = []
    write = drawing._Sheet.text

    def note(sheet: Any, x: float, y: float, words: str, *how: Any) -> None:
        texts.append(words)
        write(sheet, x, y, words, *how)

    monkeypatch.setattr(drawing._Sheet, "text", note)
    _drawn(points, **options)
    return texts


def _tube(n_points: int, n_outliers: int = 0) -> Array:
    rng = np.random.default_rng(3)
    tube = primfit.Cylinder(axis=np.array([0.0, 0.0, 1.0]), point=np.zeros(3), radius=5.0)
    points = tube.surface(rng.uniform(0, 6.28, n_points), rng.uniform(0, 20, n_points))
    points += rng.normal(0, 0.02, points.shape)
    points[:n_outliers] *= [1.3, 1.3, 1.0]
    return points


@pytest.mark.parametrize("kind", SAMPLES)
def test_each_kind_has_a_title_with_its_size_and_a_legend_in_its_unit(
    kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    file, unit = SAMPLES[kind]
    title, *texts = _said(monkeypatch, ROOT / "samples" / file, unit=unit)
    assert title.startswith(f"{kind.capitalize()}, ") and any(digit in title for digit in "123456789")
    assert "signed distance [mm]" in texts
    assert any(text.startswith("+") for text in texts) and any("the other side" in text for text in texts)


def test_points_and_the_surface_are_seen() -> None:
    _, pixels = _drawn(_tube(2000))
    scene = pixels[80:, :400]
    spread = scene.max(axis=2) - scene.min(axis=2)
    red = (scene[..., 0] > scene[..., 2] + 60).mean()
    blue = (scene[..., 2] > scene[..., 0] + 60).mean()
    surface = ((spread < 30) & (scene.mean(axis=2) > 150) & (scene.mean(axis=2) < 230)).mean()
    assert red > 0.005 and blue > 0.005 and surface > 0.05


def test_outliers_are_rings_and_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    rings: list[Any] = []
    ring = drawing._ring
    monkeypatch.setattr(drawing, "_ring", lambda *how: (rings.append(how), ring(*how)))
    texts = _said(monkeypatch, _tube(2000, 60))
    assert "1,940 inliers" in texts and "60 outliers" in texts
    assert len(rings) == 60 + 1  # and that of the legend


def test_few_outliers_of_many_points_are_all_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    rings: list[Any] = []
    monkeypatch.setattr(drawing, "_ring", lambda *how: rings.append(how))
    texts = _said(monkeypatch, _tube(50_000, 20))
    assert f"{len(rings) - 1} outliers" in texts and len(rings) > 20
    assert any("of the points are drawn" in text for text in texts)


def test_an_ambiguous_answer_says_what_is_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    title = _said(monkeypatch, ROOT / "samples" / "short-arc.csv")[0]
    assert title.startswith("Ambiguous: cylinder or plane. Drawn: cylinder, diameter")


def test_without_a_fit_the_best_try_is_drawn_as_such(monkeypatch: pytest.MonkeyPatch) -> None:
    title = _said(monkeypatch, ROOT / "samples" / "corner.xyz")[0]
    assert title.startswith("No fit. Drawn is the best try: ")


def test_without_any_primitive_the_points_are_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    flat = [[x, y, 0.0] for x in range(9) for y in range(9)]
    texts = _said(monkeypatch, flat, kinds=["torus"])
    assert texts[0] == "No fit, and no kind could be tried"
    assert not any("distance" in text for text in texts)


def test_without_extents_the_points_are_colored(monkeypatch: pytest.MonkeyPatch) -> None:
    assert "signed distance" in _said(monkeypatch, _tube(300), include=())


@pytest.mark.parametrize("factor", [1e-6, 1e6])
def test_any_size_and_place_can_be_drawn(factor: float) -> None:
    _drawn(factor * (_tube(500) + np.array([1000.0, -2000.0, 500.0])))


def test_exact_points_can_be_drawn() -> None:
    rng = np.random.default_rng(0)
    found, _ = _drawn(primfit.Sphere(np.zeros(3), 2.0).surface(*rng.uniform(0, 3, (2, 500))))
    assert found.status == "fitted"
