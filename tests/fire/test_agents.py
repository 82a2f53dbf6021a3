"""What a call of a tool takes beside the fit of a large cloud."""

import pytest

pytest.importorskip("mcp", reason="needs the extra mcp: pip install 'primfit[mcp]'")

from tests.fire.agents import N_POINTS, measure
from tests.fire.report import reported

pytestmark = pytest.mark.fire


def test_a_call_takes_little_beside_the_fit() -> None:
    with reported("agents") as figures:
        figures.note("points", N_POINTS)
        measure(figures)
