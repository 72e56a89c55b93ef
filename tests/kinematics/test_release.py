"""Over-constraints solved by releasing flexible deformations: the physics is that of the structure for any choice."""

import re

import numpy as np
import pytest
from scipy.linalg import eigh

import spacar
from spacar.deck import Deck, parse_deck
from spacar.deck.rewrite.refine import refine
from spacar.deck.rewrite.released_text import released
from spacar.errors import AnalysisError
from spacar.kinematics.advice import FLEXIBLE, HINGE, REDUNDANT
from spacar.kinematics.diagnosis import _without
from spacar.kinematics.release import release

from .guides import E, G, L, T, W, coupler_frequencies, guide

EI24 = 24 * 2.1e11 * 0.05 * 5e-4**3 / 12  # two guided leaves: k = 24 EI/L^3


def frequencies(deck: spacar.Deck) -> np.ndarray:
    """omega from the reduced matrices of the unloaded model (mode 9 makes them without any eigenvalue)."""
    r = spacar.run(9, deck.for_mode(9))
    M, K = (np.asarray(r[name][0]) for name in ("m0", "k0"))
    return np.sqrt(eigh(K, M, eigvals_only=True))


@pytest.mark.parametrize("n", [2, 6])
def test_frequencies_are_those_of_the_structure(n: int) -> None:
    """6 and 30 over-constraints at once. Tolerance: the matrices of the textbook and ours are both rounded at eps times
    the ratio of the largest to the smallest stiffness, EA L^2/EI = 5e5."""
    solved = release(parse_deck(guide(n)))
    assert (solved.left, solved.diagnosis.under, len(solved.parts)) == (0, 0, 6 * (n - 1))
    assert solved.diagnosis.condition < 100
    assert frequencies(solved.deck) == pytest.approx(coupler_frequencies(n), rel=1e-9)


@pytest.mark.parametrize("seed", range(8))
def test_any_choice_of_flexible_deformations_has_the_same_physics(seed: int) -> None:
    """Releases taken at random among the flexible ones that can take an over-constraint away."""
    rng = np.random.default_rng(seed)
    deck = parse_deck(guide(3))
    diagnosis = spacar.run(0, deck).header["diagnosis"]
    pairs = random_choice(deck, rng)
    assert len(pairs) == diagnosis.over == 12
    other = released(deck, pairs)
    assert spacar.run(0, other).header["diagnosis"].over == 0
    # worse choices of degrees of freedom lose digits by their condition, at most 1e3 here
    assert frequencies(other) == pytest.approx(coupler_frequencies(3), rel=1e-7)


def random_choice(deck: spacar.Deck, rng: np.random.Generator) -> list[tuple[int, int]]:
    """A random set of flexible deformations whose release leaves no over-constraint."""
    mechanism = spacar.mechanism.build(deck, 0)
    n = mechanism.numbering
    V = spacar.run(0, deck)["bigd"][0]
    rows = np.arange(n.e_class["dynamic"].stop)
    scaled = V * mechanism.scale / mechanism.deformation_scale[:, None]
    D = scaled[rows][:, n.x_class["calculable"]]
    left, s, _ = np.linalg.svd(D)
    null = left[:, int(np.sum(s > 1e-8 * s[0])) :]
    pairs = []
    while null.shape[1]:
        weight = np.sum(null**2, axis=1)
        allowed = [i for i in range(n.e_class["dynamic"].start, len(rows)) if weight[i] > 0.05 * weight.max()]
        i = int(rng.choice(allowed))
        pairs.append(n.e_owner(i))
        null = _without(null, i)
    return pairs


def test_two_leaf_springs_and_a_rigid_coupler() -> None:
    """The case of the report: 10 N give 3.81 mm, 19.05 Hz; hinges in the coupler gave 15.5 mm and 9.55 Hz.

    F/k = F L^3/(24 EI) = 3.8095 mm, to the second order in the rotation of the leaves: 0.6 (u/L)^2 = 0.1 %.
    Omega^2 = k/(m + 2 13/35 rho A L), the exact kinetic energy of the guided cubic shape.
    """
    deck = release(parse_deck(guide(2, load=10.0, mass=True), mode=7)).deck
    r = spacar.run(9, deck.for_mode(9))
    assert r.node(3, 1)[-1] == pytest.approx(10.0 * L**3 / EI24, rel=2e-3)
    assert r.node(3, 1)[-1] == pytest.approx(3.81e-3, abs=0.01e-3)
    unloaded = release(parse_deck(guide(2, mass=True))).deck
    omega = frequencies(unloaded)[0]
    assert omega / (2 * np.pi) == pytest.approx(19.05, abs=0.01)


def test_flexible_deformations_come_first_and_rigid_ones_are_marked() -> None:
    d = spacar.run(0, parse_deck(guide(2), mode=0)).header["diagnosis"]
    effects = [p.effect for p in d.parts]
    assert effects == sorted(effects)
    assert {p.effect for p in d.parts if p.element in (1, 3)} == {FLEXIBLE}
    assert {p.effect for p in d.parts if p.element == 2} == {HINGE}
    assert {p.element for p in d.advice} <= {1, 3}
    assert sum(p.share for p in d.parts) == pytest.approx(1.0, abs=1e-6)
    text = "\n".join(d.lines())
    assert "element 2 (BEAM) e3 bending at p in the x'z' plane: changes the model: a hinge" in text


def test_the_lines_are_ready_to_paste() -> None:
    """Comments and everything else stay; the lines replace the DYNE statements that they name."""
    deck = parse_deck(guide(2), mode=0)
    d = spacar.run(0, deck).header["diagnosis"]
    text = deck.text
    for number in {p.element for p in d.advice}:
        new = [line for line in d.paste if line.split()[:2] in (["DYNE", str(number)], ["RLSE", str(number)])]
        assert "RLSE" in new[-1]
        assert f"% in place of DYNE {number} (line " in "\n".join(d.paste)
        text = text.replace(f"DYNE {number} ", "\n".join(new) + " ")
    assert spacar.run(0, parse_deck(text, mode=0)).header["diagnosis"].over == 0
    solved = release(deck).deck
    assert "% leaf 1" in solved.text
    assert [m for m in solved.messages if m.severity != "information"] == []


@pytest.mark.parametrize(
    "statement",
    ["DYNE 1 1 2 3 4 5 6 FIX 1\n", "DYNE 1 1 2 3\n 4 5 6 % more\nFIX 1\n", "DYNE 1\nFIX 1\n",
     "dyne\n1\n1 2 3 DYNE 1 4 5 6 FIX 1\n", "DYNE 1 6 5 4 3 2 1%x\nFIX 1\n"],
)  # fmt: skip
def test_every_way_to_write_dyne_is_edited(statement: str) -> None:
    base = guide(2).replace("DYNE 1   % leaf 1\n", statement).replace("FIX 1\n", "", 1)
    assert base.count("FIX 1\n") == 1
    deck = parse_deck(base)
    changed = released(deck, [(1, 2), (1, 3), (1, 5)])
    classes = {}
    for s in changed.of("DYNE", "RLSE", block=1):
        for mode in s.integers(1) or range(1, 7):
            classes[s.integer(0), mode] = s.keyword
    expected = {m: "RLSE" if m in (2, 3, 5) else "DYNE" for m in range(1, 7)}
    assert {m: classes[1, m] for m in range(1, 7)} == expected
    assert changed.of("FIX")[-1].values == deck.of("FIX")[-1].values
    assert len(changed.of("FIX")) == len(deck.of("FIX"))


SQUARE = (
    "PLTRUSS 1 1 3\nPLTRUSS 2 2 4\nPLTRUSS 3 3 4\nPLTRUSS 4 1 4\nPLTRUSS 5 2 3\n"
    "X 1 0. 0.\nX 2 1. 0.\nX 3 0. 1.\nX 4 1. 1.\nFIX 1\nFIX 2\n{more}END END\n"
)


def test_bars_of_a_rigid_square() -> None:
    """Redundant rigid bars free nothing and are not released without being asked; where one diagonal has a DYNE, it is
    the only one whose release keeps the physics."""
    solved = release(parse_deck(SQUARE.format(more="")))
    assert solved.left == 1
    assert solved.parts == ()
    assert {p.effect for p in solved.diagnosis.advice} == {REDUNDANT}
    assert "% rigid, but the rest holds it too" in solved.diagnosis.paste[0]
    solved = release(parse_deck(SQUARE.format(more="DYNE 5\nEND HALT\nESTIFF 5 3.\n")))
    assert solved.left == 0
    assert [(p.element, p.mode, p.effect) for p in solved.parts] == [(5, 1, FLEXIBLE)]
    assert "RLSE 5" in solved.deck.text


def test_a_start_value_keeps_a_deformation_dynamic() -> None:
    text = guide(2, more="\n".join(f"STARTDE 1 {m} 1e-6" for m in range(1, 7)))
    solved = release(parse_deck(text))
    assert solved.left == 0
    assert {p.element for p in solved.parts} == {3}


def test_a_dead_point_is_no_redundancy() -> None:
    """Two collinear bars on a driven crank: the self-stress exists in this position only, a release would free the
    motion; the same two bars held by a third one (parallel cranks) are redundant along the whole motion."""
    locked = "PLBEAM 1 1 2 3 4\nPLBEAM 2 3 5 6 7\nX 3 0.15 0.\nX 6 0.35 0.\nFIX 1\nFIX 6\nINPUTX 2 1\nEND END\n"
    d = spacar.run(0, parse_deck(locked)).header["diagnosis"]
    assert d.over >= 1
    assert REDUNDANT not in {p.effect for p in d.advice}
    three = "".join(f"PLRBEAM {k} {3 * k} {3 * k + 1} {3 * k + 2}\n" for k in (1, 2, 3))
    three += "PLRBEAM 4 5 20 8\nPLRBEAM 5 5 20 11\n"
    for k in (1, 2, 3):
        three += f"X {3 * k} {k}. 0.\nX {3 * k + 2} {k + 0.3} 1.\nFIX {3 * k}\n"
    d = spacar.run(0, parse_deck(three + "INPUTX 4\nEND END\n")).header["diagnosis"]
    assert (d.over, d.under) == (1, 0)
    assert [p.effect for p in d.advice] == [REDUNDANT]


# Over-constraints of beams that are divided, in any way: the lines hold for the file, and the physics is that of the
# textbook. Statically a massless leaf is exact in any number of beams.
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


# A release that becomes singular during a motion: the message names it and another one, which runs.
JOINTS = ("0 1 0", "0 0 1", "1 0 0")
CUBE = ((0, 0, 0), (1, 0, 0), (1, -1, 0), (1, -1, 1), (0, -1, 1), (0, 0, 1))


def bricard(release: str, size: float, g: float) -> spacar.Result:
    """The orthogonal linkage on the edges of a cube, which moves though it has one equation too many."""
    lines = [f"HINGE {k} {k} {k + 1} {JOINTS[(k - 1) % 3]}" for k in range(1, 7)]
    lines += [f"RBEAM {k} {k} {k - 9} {k + 1}" for k in range(11, 16)]
    lines += [f"X {11 + k} {size * x} {size * y} {size * z}" for k, (x, y, z) in enumerate(CUBE)]
    lines += ["FIX 1", "FIX 7", "FIX 11", "FIX 16", "DYNE 1 1", *(f"RLSE {k} 1" for k in range(2, 7)), release]
    lines += ["END", "HALT", "TIMESTEP 3 30", *(f"EM {k} 1.0" for k in range(11, 16)), f"GRAVITY 0 {-g!r} 0"]
    return spacar.run(1, parse_deck("\n".join([*lines, "END", "END", ""]), mode=1))


@pytest.mark.parametrize(
    ("release", "size"), [("RLSE 11 1", 1.0), ("RLSE 11 1", 0.02), ("RLSE 12 3", 1.0)], ids=["stops", "small", "passes"]
)
def test_a_release_that_becomes_singular_is_named_with_another_that_runs(release: str, size: float) -> None:
    g = 9.81 * size
    try:
        told = "\n".join(bricard(release, size, g).report)
    except AnalysisError as stopped:
        told = str(stopped)
    text = r"the release (RLSE \d+ \d+) becomes singular here: give (RLSE \d+ \d+) in its place"
    found = re.search(text, told)
    assert found
    assert found[1] == release
    result = bricard(found[2], size, g)
    element, mode = map(int, found[2].split()[1:])
    assert np.abs(result.element(element, mode, "e")).max() < 1e-9 * size  # what is released does not move
    assert not result.report


def test_an_ordinary_dead_point_has_no_such_advice() -> None:
    text = """
PLRBEAM 1 1 2 3   PLRBEAM 2 3 4 5   X 1 0 0   X 3 1 0   X 5 2.5 0.1   FIX 1   FIX 5 2   DYNX 5 1
END HALT
XM 5 1   STARTDX 5 1 2.4 3.   TIMESTEP 2 20   END END
"""
    with pytest.raises(AnalysisError) as stopped:
        spacar.run(1, parse_deck(text, mode=1))
    assert "RLSE" not in str(stopped.value)
