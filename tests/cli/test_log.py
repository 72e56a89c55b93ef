"""The log: its sections in their order, numbers with enough digits, words (reference/files.md section 2)."""

import re

import numpy as np
import pytest
from spacar_formats.sbf import SbfFile

import spacar
from tests.examples import DATA


@pytest.fixture
def log_of(call, tmp_path):
    def run(mode: int, name: str, text: str | None = None, *options: str) -> str:
        (tmp_path / f"{name}.dat").write_text(text or (DATA / f"{name}.dat").read_text())
        call.done(mode, name, *options)
        return (tmp_path / f"{name}.log").read_text()

    return run


def in_order(text: str, *fragments: str) -> bool:
    at = -1
    for fragment in fragments:
        at = text.find(fragment, at + 1)
        if at < 0:
            return False
    return True


def rows_of(log: str, heading: str) -> list[list[str]]:
    """Cells of the table whose heading line begins with these words."""
    lines = iter(log.splitlines())
    for line in lines:
        if line.strip().startswith(heading):
            break
    return [line.split() for line in iter(lambda: next(lines), "")]


def test_sections_in_the_documented_order(log_of):
    log = log_of(1, "crankfl", None, "--time", "0.001", "--steps", "5")
    assert in_order(
        log, f"spacar {spacar.__version__}   20", "Apache License", "Mode 1: forward dynamics",
        "SHA-256 of the input file", "KINEMATICS", "PLBEAM 1 1 2 3 4", "Elements: numbers of the deformations",
        "Nodes: numbers of the coordinates", "Degrees of freedom: 5, of which 4 dynamic", "Condition number",
        "DYNAMICS", "TIMESTEP", "Numbers per class", "EM: distributed mass", "ESTIFF: stiffness of an element",
        "Total mass:", "FORWARD DYNAMICS", "Integrator: INTEGRAT -1, Adams predictor-corrector", "INITIAL STATE",
        "STEPS", "END", "The analysis is complete.",
    )  # fmt: skip


def test_numbering_and_classes(log_of, tmp_path):
    """The tables of the log repeat lnp and le of the result file."""
    log = log_of(1, "crank")
    with SbfFile(tmp_path / "crank.sbd") as file:
        lnp, le = np.asarray(file.header["lnp"]), np.asarray(file.header["le"])
    for row in rows_of(log, "node  type"):
        node, cells = int(row[0]), row[2:]
        assert [int(c) for c in cells[::2]] == [i for i in lnp[node - 1].tolist() if i]
    for row in rows_of(log, "element  type"):
        element, cells = int(row[0]), row[6:]
        assert [int(c) for c in cells[::2]] == [i for i in le[element - 1].tolist() if i]
    assert ["6", "position", "8", "C", "3", "O"] in rows_of(log, "node  type")
    assert ["2", "orientation", "10", "M"] in rows_of(log, "node  type")


def test_counts_mass_and_an_echo_without_comments(log_of):
    """Rod of 0.30 m with 0.2225 kg/m and the slider of 0.033375 kg: together 0.100125 kg."""
    log = log_of(1, "crank")
    assert "straight guide" not in log
    assert "\nINPUTX 2 1\n" in log
    assert "Total mass: 0.100125 kg" in log
    assert re.search(r"fixed +3 +6\n +calculable +6 +0\n +prescribed .* 1 +0\n", log)


def test_every_step_is_listed_with_its_counters(log_of):
    log = log_of(1, "crankfl", None, "--time", "0.001", "--steps", "5")
    rows = rows_of(log, "step ")
    assert [int(r[0]) for r in rows] == [1, 2, 3, 4, 5, 6]
    np.testing.assert_allclose([float(r[1]) for r in rows], np.linspace(0, 0.001, 6), rtol=1e-9)
    head = next(line for line in log.splitlines() if line.strip().startswith("step "))
    assert "internal steps" in head
    assert "iterations" in head
    assert all(int(r[2]) > 0 for r in rows[1:])


def test_outlevel_prints_transfer_functions(log_of):
    text = (DATA / "crank.dat").read_text().replace("FIX 1\n", "FIX 1\nOUTLEVEL 3 3\n")
    log = log_of(1, "levels", text, "--time", "0.001", "--steps", "1")
    assert log.count("first order transfer function of the coordinates") == 2
    assert log.count("second order transfer function of the deformations") == 2
    # dx of the slider for the crank angle: zero at the dead centre; of the pin: 0.15 m in y
    assert re.search(r"node 3 y +1\.500000000e-01\n", log)


def test_eigenvalues_with_frequencies_and_names(log_of):
    """The rotating mass-spring system: 24.7806 and 55.5511 rad/s, six digits of the manual (bibliography.md)."""
    log = log_of(7, "massspring")
    section = log[log.index("Eigenvalues of the state matrix") :]
    values = [line.split() for line in section.splitlines()[3:7]]
    moduli = np.array([float(v[3]) for v in values])
    np.testing.assert_allclose(moduli, [55.5511, 55.5511, 24.7806, 24.7806], rtol=1e-5)
    np.testing.assert_allclose([float(v[4]) for v in values], moduli / (2 * np.pi), rtol=1e-9)
    assert "d/dt " in section


@pytest.mark.parametrize(
    ("mode", "name", "sections", "number"),
    [
        # 9.94384680: reference/README of the examples
        (8, "column2", ("Load multipliers", "Buckling modes, Euclidean norm 1", "Directional nodal compliances"),
         "9.943846"),
        (9, "lever", ("INX: ", "OUTF: ", "stationary solution (ITERSTEP)", "The state space matrix A", "matrix D"),
         "-1.000000000e+03   -5.000000000e+00"),
        (0, "crank", ("CONFIGURATION", "DIAGNOSIS", "The analysis is complete."), ""),
    ],
)  # fmt: skip
def test_results_of_a_mode(log_of, mode, name, sections, number):
    log = log_of(mode, name)
    assert in_order(log, *sections)
    assert number in log[log.index(sections[0]) :]
    assert mode or "de/dt" not in log


def test_wrong_input_ends_the_log(call, tmp_path):
    (tmp_path / "bad.dat").write_text("PLTRUSS 1 1 2\nX 2 1. 0.\nFXI 1\nEND END\n")
    assert call("0", "bad").status == 2
    log = (tmp_path / "bad.log").read_text()
    assert "error: bad.dat:3: " in log
    assert "[input.unknown-keyword]" in log
    assert log.endswith("The input is wrong; nothing was analysed.\n")


@pytest.mark.parametrize("engine", [(), ("--general",)])
def test_prescribed_motions_list_the_iterations_of_their_positions(log_of, engine):
    """Modes 1, 2 and 3; the crank turns through 0.15 rad from step to step, the first position is given."""
    crank = rows_of(log_of(1, "crank", None, *engine), "step           time [s]  iterations")
    assert len(crank) == 101
    assert all(1 <= int(row[2]) <= 4 for row in crank[1:])
    for mode, name in ((2, "robotinv"), (3, "robotinvlin")):
        rows = rows_of(log_of(mode, name, None, *engine), "step           time [s]  iterations")
        assert len(rows) == 141
        assert all(0 <= int(row[2]) <= 4 for row in rows)
