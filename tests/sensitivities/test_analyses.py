"""Sensitivities as a user meets them: the values are those of the modes, the command, the page, the optimization."""

import csv
import json
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from spacar_drawing.stresses import QUANTITIES

import spacar
from spacar.deck.directed import nothing_lost
from spacar.elements.planar.pltruss import PlanarTruss, TrussConfiguration
from spacar.errors import SpacarError, UsageError
from spacar.mechanism.build import along, build
from spacar.sensitivities.directed_elements import DirectedElements
from spacar.sensitivities.step_quantities import STRESSES
from spacar.stationary import LoadLevel
from tests.command_line import call
from tests.docs.documents import module_of
from tests.linear import linear_models

from .difference_truth import agree, values_of
from .test_closed_forms import EI, cantilever
from .test_every_element import still

HOUSE = Path(__file__).parents[2]
DATA = HOUSE / "data"


def test_values_are_those_of_the_modes() -> None:
    """Of mode 10 and of `spacar stress`, at two load steps, to the rounding of two ways to the same equilibrium.

    The condition of the stiffness matrix magnifies it, with a unit diagonal, as units of coordinates do not count.
    """
    deck = spacar.read_deck(DATA / "leafguide.dat", 10)
    result = spacar.run(10, deck)
    stress = result.stress()
    names = ["x[7,1]@end", "sig[1,1]@2", "fxtot[1,1]@end", "frequency[2]@3", "lmult[1]@end", "xcompl[7,3]@end",
             "mises[4]@end", "My[1,3]@2", "abs(eigval[1])@2"]  # fmt: skip
    found = spacar.sensitivity(deck, ["SECTION.leaf[t]"], names)
    want = [
        result.node(7, 1)[-1],
        result.element(1, 1, "sig")[1],
        result.node(1, 1, "fxtot")[-1],
        result.frequencies[2, 1],
        result["lmult"][-1][0],
        result.node(7, 3, "xcompl")[-1],
        np.abs(stress["mises"][-1, list(stress.elements).index(4)]).max(),
        stress["My"][1, list(stress.elements).index(1), 2],
        np.hypot(*result["eigval"][1][0]),
    ]
    size = np.sqrt(np.diag(K := result["k0"][-1]))
    rounding = np.finfo(float).eps * float(np.linalg.cond(K / np.outer(size, size)))
    assert rounding < 1e-8
    np.testing.assert_allclose(found.values, want, rtol=rounding)


def test_stress_names_are_those_of_the_pictures() -> None:
    assert set(STRESSES) == set(QUANTITIES)


def test_a_coefficient_that_is_zero() -> None:
    """A spring without stiffness beside one with: both have the derivative f/(2 k); a mass of zero too."""
    rows = [("PLTRUSS", 1, 1, 2), ("PLTRUSS", 2, 1, 2), ("X", 2, 2.0, 0.0), ("FIX", 1), ("FIX", 2, 2), ("DYNE", 1),
            ("RLSE", 2)]  # fmt: skip
    law = [("XM", 2, 3.0), ("ESTIFF", 1, 96.0), ("ESTIFF", 2, 0.0), ("EM", 2, 0.0), ("XF", 2, 5.0)]
    deck = spacar.Deck.build(rows, law, mode=10)
    found = spacar.sensitivity(deck, ["ESTIFF.1", "ESTIFF.2", "EM.2"], ["x[2,1]", "xcompl[2,1]"])
    u = 5.0 / 48.0
    np.testing.assert_allclose(found.derivatives[0], [-u / 96, -u / 96, 0.0], rtol=1e-12)
    np.testing.assert_allclose(found.derivatives[1], [-1 / 48 / 96, -1 / 48 / 96, 0.0], rtol=1e-12)
    preloaded = spacar.Deck.build(rows, [*law, ("ESIG", 2, 1.5)], mode=10)
    stress = spacar.sensitivity(preloaded, ["ESIG.2", "XF.2"], ["x[2,1]", "sig[1,1]"])
    np.testing.assert_allclose(stress.derivatives, [[-1 / 48, 1 / 48], [-1.0, 1.0]], rtol=1e-12)
    at_rest = spacar.sensitivity(spacar.Deck.build(rows, law[:-1], mode=10), ["ESTIFF.2", "EM.2"], ["frequency[1]"])
    f = 4.0 / (2 * np.pi)
    np.testing.assert_allclose(at_rest.derivatives[0], [f / 192, -f / 2 * (2.0 / 3.0) / 3.0], rtol=1e-12)


@pytest.mark.parametrize("model", sorted(p.stem for p in DATA.glob("*.dat")))
def test_no_element_loses_a_direction(model: str) -> None:
    """Everything that derivatives need is computed in complex numbers, for every example."""
    try:
        deck = spacar.read_deck(DATA / f"{model}.dat", 7)
        mechanism = build(deck, 7)
    except SpacarError:
        pytest.skip("not for mode 7")
    rng = np.random.default_rng(3)
    with nothing_lost():
        directed = along(mechanism, deck)
        elements = DirectedElements(directed, LoadLevel(1.0, 0.5 if mechanism.additional is not None else 0.0))
        elements.at(mechanism.x0 + 1e-50j * rng.standard_normal(len(mechanism.x0)), np.zeros(elements.ne))
        sigma = rng.standard_normal(elements.ne) * (1.0 + 1e-50j)
        v, a = rng.standard_normal((2, elements.nx)) * (1.0 + 1e-50j)
        parts = [elements.gradient(), elements.stiffness(), elements.damping()]
        parts.append(elements.second("geometric_stiffness", sigma))
        parts += [elements.loading(flow, v, a) for flow in (True, False)]
        parts += [*elements.inertia_gradient(v, a, gravity=False), elements.mass()]
        vectors = [elements.stress_forces(sigma), elements.inertia(v, a, gravity=True), elements.applied()]
        vectors += [elements.strain_rate(v), elements.convective(v), elements.viscous(sigma), elements.coupling(sigma)]
        vectors.append(elements.law(elements.deformations()))
        elements.internal(sigma)
    assert all(np.isfinite(m.values).all() for part in parts for m in part)
    assert all(np.isfinite(v).all() for v in vectors)


def test_an_element_without_complex_steps_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    """An element (of a user, say) that drops imaginary parts: one sentence, and no derivative without them."""

    def dropping(self: PlanarTruss, x: np.ndarray, *more: np.ndarray) -> TrussConfiguration:
        _, e, _ = more
        e[0] = np.asarray(x[0], float)
        return TrussConfiguration(x[0], x[:2])

    rows = [("PLTRUSS", 1, 1, 2), ("X", 2, 2.0, 0.0), ("FIX", 1), ("FIX", 2, 2), ("DYNE", 1)]
    deck = spacar.Deck.build(rows, [("XM", 2, 3.0), ("ESTIFF", 1, 96.0)], mode=10)
    mechanism = build(deck, 10)
    monkeypatch.setattr(PlanarTruss, "strain", dropping)
    elements = DirectedElements(along(mechanism, deck), LoadLevel(1.0, 0.0))
    with pytest.raises(UsageError, match="an element does not take complex steps"), nothing_lost():
        elements.at(mechanism.x0 + 1e-50j, np.zeros(elements.ne))


def test_a_state_without_linearization_in_a_long_chain() -> None:
    """300 beams: the derivative of the state uses the sparse tangent; w = F L^3/(3 EI) again."""
    F = 1e-7
    deck = cantilever(300, (0.0, F), length=1.0)
    found = spacar.sensitivity(deck, ["ESTIFF.*[EI]", "XF.601[3]"], ["x[601,2]"])
    w = F / (3 * EI)
    np.testing.assert_allclose(found.derivatives[0], [-w / EI, w / F], rtol=1e-6)


RELEASED = spacar.Deck.build(
    [("X", 1, 0.0, 0.0), ("X", 3, 1.0, 0.2), ("FIX", 1), ("FIX", 2), ("DYNX", 3), ("DYNX", 4),
     ("PLBEAM", 1, 1, 2, 3, 4), ("RLSE", 1)],
    [("ESTIFF", 1, 90.0, 2.0), ("EM", 1, 0.5, 0.01), ("XM", 3, 1.0), ("XF", 3, 0.2, 0.3)], mode=10,
)  # fmt: skip


@pytest.mark.parametrize(
    ("deck", "names", "end", "elements"),
    [
        (RELEASED, ["ESTIFF.1[2]", "ESTIFF.1[3]", "EM.1[2]", "X.3[3]"], "3", 3),
        (DATA / "plbeam5.dat", ["EM.1[2]", "X.11[2]"], "11", 2),
        (DATA / "leafguide.dat", ["SECTION.leaf[t]", "DELXF.7[2]"], "7", 2),  # 156 coordinates: sparse matrices
    ],
    ids=["released", "chain", "sections"],
)
def test_divided_beams(deck: spacar.Deck | Path, names: list[str], end: str, elements: int) -> None:
    """A number of the file is that of all parts (option `elements`), and new nodes move with those of the file."""
    source = deck if isinstance(deck, spacar.Deck) else spacar.read_deck(deck, 10)
    quantities = [f"x[{end},1]@end", f"x[{end},2]@end", "frequency[1]@end", "lmult[1]@end", f"xcompl[{end},1]@end"]
    agree(source, names, quantities, elements=elements, rel=3e-6)


def test_sweeps_over_sections_draw_the_section_of_the_case() -> None:
    """A deck with another dimension has the drawn section of that dimension only, and what the user wrote."""
    deck = spacar.read_deck(DATA / "leafguide.dat", 10).set("SECTION", "leaf", 4, 0.6)
    assert [line for line in deck.visualization if line.startswith("CROSSDIM 0.05 0.0")] == [
        "CROSSDIM 0.05 0.0006", "CROSSDIM 0.05 0.025", "CROSSDIM 0.05 0.025", "CROSSDIM 0.05 0.0006",
    ]  # fmt: skip
    assert deck.for_mode(7).visualization == deck.visualization


# -- the command -----------------------------------------------------------------------------------------------------
ARGUMENTS = ["-p", "ESTIFF.1[EA]", "-p", "XM.2", "--of", "f: frequency[1]", "--of", "x[2,1]@end"]


@pytest.fixture
def oscillator(tmp_path: Path) -> str:
    path = tmp_path / "oscillator.dat"
    path.write_text(
        "PLTRUSS 1 1 2\nX 2 2. 0.\nFIX 1\nFIX 2 2\nDYNE 1\nEND\nHALT\nXM 2 3.\nESTIFF 1 96.\nXF 2 4.8\nEND\nEND\n"
    )
    return str(path)


def test_the_table(oscillator: str) -> None:
    lines = call.done("sensitivity", oscillator, *ARGUMENTS).out.splitlines()
    assert lines[0].split()[:4] == ["quantity", "value", "unit", "parameter"]
    assert lines[1].split()[0] == "f"
    assert lines[1].split()[-1] == "+0.50000"
    assert len(lines) == 5


def test_csv_and_json(oscillator: str, tmp_path: Path) -> None:
    rows = list(csv.DictReader(call.done("sensitivity", oscillator, *ARGUMENTS, "--csv", "-").out.splitlines()))
    assert [r["parameter"] for r in rows] == ["ESTIFF.1[EA]", "XM.2"] * 2
    out = call.done("sensitivity", oscillator, *ARGUMENTS, "--json", "--csv", tmp_path / "out.csv").out
    found = json.loads(out.splitlines()[-1])
    assert found["derivatives"][0][0] == float(rows[0]["derivative"])
    assert found["quantities"][1] == {"name": "x[2,1]@end", "value": float(rows[2]["value"]), "unit": "m"}
    assert (tmp_path / "out.csv").read_text().startswith("quantity,value,unit,parameter,at")
    out = call.done("sensitivity", oscillator, "-p", "ESTIFF.1[EA]=24", "--of", "frequency[1]", "--json").out
    assert json.loads(out)["parameters"][0]["value"] == 24.0


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["-p", "ESTIFF.1"], "give at least one --parameter"),
        (["-p", "ESTIFF.7", "--of", "x[2,1]"], "there is no statement ESTIFF 7"),
        (["-p", "ESTIFF.1=a", "--of", "x[2,1]"], "'a' in 'ESTIFF.1=a' is not a number"),
        (["-p", "ESTIFF.1", "--of", "y[2,1]"], "variables with indices are"),
    ],
)
def test_what_the_command_refuses(oscillator: str, arguments: list[str], words: str) -> None:
    assert words in call.refused("sensitivity", oscillator, *arguments)


def test_notes_go_to_standard_error(tmp_path: Path) -> None:
    path = tmp_path / "spatial.dat"
    path.write_text(still(linear_models.SPATIAL.format(extra="", third="")).text)
    assert "cut to 0.5 of its size" in call.done("sensitivity", path, "-p", "XM.6", "--of", "x[6,1]").err


# -- the optimization ------------------------------------------------------------------------------------------------
@pytest.fixture(scope="module")
def example() -> ModuleType:
    return module_of(HOUSE / "docs" / "optimize_guide.py")


def test_derivatives_of_the_example(example: ModuleType) -> None:
    """All frequencies and stresses, along one direction in all 13 parameters."""
    model = example.Guide()
    found = model.at(model.start)
    direction = np.random.default_rng(2).uniform(-1.0, 1.0, len(model.start)) * np.abs(model.start) * 1e-4
    values = values_of(model.deck, model.names, found.quantities)
    want = 0.5 * (values(model.start + direction) - values(model.start - direction))
    np.testing.assert_allclose(found.derivatives @ direction, want, rtol=1e-4, atol=1e-9 * np.abs(found.values).max())


@pytest.mark.slow
def test_the_optimization_needs_a_tenth_of_the_analyses(example: ModuleType) -> None:
    """The numbers of the page: the same optimum, with 18 analyses instead of 213."""
    exact, differences = example.Guide(), example.Guide(exact=False)
    results = [example.optimize(model) for model in (exact, differences)]
    assert all(r.success for r in results)
    lowest = [model.course[-1][1] for model in (exact, differences)]
    assert lowest[0] == pytest.approx(170.79, abs=0.2)
    assert lowest[1] == pytest.approx(lowest[0], rel=1e-3)
    stresses = exact.at(example.found_parameters(exact, results[0])).values[len(exact.frequencies) :]
    assert stresses.max() <= example.LIMIT * (1 + 1e-4)
    assert differences.analyses >= 10 * exact.analyses
