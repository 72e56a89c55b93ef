"""A warning where a result depends on which part of a divided beam keeps its release."""

import pytest

import spacar

TEXT = """X 1 0 0   X 3 1 0.2   FIX 1   FIX 2   DYNX 3   DYNX 4   PLBEAM 1 1 2 3 4   RLSE 1   END HALT
ESTIFF 1 90. 2.   EM 1 0.5 0.01   XM 3 1.   XF 3 0.2 0.3   {more}
TIMESTEP 0.01 2   ITERSTEP 20 2 1e-9   END END
"""


@pytest.mark.parametrize(
    ("mode", "elements", "more", "said"),
    [(1, 2, "STARTDX 3 1 1.01", True), (1, 2, "", False), (1, 1, "STARTDX 3 1 1.01", False),
     (7, 2, "STARTDX 3 1 1.01", False)],
)  # fmt: skip
def test_it_is_said_where_it_matters(mode: int, elements: int, more: str, said: bool) -> None:
    """A displaced start, of a motion, of divided beams."""
    r = spacar.run(mode, spacar.parse_deck(TEXT.format(more=more), mode=mode), elements=elements)
    assert any("lies in its last part (element 2)" in line for line in r.report) == said
