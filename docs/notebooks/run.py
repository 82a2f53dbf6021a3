"""Run the notebooks beside this file, and write what they print into them: `make notebooks`.

Only printed text is kept, so that a notebook can be read without running it, and a difference shows what has
changed. Widgets and pictures are large and differ from run to run; a notebook that is run draws them anew.
"""

from pathlib import Path
from typing import Any

import nbformat
from nbclient import NotebookClient

NOTEBOOKS = sorted(Path(__file__).parent.glob("*.ipynb"))

PATIENCE = 60
"""How long a cell may take [s]: a second is usual, and a busy machine is slower."""


def run(path: Path, *code: str) -> Any:
    """The notebook with all outputs, those of more cells with this code at the end included.

    Raises `nbclient.exceptions.CellExecutionError` where a cell raises.
    """
    notebook: Any = nbformat.read(path, as_version=4)
    notebook.cells += [nbformat.v4.new_code_cell(each) for each in code]
    # Paths in a notebook are relative to its folder, as in Jupyter.
    where = {"metadata": {"path": str(path.parent)}}
    NotebookClient(
        notebook,
        timeout=PATIENCE,
        kernel_name="python3",
        resources=where,
        record_timing=False,
        coalesce_streams=True,
    ).execute()
    return notebook


def printed(notebook: Any) -> list[str]:
    """What each code cell prints."""
    cells = (cell for cell in notebook.cells if cell.cell_type == "code")
    return ["".join(out.text for out in cell.outputs if out.output_type == "stream") for cell in cells]


def refresh(path: Path) -> None:
    """Run a notebook, and write it again with what it prints."""
    notebook: Any = nbformat.read(path, as_version=4)
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    for cell, text in zip(code, printed(run(path)), strict=True):
        cell.execution_count = None
        cell.outputs = [nbformat.v4.new_output("stream", text=text)] if text else []
    nbformat.write(notebook, path)


if __name__ == "__main__":
    for path in NOTEBOOKS:
        refresh(path)
