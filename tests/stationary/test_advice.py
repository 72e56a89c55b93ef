"""Advice in messages of statics helps when it is tried: what stands there is done to the smallest model."""

from collections.abc import Callable

import pytest

import spacar
from spacar.errors import AnalysisError

from .test_far_starts import STRING

TOGGLE = """
PLTRUSS 1 1 2   PLTRUSS 2 2 3   X 2 1 0.5   X 3 2 0   FIX 1   FIX 3   DYNX 2 1 2   RLSE 1   RLSE 2
END HALT
ESTIFF 1 1   ESTIFF 2 1   XM 2 1   XF 2 0 -0.1   ITERSTEP 20 4 1e-9   END END
"""
BAR = "PLTRUSS 1 1 2\nX 2 1 0\nFIX 1\nDYNX 2\nRLSE 1\nEND HALT\nXM 2 1\nESTIFF 1 1\nXF 2 0 1\nEND END\n"
HASTY = STRING.format(preload=0.01, force=0.02).replace("END END", "ITERSTEP 1 1\nEND END")


def swapped(text: str, *pairs: tuple[str, str]) -> str:
    for old, new in pairs:
        assert old in text
        text = text.replace(old, new)
    return text


def arch(elements: int) -> str:
    """A cantilever, length and EI of one, under a moment of 2.5 at its end."""
    lines = ["FIX 1", "FIX 2"]
    for k in range(elements):
        a = 2 * k + 1
        lines += [f"PLBEAM {k + 1} {a} {a + 1} {a + 2} {a + 3}", f"X {a + 2} {(k + 1) / elements} 0"]
        lines += [f"DYNE {k + 1} 2 3"]
    lines += ["END HALT", *(f"EM {k + 1} 1 0.01\nESTIFF {k + 1} 0 1" for k in range(elements))]
    return "\n".join([*lines, f"XF {2 * elements + 2} 2.5", "END END\n"])


SPRING = "PLTRUSS 2 3 2\nX 3 1 -1\nFIX 3\nRLSE 2\n"
# model, the advice, what it means there
ADVICE: list[tuple[str, str, Callable[[], str]]] = [
    (BAR, "support it (FIX)", lambda: swapped(BAR, ("DYNX 2\n", "DYNX 2 1\nFIX 2 2\n"))),
    (BAR, "prescribe it (INPUTX", lambda: swapped(BAR, ("DYNX 2\n", "DYNX 2 1\nINPUTX 2 2\n"))),
    (BAR, "give it a stiffness (ESTIFF)", lambda: swapped(BAR, ("END HALT\n", f"{SPRING}END HALT\nESTIFF 2 9\n"))),
    (HASTY, "more iterations (the first number of ITERSTEP)", lambda: swapped(HASTY, ("ITERSTEP 1", "ITERSTEP 20"))),
    (TOGGLE, "prescribe the displacement instead of the load",
     lambda: swapped(TOGGLE, ("DYNX 2 1 2", "DYNX 2 1\nINPUTX 2 2"), ("XF 2 0 -0.1", "INPUTX 2 2 -0.2"))),
    (TOGGLE, "ITERSTEP position 7 the value 1", lambda: swapped(TOGGLE, ("1e-9", "1e-9 1 0 0 1"))),
    (arch(1), "the model with more elements may have none", lambda: arch(8)),
]  # fmt: skip


@pytest.mark.parametrize("general", ["", "1"])
@pytest.mark.parametrize(("text", "advice", "changed"), ADVICE, ids=[a[1][:25] for a in ADVICE])
def test_advice(text, advice, changed, general, monkeypatch):
    monkeypatch.setenv("SPACAR_GENERAL", general)
    with pytest.raises(AnalysisError) as caught:
        spacar.run(7, spacar.parse_deck(text, mode=7))
    assert advice in str(caught.value)
    spacar.run(7, spacar.parse_deck(changed(), mode=7))


def test_the_load_that_was_reached_can_be_carried():
    """The message of a limit point names the load: a millionth less has a solution."""
    with pytest.raises(AnalysisError) as caught:
        spacar.run(7, spacar.parse_deck(TOGGLE, mode=7))
    load = -0.1 * (1 - 1e-6) * caught.value.data["level"].initial
    r = spacar.run(7, spacar.parse_deck(TOGGLE.replace("-0.1", repr(load)), mode=7))
    assert r.node(2, 2)[-1] > 0.25


@pytest.mark.parametrize("start", [(1.0, 0.3), (1.3, 0.35), (1.4, 0.4), (1.6, 0.45)])
def test_start_values_that_lead_to_a_limit_point(start):
    """The loads are carried: the way that begins at the reference configuration finds the state."""
    text = TOGGLE.replace("-0.1", "-0.03").replace("XF", "STARTDX 2 1 {}\nSTARTDX 2 2 {}\nXF".format(*start))
    here = spacar.run(7, spacar.parse_deck(text, mode=7)).node(2)[-1]
    want = spacar.run(7, spacar.parse_deck(TOGGLE.replace("-0.1", "-0.03"), mode=7)).node(2)[-1]
    assert here == pytest.approx(want, abs=1e-9)
