"""Where things stand: the one place that counts folders upwards."""

from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
"""The checkout."""
EXAMPLES = ROOT / "app" / "examples"
DOCS = ROOT / "docs"
SHARED = ROOT.parent / "shared"
"""Data beside the checkout that no clone has; tests that need it skip themselves where it is missing."""
