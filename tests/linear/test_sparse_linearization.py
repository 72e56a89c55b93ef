"""Modes 4 and 9 of a large model: what is stored, and that every command which reads it gives what the dense one gives.

The dense matrices lose digits to the condition of the degrees of freedom squared (theory-system.md 6.7),
hence 1e-6 for low frequencies.
"""

import csv
import io
import json

import numpy as np
import pytest
from models import cantilever, spatial_chain
from spacar_cli.main import main
from spacar_formats.compliance import node_compliance
from spacar_formats.getss import getss
from spacar_formats.ltvfile import read_ltv
from spacar_formats.vibration import read_vibrations

import spacar
from spacar.errors import SpacarError, UsageError
from spacar.linear import form
from spacar.linearization import descriptor
from spacar.simulation.propagation import simulate_ltv
from spacar.simulation.reduction import reduce_modes
from spacar.simulation.time_varying import TimeVarying

BLOCK = "HALT\nINPUTF 1 {tip} 2\n{second}\nOUTX 1 {tip} 2\nOUTF 2 1 2\nOUTXDP 3 {tip} 1\nEND\nEND\n"
SWINGING = """PLRBEAM 1 1 2 3   PLBEAM 2 3 4 5 6   PLBEAM 3 5 6 7 8   X 3 1. 0.   X 5 1.7 0.2   X 7 2.4 0.1
INPUTX 1 1   FIX 1 2   DYNX 2   DYNX 4   DYNE 2 2 3   DYNE 3 2 3   END HALT
EM 1 2.   EM 2 0.7 0.01   EM 3 0.6 0.02   ESTIFF 2 0. 30.   ESTIFF 3 0. 20.   EDAMP 3 0. 0.4
GRAVITY 0. -9.81   STARTDX 2 1 3.   INPUTX 1 1 0.0 0.4 0.3   TIMESTEP 0.2 4   END
"""


ON_A_TABLE = ("FIX 1\n", "FIX 1 1\nINPUTX 1 2\n")  # the clamp is prescribed across the beam


def planar() -> str:
    text = cantilever(6, load="-1. -1.", dynamics=("TIMESTEP 1e-3 2",)).replace(*ON_A_TABLE, 1)
    return text.rsplit("END", 1)[0] + BLOCK.format(tip=13, second="INX 2 1 2")


def spatial() -> str:
    text = spatial_chain(4).replace("TIMESTEP 0.01 1", "TIMESTEP 1e-3 2").rsplit("END", 1)[0]
    return text + BLOCK.format(tip=9, second="INPUTF 2 7 3")


MODELS = {"planar": planar, "spatial": spatial, "swinging": lambda: SWINGING + BLOCK.format(tip=7, second="INXP 2 1 1")}


@pytest.fixture(scope="module", params=[(n, m) for n in MODELS for m in (4, 9) if (n, m) != ("swinging", 9)],
                ids=lambda p: f"{p[0]}-{p[1]}")  # fmt: skip
def both(request, tmp_path_factory):
    """(sparse, dense) results, run and saved once."""
    name, mode = request.param
    folder = tmp_path_factory.mktemp(f"{name}-{mode}")
    deck = spacar.parse_deck(MODELS[name](), mode=mode)
    dense = spacar.run(mode, deck, modes=0)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(form, "LARGE", 3)
        sparse = spacar.run(mode, deck)
    for result, where in ((sparse, "sparse"), (dense, "dense")):
        result.save(folder / where)
    assert "asp" in sparse.frames[0].state_space
    return sparse, dense, folder


@pytest.fixture
def pair(both, monkeypatch):
    """The results, while models are large from three unknowns on."""
    monkeypatch.setattr(form, "LARGE", 3)
    return both


def close(found, expected, tolerance=1e-8):
    np.testing.assert_allclose(found, expected, rtol=tolerance, atol=tolerance * np.abs(expected).max(initial=0.0))


def test_nothing_is_full_and_the_log_says_so(pair):
    sparse, _, folder = pair
    assert not {"A", "m0"} & (sparse.frames[0].state_space.keys() | sparse.frames[0].matrices.keys())
    assert "--modes N or MODES N" in (folder / "sparse.log").read_text()
    for name in ("sparse.ltv", "sparse.sbm", "sparse.sbd"):
        assert main(["checksbf", str(folder / name)]) == 0


def test_state_space_on_request(pair):
    sparse, dense, folder = pair
    for k in range(1, len(dense.frames) + 1):
        for ours, file, theirs in zip(sparse.ss(k), getss(folder / "sparse", k), dense.ss(k), strict=True):
            close(ours, theirs)
            close(file, ours, 1e-15)
    assert sparse.ss().states == getss(folder / "sparse").states == dense.ss().states


def test_frequencies(pair):
    _, _, folder = pair
    few = 3
    sparse = read_vibrations(folder / "sparse", few)[0]
    for ours, theirs in zip(sparse, read_vibrations(folder / "dense")[0], strict=True):
        close(np.sort(np.abs(ours.values)), np.sort(np.abs(theirs.values))[: 2 * few], 1e-6)
        size = np.abs(ours.values).max()
        damping = np.sort(theirs.values[-2 * few :].real)
        np.testing.assert_allclose(np.sort(ours.values.real), damping, rtol=1e-6, atol=1e-8 * size)


def test_lowest_modes_are_stored_when_they_are_asked_for(pair, monkeypatch):
    sparse, dense, _ = pair
    monkeypatch.setattr(form, "SHARE", 1)
    found = spacar.run(sparse.mode, sparse.mechanism.deck, modes=2)
    for k, pair_values in enumerate(found["eigval"]):
        ours = np.hypot(*pair_values.T)
        ours = np.sort(ours[np.isfinite(ours)])
        assert len(ours) >= 3
        close(ours, np.sort(np.abs(np.linalg.eigvals(dense.ss(k + 1).A)))[: len(ours)], 1e-6)
    q = found["eigvre"][-1] + 1j * found["eigvim"][-1]
    values = found["eigval"][-1] @ [1.0, 1.0j]
    q, values = q[:, np.isfinite(values)], values[np.isfinite(values)]
    n = len(q) // 2
    close(q[n:], q[:n] * values, 1e-6)
    A = dense.ss(-1).A
    close(A @ q, q * values, 1e-5)
    moved = (found["eigxre"][-1] + 1j * found["eigxim"][-1])[:, : q.shape[1]]
    numbering = found.mechanism.numbering
    close(moved[numbering.x_class["dynamic"]], q[: int(numbering.nxp[3])], 1e-6)


def test_bode(pair, capsys):
    _, _, folder = pair
    tables = []
    for name in ("sparse", "dense"):
        words = ["bode", str(folder / name), "--csv", "-", "--low", "0.01", "--high", "3", "--points", "20"]
        assert main(words) == 0
        rows = list(csv.reader(io.StringIO(capsys.readouterr().out)))
        tables.append({row[0]: np.array(row[1:], float) for row in rows[1:]})
    # Within 1e-4 of an undamped resonance rounding of the matrices is left in the response.
    largest = {frequency: np.abs(row[0::2]).max() for frequency, row in tables[1].items()}
    bound = 1e4 * np.median(list(largest.values()))
    common = [f for f in tables[0].keys() & tables[1].keys() if largest[f] < bound]
    assert len(common) >= 15
    for frequency in common:
        ours, theirs = (t[frequency] for t in tables)
        response, expected = (v[0::2] * np.exp(1j * np.radians(v[1::2])) for v in (ours, theirs))
        close(response, expected, 1e-6)


def test_compliance(pair):
    sparse, dense, folder = pair
    tip = sparse.mechanism.numbering.elements[-1][2][-2:]
    found = node_compliance(folder / "sparse", *tip)[0]
    deck = sparse.mechanism.deck
    full = spacar.run(sparse.mode, deck, modes=0, sbd_level=1) if sparse.mode == 4 else dense
    full.save(folder / "full")
    expected = node_compliance(folder / "full", *tip)[0]
    close(found.fixed, expected.fixed, 1e-7)


def test_time_varying_system(pair):
    sparse, dense, folder = pair
    systems = [TimeVarying.of(sparse), read_ltv(folder / "sparse")[0], TimeVarying.of(dense)]
    u = np.ones((len(dense.frames), 2))
    if len(dense.frames) > 1:
        ours, file, theirs = (simulate_ltv(s, u) for s in systems)
        close(ours.dy, theirs.dy, 1e-6)
        close(file.dy, theirs.dy, 1e-6)
    with pytest.raises(UsageError, match="--modes 0"):
        reduce_modes(systems[0], 2)


@pytest.fixture
def saved(monkeypatch, tmp_path):
    """A sparse result of mode 4, saved."""
    monkeypatch.setattr(form, "LARGE", 3)
    spacar.run(4, spacar.parse_deck(planar(), mode=4)).save(tmp_path / "sparse")
    return tmp_path / "sparse"


@pytest.mark.parametrize(
    ("another", "compliance", "vibrations"),
    [(False, r"ltv not found: .* run again", "no eigenvalues and no matrices"),
     (True, "different runs; run again", "different runs; run again")],
)  # fmt: skip
def test_without_the_file_of_the_equations_of_this_run(saved, another, compliance, vibrations):
    saved.with_suffix(".ltv").unlink()
    if another:
        spacar.run(4, spacar.parse_deck(planar(), mode=4), modes=0).save(saved.with_name("dense"))
        saved.with_name("dense.ltv").replace(saved.with_suffix(".ltv"))
    with pytest.raises(UsageError, match=compliance):
        node_compliance(saved, 13, 14)
    with pytest.raises(UsageError, match=vibrations):
        read_vibrations(saved)


def test_a_table_with_numbers_that_are_not_finite(saved):
    result = spacar.run(4, spacar.parse_deck(planar(), mode=4))
    result.frames[0].state_space["asp"][5, 2] = np.nan
    result.save(saved)
    with pytest.raises(SpacarError, match="the sparse system of step 1 has numbers that are not finite"):
        getss(saved)


def test_visual_and_eigen_commands(pair, capsys):
    sparse, _, folder = pair
    assert main(["eigen", str(folder / "sparse"), "--lowest", "2", "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)
    assert len(rows) == 2 * len(sparse.frames)
    assert main(["visual", str(folder / "sparse"), "--mode-number", "1", "-o", str(folder / "mode.png")]) == 0


def test_too_large_for_full_matrices(pair, monkeypatch):
    sparse, _, _ = pair
    monkeypatch.setattr(descriptor, "LARGEST_DENSE", 1e-9)
    with pytest.raises(UsageError, match="sparse form"):
        sparse.ss()


def test_a_run_without_input_and_output_signals(monkeypatch):
    monkeypatch.setattr(form, "LARGE", 3)
    text = cantilever(6, load="-1. -1.")
    result = spacar.run(9, spacar.parse_deck(text, mode=9))
    system = result.ss()
    assert system.B.shape == (24, 0)
    assert system.C.shape == (0, 24)


def test_degree_of_freedom_without_mass(monkeypatch):
    monkeypatch.setattr(form, "LARGE", 1)
    text = "PLTRUSS 1 1 2\nPLTRUSS 2 2 3\nX 2 1.\nX 3 2.\nFIX 1\nFIX 2 2\nFIX 3 2\nDYNX 2 1\nDYNX 3 1\nRLSE 1\nRLSE 2\n"
    text += "END\nHALT\nXM 2 1.\nESTIFF 1 5.\nESTIFF 2 5.\nEND\nHALT\nINPUTF 1 2 1\nEND\nEND\n"
    with pytest.raises(SpacarError, match="mass"):
        spacar.run(9, spacar.parse_deck(text, mode=9))


@pytest.mark.parametrize(
    ("signal", "acts"),
    [("INX 1 1 2", False), ("INXP 1 1 2", False), ("INXDP 1 1 2", True), ("INPUTF 1 13 2", True)],
)
def test_idle_inputs(signal, acts, monkeypatch):
    """Massive beams without dampers on a prescribed clamp: only its acceleration acts."""
    text = cantilever(6, load="-1. -1.").replace(*ON_A_TABLE, 1)
    text = text.rsplit("END", 1)[0] + f"HALT\n{signal}\nOUTX 1 13 2\nEND\nEND\n"
    monkeypatch.setattr(form, "LARGE", 3)
    told = [line for line in spacar.run(9, spacar.parse_deck(text, mode=9)).report if "column of B" in line]
    assert bool(told) is not acts
    assert all("write INXDP 1" in line for line in told)
