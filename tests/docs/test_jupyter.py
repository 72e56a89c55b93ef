"""A notebook in a real kernel, with nothing but `import spacar`: figures, tables and an animation show themselves."""

import os
import sys

import pytest

from tests.examples import DATA

nbformat = pytest.importorskip("nbformat")
execute = pytest.importorskip("nbconvert.preprocessors")
pytest.importorskip("ipykernel")
pytestmark = pytest.mark.slow

CRANK, FLEXIBLE = str(DATA / "crank.dat"), str(DATA / "crankfl.dat")
CELLS = (
    "import spacar",
    f"result = spacar.run(1, {CRANK!r})\nresult",
    "result.draw(strobe=5)",
    "result.plot('x[6,1]', 'sig[1,1]')",
    "result.animate(frames=4, dpi=40)",
    f"rows = spacar.sweep({FLEXIBLE!r}, {{'XM.8': [0.03, 0.06]}}, 'slider: x[8,1]@end', duration=0.01, jobs=1)\nrows",
    "rows.to_pandas()",
)


def test_what_is_asked_for_is_shown(tmp_path):
    book = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(text) for text in CELLS])
    os.environ.pop("MPLBACKEND", None)
    from jupyter_client.kernelspec import KernelSpec
    from jupyter_client.manager import AsyncKernelManager

    manager = AsyncKernelManager()
    manager._kernel_spec = KernelSpec(argv=[sys.executable, "-m", "ipykernel_launcher", "-f", "{connection_file}"])
    execute.ExecutePreprocessor(timeout=120).preprocess(book, {"metadata": {"path": str(tmp_path)}}, km=manager)
    shown = [{kind for output in cell.outputs for kind in output.get("data", ())} for cell in book.cells]
    texts = ["".join(str(output.get("data", {})) for output in cell.outputs) for cell in book.cells]
    assert not shown[0]
    assert "text/plain" in shown[1]
    pictures = zip(shown[2:4], texts[2:4], strict=True)
    assert all("image/png" in kinds or "data:image/png" in text for kinds, text in pictures)
    assert "image/gif" in shown[4] or "data:image/gif" in texts[4] or "text/html" in shown[4]
    assert "text/plain" in shown[5]
    assert "<table" in texts[6]
