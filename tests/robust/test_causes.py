"""Messages that name the cause: a singular choice of degrees of freedom, a word of another block, another mode."""

import numpy as np
import pytest

import spacar
from spacar.errors import AnalysisError, InputError

# The tip y is an input and the last bending at q is released: the angle of the tip is left to nothing.
CANTILEVER = """
PLBEAM 1 1 2 3 4
PLBEAM 2 3 4 5 6
PLBEAM 3 5 6 7 8
X 3 0.3333333333 0.
X 5 0.6666666667 0.
X 7 1. 0.
FIX 1
FIX 2
INPUTX 7 2
RLSE 3 3
DYNE 1 1 2 3
DYNE 2 1 2 3
DYNE 3 {last}
END
HALT
ESTIFF 1 1000. 10.
ESTIFF 2 1000. 10.
ESTIFF 3 1000. 10.
EM 1 1.
EM 2 1.
EM 3 1.
INPUTX 7 2 {y} 0. 0.
TIMESTEP 0.001 1
END
END
"""


@pytest.mark.parametrize("y", [0.1, 0.01])
def test_a_singular_choice_of_degrees_of_freedom_is_named(y):
    with pytest.raises(AnalysisError, match="singular choice of degrees of freedom") as found:
        spacar.run(1, spacar.parse_deck(CANTILEVER.format(last="1 2", y=y)))
    text = str(found.value)
    assert "free motions at: node 8 phi" in text
    assert "choose other degrees of freedom" in text
    assert found.value.code == "position.singular"


@pytest.mark.parametrize("y", [0.1, 0.01])
def test_statics_finds_the_state_and_says_how_many_digits_a_choice_costs(y):
    """Against another choice, regular everywhere: reaction to rounding, eigenvalues within what the warning says."""
    text = CANTILEVER.format(last="1 2 3", y=y).replace("RLSE 3 3", "RLSE 1 3").replace("DYNE 1 1 2 3", "DYNE 1 1 2")
    exact = spacar.run(7, spacar.parse_deck(text))
    found = spacar.run(7, spacar.parse_deck(CANTILEVER.format(last="1 2", y=y)))
    assert not exact.report
    said = next(line for line in found.report if "hardly determine" in line)
    lost = float(said.split("up to ")[1].split(" ")[0])
    assert found.node(7, 2, "fxtot") == pytest.approx(exact.node(7, 2, "fxtot"), rel=1e-9)
    sizes = [np.sort(np.hypot(*r["eigval"][0].T)) for r in (exact, found)]
    assert np.max(np.abs(sizes[1] / sizes[0] - 1.0)) < lost


@pytest.mark.parametrize(
    ("word", "hint"),
    [
        ("SPRING", ""),  # 0.62 of USERSIG
        ("DAMPER", ""),
        ("ESTIF", "nearest: ESTIFF of the dynamics block: an END HALT may be missing"),
        ("TIMESTP", "nearest: TIMESTEP of the dynamics block"),
        ("GRAVTIY", "nearest: GRAVITY of the dynamics block"),
        ("PLBEM", "nearest: PLBEAM"),
    ],
)
def test_another_block_is_named_only_for_its_own_words(word, hint):
    with pytest.raises(InputError) as found:
        spacar.parse_deck(f"PLBEAM 1 1 2 3 4\nX 3 1. 0.\nFIX 1\nFIX 2\n{word} 1 2.\nEND\nEND\n")
    said = next(str(m) for m in found.value.messages if "unknown keyword" in str(m))
    assert hint in said
    if not hint:
        assert "nearest" not in said
        assert "END HALT" not in said


def test_a_deck_is_checked_again_for_the_mode_that_runs(tmp_path):
    """The same messages as from a file, whatever mode the deck was read for."""
    text = "PLTRUSS 1 1 2\nX 2 1. 0.\nFIX 1\nFIX 2 2\nDYNE 1 1\nEND\nHALT\n"
    text += "ESTIFF 1 10.\nXM 2 1.\nTIMESTEP 1. 4\nEND\nEND\n"
    path = tmp_path / "truss.dat"
    path.write_text(text)
    for other in (None, 1, 0, 7):
        deck = spacar.read_deck(path, other)
        for mode in (0, 1, 2, 7):
            assert outcome(mode, deck) == outcome(mode, path), (other, mode)


def outcome(mode, source):
    try:
        run = spacar.frames(mode, source)
    except InputError as error:
        return [str(m) for m in error.messages]
    return [str(m) for m in run.mechanism.deck.messages], len(run.mechanism.deck.statements)
