"""Over-constraints of beams that are divided, in any way: the lines hold for the file, and the physics is that of the
textbook. Statically a massless leaf is exact in any number of beams."""

import numpy as np
import pytest
from scipy.linalg import eigh

import spacar
from spacar.deck import Deck, parse_deck
from spacar.deck.rewrite.refine import refine
from spacar.deck.rewrite.released_text import released
from spacar.errors import AnalysisError
from spacar.kinematics.advice import FLEXIBLE
from spacar.kinematics.release import release

from .guides import E, G, T, W, coupler_frequencies, guide


def slowness(deck: Deck, elements: int = 1) -> np.ndarray:
    """The six 1/omega^2 of the rigid coupler, descending, on leaves that weigh 1e-8 of it. Mode 9 without load."""
    r = spacar.run(9, deck.for_mode(9), elements=elements, modes=0)
    M, K = (np.asarray(r[name][0]) for name in ("m0", "k0"))
    return eigh(M, K, eigvals_only=True)[::-1][:6]


def divided(n: int, beams: int, dyne: str = "") -> Deck:
    """The guide with leaves that BEAMSEC divides; `dyne`: modes behind DYNE of every leaf."""
    text = guide(n)
    lines = [line for line in text.splitlines() if not line.startswith("ESTIFF")]
    end = lines.index("END HALT")
    leaves = [f"BEAMSEC {2 * i + 1} s m {beams}" for i in range(n)]
    lines[end:end] = [f"SECTION s RECT {W} {T}", f"MATERIAL m {E} {G} 1e-3", *leaves]
    return parse_deck("\n".join(lines).replace("   % leaf", f" {dyne} % leaf") + "\n")


def pasted(deck: Deck) -> Deck:
    """The file with the lines of the report in place of the statements that they name, as a user does it."""
    diagnosis = spacar.run(0, deck).header["diagnosis"]
    lines = deck.text.splitlines()
    new: dict[int, list[str]] = {}
    for line in diagnosis.paste:
        if line.startswith("% in place of"):
            number = int(line.split("(line ")[1].rstrip("):"))
        else:
            new.setdefault(number, []).append(line)
    return parse_deck("\n".join("\n".join(new.get(k, [line])) for k, line in enumerate(lines, 1)) + "\n")


@pytest.mark.parametrize(("n", "beams"), [(2, 2), (2, 3), (3, 2)])
def test_pasted_lines_solve_it_and_keep_the_physics(n: int, beams: int) -> None:
    deck = divided(n, beams)
    undivided = slowness(release(divided(n, 1)).deck)
    d = spacar.run(0, deck).header["diagnosis"]
    assert d.over == 6 * (n - 1)
    assert {p.element for p in d.advice} <= {2 * i + 1 for i in range(n)}  # numbers of the file
    assert [line for line in d.paste if line[0] != "%"] == [f"RLSE {p}" for p in sorted({p.element for p in d.advice})]
    for solved in (pasted(deck), release(deck).deck):
        assert spacar.run(0, solved).header["diagnosis"].over == 0
        assert slowness(solved) == pytest.approx(undivided, rel=1e-7)  # 1e-8 as above


@pytest.mark.parametrize("pieces", [2, 3])
def test_a_refined_model_is_released_by_the_lines_of_its_file(pieces: int) -> None:
    """--elements: the diagnosis of the refined model names elements and lines of the file; with these it runs."""
    deck = parse_deck(guide(2, more="EM 1 2.5e-8 1e-11 1e-11\nEM 3 2.5e-8 1e-11 1e-11"))
    d = spacar.run(0, deck, elements=pieces).header["diagnosis"]
    assert {p.element for p in d.advice} <= {1, 3}
    solved = release(refine(deck, pieces)).deck
    assert solved.text.count("RLSE") == 1
    assert spacar.run(0, solved, elements=pieces).header["diagnosis"].over == 0
    assert spacar.run(0, pasted(divided(2, 2)), elements=pieces).header["diagnosis"].over == 0
    assert slowness(solved, pieces) == pytest.approx(coupler_frequencies(2) ** -2, rel=1e-7)


@pytest.mark.parametrize("modes", [(2,), (3,), (4,), (5, 6), (2, 3, 5), (1, 4)])
def test_single_modes_of_a_divided_beam(modes: tuple[int, ...]) -> None:
    """One mode of a bending pair may be released: the last part keeps the release."""
    deck = divided(1, 3)
    free = released(deck, [(1, m) for m in modes])
    last = deck.divided[1][-1]
    classes = {(s.integer(0), m): s.keyword for s in free.of("DYNE", "RLSE", block=1) for m in s.integers(1)}
    assert {m for (e, m), word in classes.items() if word == "RLSE"} == set(modes)
    assert {e for (e, m), word in classes.items() if word == "RLSE"} == {last}
    assert len(classes) == 18
    with pytest.raises(AnalysisError, match="under-constrained"):  # the file had as many as it needs
        spacar.run(7, free)
    assert spacar.run(0, deck).header["diagnosis"].under == 0


def test_only_bending_is_dynamic() -> None:
    """Leaves that are stiff along their axis: single modes are released, of the last parts, and the lines run."""
    deck = divided(2, 2, "3 4 5 6 2")
    d = spacar.run(0, deck).header["diagnosis"]
    flexible = [p for p in d.advice if p.effect == FLEXIBLE]
    assert flexible
    text = release(deck).deck
    assert spacar.run(0, text).header["diagnosis"].over == d.over - len(flexible)


def test_a_motion_starts_with_released_divided_beams() -> None:
    """And a model with start values keeps those deformations."""
    deck = divided(2, 2)
    text = deck.text.replace("END HALT\n", "END HALT\nSTARTDE 1 3 1e-6 0\nSTARTDE 1 4 1e-6 0\n", 1)
    solved = release(parse_deck(text)).deck
    assert "RLSE 3" in solved.text
    assert "RLSE 1" not in solved.text
    with pytest.raises(AnalysisError, match="with --release solves it"):
        spacar.run(7, deck)
