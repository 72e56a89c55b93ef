"""The blocks of docs/matlab.md, from top to bottom in one Octave session; `value   % = 1.5` is compared."""

import re
import shutil

import pytest
from spacar_formats.mex import FOLDER

from tests.docs.documents import blocks
from tests.examples import DATA

from .octave import PROGRAM, need, run_octave

PAGE = DATA.parent / "docs" / "matlab.md"
VALUE = re.compile(r"^(\S.*?[^;\s])\s+% = (\S+)$", re.MULTILINE)
CHECK = r"out.values(end + 1) = \1; out.expected(end + 1) = \2;"


@pytest.mark.slow
def test_the_page(tmp_path, monkeypatch):
    """Printed numbers to their last digit."""
    need("octave-cli")
    for name in ("plbeam5", "robotinv", "robotinvlin", "massspring"):
        shutil.copy(DATA / f"{name}.dat", tmp_path)
    text = "\n".join(block.text for block in blocks(PAGE) if block.language == "matlab")
    monkeypatch.setenv("SPACAR_COMMAND", str(PROGRAM))
    script = "out.values = []; out.expected = [];\n" + VALUE.sub(CHECK, text)
    done = run_octave(script, tmp_path, FOLDER)
    assert len(done["values"]) == 10
    assert abs(done["values"] - done["expected"]).max() < 5e-5
