"""The shipped notebook, executed from its first cell to its last."""

from pathlib import Path

import pytest


def test_the_notebook_runs(corpus: Path) -> None:
    nbclient = pytest.importorskip("nbclient", reason="Jupyter is not installed")
    pytest.importorskip("ipykernel", reason="Jupyter is not installed")
    pytest.importorskip("matplotlib", reason="matplotlib is not installed")
    pytest.importorskip("pandas", reason="pandas is not installed")
    nbformat = pytest.importorskip("nbformat")
    path = corpus / "python" / "deck_to_diagnosis.ipynb"
    notebook = nbformat.read(path, as_version=4)
    nbclient.NotebookClient(notebook, timeout=1200, resources={"metadata": {"path": str(path.parent)}}).execute()
    outputs = [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]
    texts = [output.text for output in outputs if output.output_type == "stream"]
    assert any("dry-friction" in text for text in texts), "the planted cause is told"
    assert any("friction" in text and "probab" in text.lower() for text in texts), texts
    kinds = [kind for output in outputs for kind in output.get("data", {})]
    assert kinds.count("image/png") >= 4, "a picture for each plot"
    assert any("srcdoc" in output.get("data", {}).get("text/html", "") for output in outputs), "the mechanism is shown"
