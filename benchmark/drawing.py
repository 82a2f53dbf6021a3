"""How fast clouds are drawn: those of each recipe in a minute of one core."""

import time
from dataclasses import dataclass, replace
from itertools import count

from primfit.synthetic import RECIPES, cloud

BARS = {"benchmark": 2000, "scanner": 1000}
"""Clouds a minute that drawing in training and in the benchmark rests on."""


@dataclass(frozen=True)
class Rate:
    """What was drawn of a recipe in so many seconds of the processor."""

    recipe: str
    clouds: int
    points: int
    seconds: float

    @property
    def a_minute(self) -> float:
        return 60.0 * self.clouds / self.seconds


def rate(recipe: str, seed: int, seconds: float) -> Rate:
    """Draw clouds until they have taken so long; the first, which finds nothing warm, does not count."""
    drawn = replace(RECIPES[recipe], seed=seed)
    cloud(drawn, 0)
    n_points, started = 0, time.process_time()
    for n_clouds in count(1):
        n_points += len(cloud(drawn, n_clouds).points)
        taken = time.process_time() - started
        if taken >= seconds:
            break
    return Rate(recipe, n_clouds, n_points, taken)


def table(rates: list[Rate]) -> str:
    """The rates as a table of Markdown, with the bar of those that have one."""
    lines = ["| recipe | clouds a minute | points a cloud | bar |", "|---|---|---|---|"]
    for each in rates:
        bar = BARS.get(each.recipe)
        held = "" if bar is None else f"{bar:,}: {'met' if each.a_minute >= bar else 'missed'}"
        lines.append(
            f"| `{each.recipe}` | {each.a_minute:,.0f} | {each.points / each.clouds:,.0f} | {held} |"
        )
    return "\n".join(lines)
