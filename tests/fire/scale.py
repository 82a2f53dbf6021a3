"""How long the tests of this folder go on: as their bars say, or a share of it to try them out."""

import os

SCALE = float(os.environ.get("FIRE_SCALE", "1"))


def scaled(amount: float) -> float:
    """Seconds or requests: `FIRE_SCALE=0.1 make test-fire` takes a tenth of them."""
    return amount * SCALE
