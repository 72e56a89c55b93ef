"""Models without degrees of freedom: every mode and what is asked of its result."""

import numpy as np
import pytest

import spacar
from spacar.deck import parse_deck
from spacar.errors import InputError, UsageError

PLANE = "PLBEAM 1 1 2 3 4\nX 3 1 0\nFIX 1\n{held}OUTLEVEL {level}\nEND HALT\nXM 3 1\n{drive}TIMESTEP 1 2\n"
SPACE = "BEAM 1 1 2 3 4 0 1 0\nX 3 1 0 0\nFIX 1\n{held}OUTLEVEL {level}\nEND HALT\nXM 3 1\n{drive}TIMESTEP 1 2\n"
HELD = {"fixed": ("FIX 2\n", ""), "driven": ("INPUTX 2 {c}\n{more}", "INPUTX 2 {c} 0 0.1 0\n")}
PORTS = {
    "none": ("", 0, 0), "output": ("OUTX 1 3 1\n", 0, 1), "input": ("INPUTF 1 3 1\n", 1, 0),
    "both": ("INPUTF 1 3 1\nOUTX 1 3 1\n", 1, 1),
}  # fmt: skip


@pytest.mark.parametrize("mode", [1, 4, 7, 8, 9, 10])
@pytest.mark.parametrize(("text", "c"), [(PLANE, "1"), (SPACE, "2")], ids=["plane", "space"])
@pytest.mark.parametrize("held", list(HELD))
@pytest.mark.parametrize("level", ["0 0", "15 3"])
def test_every_mode(mode: int, text: str, c: str, held: str, level: str, tmp_path) -> None:
    """Transfer functions have no columns, state space matrices no states, and all can be saved."""
    held, drive = (line.format(c=c, more="FIX 2 3 4\n" * (c == "2")) for line in HELD[held])
    text = text.format(held=held, drive=drive, level=level)
    for ports, nu, ny in PORTS.values():
        deck = parse_deck(f"{text}END HALT\n{ports}END END\n", mode=mode)
        r = spacar.run(mode, deck)
        assert np.isfinite(r["x"]).all()
        if level != "0 0":
            assert r["d2x"].shape[1:] == (r.mechanism.numbering.nx, r.mechanism.numbering.nkdof**2)
        if mode in (4, 9):
            A, B, C, D = r.ss()
            assert (A.shape, B.shape, C.shape) == ((0, 0), (0, nu), (ny, 0))
            assert D.shape == (ny, nu)
            assert r.ss().to_scipy().D.shape == (ny, nu)
        else:
            with pytest.raises(UsageError, match="no state space"):
                r.ss()
    r.save(tmp_path / "a")


def test_a_result_is_asked_like_a_dictionary() -> None:
    deck = parse_deck(PLANE.format(held="FIX 2\n", drive="", level="0 0") + "END END\n", mode=1)
    r = spacar.run(1, deck)
    assert "x" in r
    assert "dx" not in r
    assert "rl0" in r
    assert 3 not in r
    assert len(r) == len(r.keys()) == len(list(r))
    assert all(name in r for name in r)
    assert {"t", "x", "xdd", "e", "sig", "fxtot", "lnp"} <= dict(r).keys()


def test_mode_3_along_a_result_in_memory_can_be_saved(tmp_path) -> None:
    text = PLANE.format(held="FIX 2\n", drive="", level="0 0") + "END END\n"
    along = spacar.run(10, parse_deck(text, mode=10))
    spacar.run(3, parse_deck(text, mode=3), nominal=along).save(tmp_path / "a")
    assert "Nominal motion: the mode 10 result <deck>" in (tmp_path / "a.log").read_text()


@pytest.mark.parametrize(
    "lines",
    ["BEAMSEC 1 s\n steel 2\n", "BEAMSEC\n1\ns\nsteel\n2\n", "BEAMSEC 1\n s steel\n 2 X 3 1 0\n"],
)
def test_names_may_stand_on_the_next_line(lines: str) -> None:
    base = "PLBEAM 1 1 2 3 4\nX 3 1 0\nFIX 1\nFIX 2\nDYNE 1 2 3\nSECTION s\n RECT\n .02 .01\n"
    if "X 3" in lines:
        base = base.replace("X 3 1 0\n", "")
    deck = parse_deck(f"{base}{lines}END END\n")
    assert [(s.section, s.material_name, len(s.parts)) for s in deck.sections] == [("s", "steel", 2)]
    with pytest.raises(InputError, match=r"BEAMSEC 1: too few arguments"):
        parse_deck(f"{base}BEAMSEC 1 s\nKINE 1\nEND END\n")


@pytest.mark.parametrize("mode", [4, 9])
def test_rigid_degrees_of_freedom_are_counted(mode: int) -> None:
    """NRBM: a hinge without a spring, not the two bending modes."""
    text = "PLBEAM 1 1 2 3 4\nPLTOR 2 2 5\nX 3 1 0\nFIX 1\nFIX 5\nDYNE 2 1\nDYNE 1 2 3\nEND HALT\nEM 1 1\nXM 3 1\n"
    assert spacar.run(mode, parse_deck(f"{text}ESTIFF 1 0 100\nTIMESTEP 1 2\nEND END\n", mode=mode)).header["NRBM"] == 1
