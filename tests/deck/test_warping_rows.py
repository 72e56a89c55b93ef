"""Input of BEAMW: what is accepted, and one sentence for every way to get it wrong (theory-warping.md section 1)."""

import pytest

from spacar.deck import parse_deck
from spacar.errors import InputError
from spacar.mechanism import build

KINEMATICS = "BEAMW 1  1 2 3  4 5 6  0. 1. 0.\nX 4 1. 0. 0.\nFIX 1\nFIX 2\nFIX 3\n"
STIFF = "ESTIFF 1 1. 1. 1. 1. 0. 0. 1.\nEM 1 1. 0. 0. 0. 0. 1.\n"


def text(more: str = "DYNE 1\n", dynamics: str = STIFF) -> str:
    return f"{KINEMATICS}{more}END HALT\n{dynamics}END END\n"


def messages(source: str, mode: int = 1) -> list[str]:
    try:
        return [str(m) for m in parse_deck(source, mode=mode).messages]
    except InputError as error:
        return [str(m) for m in error.messages]


def test_default_classes():
    """w is a dynamic degree of freedom unless FIX or INPUTX; modes 7 and 8 are calculable in a rigid beam too."""
    n = build(parse_deck(text("")), 1).numbering
    assert (n.nddof, n.nep.tolist()) == (1, [8, 2, 0, 0, 0])
    assert n.q_names == ["node 6 w"]
    n = build(parse_deck(text("DYNE 1\n")), 1).numbering
    assert (n.nddof, int(n.nep[1])) == (7, 2)  # DYNE without numbers: modes 1 to 6
    assert build(parse_deck(text("INPUTX 6 1\n")), 1).numbering.ndof == 1
    assert messages(text("RLSE 1 1 2 3 4 5 6 7 8\n")) == []
    assert messages(text("DYNE 1\nDYNX 6\n")) == []
    assert messages(text("DYNE 1\nX 6 0.\n")) == []


@pytest.mark.parametrize(
    ("more", "dynamics", "sentences"),
    [
        ("DYNE 1 7\n", STIFF, ("DYNE 1", "mode 7 (warping at p) of the BEAMW is always calculable", "FIX or INPUTX")),
        ("INPUTE 1 8\n", STIFF, ("mode 8 (warping at q)", "always calculable")),
        ("RLSE 1 9\n", STIFF, ("mode 9 does not exist", "mode 1 to 8")),
        ("X 6 0.1 0. 0.\n", STIFF, ("node 6 is a warping node; its coordinate is zero at the start",)),
        ("FIX 6 2\n", STIFF, ("coordinate 2 does not exist", "warping node 6", "only 1")),
        ("DYNX 6\nFIX 6\n", STIFF, ("coordinate 1 cannot be fixed: it was declared dynamic",)),
        ("BEAM 2 4 5 7 6\nX 7 2. 0. 0.\n", STIFF, ("orientation node 6 is used as warping node by BEAMW 1 (line 1)",)),
        ("BEAMW 2 4 5 6 7 8 6 0. 1. 0.\nX 7 2.\n", STIFF, ("p and q are the same warping node 6",)),
        ("BEAMW 2 4 5 7 8 0. 1. 0.\n", STIFF, ("too few arguments", "BEAMW takes 10 or 11 arguments")),
        ("DYNE 1\n", STIFF + "XF 6 1. 2.\n", ("surplus argument '2.'", "a warping node")),
        ("DYNE 1\n", STIFF + "XM 6 -1.\n", ("negative mass or inertia -1",)),
        ("DYNE 1\n", "ESTIFF 1 1. 1. 1. 1. 0. 0. -1.\n", ("negative stiffness -1",)),
        ("DYNE 1\n", "EM 1 1. 0. 0. 0. 0. -1.\n", ("negative mass -1",)),
        ("", "EM 1 1. 0. 0. 0. 0. 1.\n", ("nothing holds the twist rate of warping node 6: FIX 6, or give ESTIFF",)),
    ],
)
def test_sentences(more, dynamics, sentences):
    found = "\n".join(messages(text(more, dynamics)))
    for sentence in sentences:
        assert sentence in found


def test_what_a_front_end_writes_without_warping():
    """FIX of a warping node that no element uses: a warning, as it stands in every such file."""
    found = messages("BEAM 1 1 2 4 5\nX 4 1. 0. 0.\nFIX 1\nFIX 2\nFIX 3  #warping\nEND END\n")
    assert len(found) == 1
    assert "node 3 is not used by any element" in found[0]


def test_loads_and_inertia_of_a_warping_node():
    """XF is a bimoment, XM adds to half of l0 Jw."""
    m = build(parse_deck(text("DYNE 1\n", STIFF + "XF 6 2.5\nXM 6 0.25\n")), 1)
    i = m.numbering.x_index(6, 1)
    assert m.loads.force[i] == 2.5
    (lumped,) = [b for b in m.batches if b.family.keyword == "XM"]
    assert dict(zip(lumped.x[0].tolist(), lumped.family.m.tolist(), strict=True))[i] == 0.5 + 0.25
