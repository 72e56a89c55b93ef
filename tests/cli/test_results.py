"""The result files: every variable of reference/files.md sections 4 to 6, against mechanism and library."""

import hashlib

import numpy as np
import pytest
from spacar_formats.result_files import result_sinks, sbd_header
from spacar_formats.sbf import SbfFile
from spacar_formats.setpoint_files import find_setpoints

import spacar
from spacar.errors import UsageError
from spacar.frame import Frame
from spacar.inverse.nominal import check_same_mechanism
from tests.examples import DATA

SBD_HEADER = {
    "VERSION", "SOURCE", "SHA256", "ETYPE", "MODE", "NDOF", "NDDOF", "NKDOF", "NKDDOF", "NX", "NE",
    "NXP", "NEP", "LNP", "LE", "LN", "IT", "KDEF", "RXYZ", "RQ", "DR0", "RL0",
    "STIF", "EDAMP", "EM", "EINIT", "ESIG", "X0", "XM", "GRAV",
}  # fmt: skip
SBD_STEP = {"T", "X", "XD", "XDD", "FX", "FXGRAV", "FXT", "E", "ED", "EDD", "SIG"}


def flat(file: SbfFile, name: str) -> list[float]:
    return np.ravel(file.get(name)).tolist()


def test_all_variables_of_the_sbd(call, tmp_path):
    call("1", "crank")
    with SbfFile(tmp_path / "crank.sbd") as file:
        assert set(file.header_records) == SBD_HEADER
        assert set(file.step_records) == SBD_STEP
        assert flat(file, "nxp") == [3, 6, 1, 0, 0]
        assert flat(file, "nep") == [6, 0, 0, 0, 0]
        assert [flat(file, k) for k in ("ndof", "nddof", "nkdof", "nkddof")] == [[1], [0], [1], [0]]
        assert file.header["ETYPE"] == ["PLBEAM", "PLBEAM"]
        assert file.header["SOURCE"] == ["crank.dat"]
        assert file.header["SHA256"] == [hashlib.sha256((tmp_path / "crank.dat").read_bytes()).hexdigest()]
        assert np.asarray(file.header["IT"]).tolist() == [[5, 5]]
        np.testing.assert_allclose(np.ravel(file.header["RL0"]), [0.15, 0.30], rtol=1e-15)
        assert np.asarray(file.header["EM"])[1].tolist() == [0.2225] + [0] * 8


def test_the_file_holds_what_the_library_yields(call, tmp_path):
    """Bit for bit: storing must not change a number."""
    call("1", DATA / "crankfl.dat", "--output-dir", tmp_path, "--time", "0.001", "--steps", "3")
    frames = list(spacar.frames(1, DATA / "crankfl.dat", duration=0.001, n_steps=3))
    with SbfFile(tmp_path / "crankfl.sbd") as file:
        for name in ("x", "xd", "xdd", "e", "ed", "edd", "sig", "fx", "fxgrav"):
            np.testing.assert_array_equal(file.get(name), [getattr(f, name) for f in frames])
        np.testing.assert_array_equal(file.get("fxtot"), [f.fxtot for f in frames])


def test_element_tables():
    """A spatial deck with unused numbers: rows of elements that do not exist are zero."""
    text = """BEAM 2 1 2 3 4 0. 1. 0. 0.25
    BEAM 4 3 4 5 6 0. 1. 0.
    LDEFORM 4
    X 3 2. 0. 0.
    X 5 2. 3. 0.
    FIX 1
    FIX 2
    DYNE 2 2
    END HALT
    ESTIFF 2 1. 2. 3. 4. 5. 6.
    EDAMP 2 7. 8.
    ESIG 2 0. 9.
    STARTDE 2 2 0.125
    END END"""
    with pytest.raises(spacar.errors.InputError):
        spacar.parse_deck(text)  # y' of beam 4 is parallel to its axis
    deck = spacar.parse_deck(text.replace("5 6 0. 1. 0.", "5 6 1. 0. 0."))
    header = sbd_header(spacar.frames(1, deck))
    assert header["KDEF"].tolist() == [0, 1, 0, 0]
    assert header["RL0"].tolist() == [0, 2, 0, 3]
    assert header["DR0"][:, 0].tolist() == [0, 0.25, 0, 0]
    assert header["STIF"][1].tolist() == [1, 2, 3, 4, 5, 6]
    assert header["EDAMP"][1].tolist() == [7, 8, 0, 0, 0, 0]
    assert header["ESIG"][1].tolist() == [0, 9, 0, 0, 0, 0]
    assert header["EINIT"][1].tolist() == [0, 0.125, 0, 0, 0, 0]
    # rows x', y', z' one after the other: beam 4 runs along y with y' = x, so z' = -z
    np.testing.assert_allclose(header["RXYZ"][1].reshape(3, 3), np.eye(3), atol=1e-15)
    np.testing.assert_allclose(header["RXYZ"][3].reshape(3, 3), [[0, 1, 0], [1, 0, 0], [0, 0, -1]], atol=1e-15)
    assert not header["RXYZ"][[0, 2]].any()
    assert header["LN"].tolist() == [[0] * 4, [1, 2, 3, 4], [0] * 4, [3, 4, 5, 6]]


def test_transfer_functions_are_stored_when_asked_for(call, tmp_path):
    text = (DATA / "crank.dat").read_text().replace("FIX 1\n", "FIX 1\nOUTLEVEL 0 1\n")
    (tmp_path / "levels.dat").write_text(text)
    call("1", "levels")
    with SbfFile(tmp_path / "levels.sbd") as file:
        dx, lnp = file.get("dx", 1), np.asarray(file.header["lnp"])
        assert dx.shape == (10, 1)
        assert dx[lnp[2, 1] - 1, 0] == pytest.approx(0.15, rel=1e-12)  # pin of the crank: radius 0.15 m
        assert not file.has("d2x")


def test_matrices_and_state_space_files(call, tmp_path):
    call("9", DATA / "lever.dat", "--output-dir", tmp_path)
    with SbfFile(tmp_path / "lever.sbm") as file:
        assert {"NDDOF", "NDOF", "NKDDOF", "NKDOF", "NNOM"} <= set(file.header_records)
        assert {"T", "M0", "C0", "D0", "K0", "N0", "G0", "B0"} <= set(file.step_records)
    with SbfFile(tmp_path / "lever.ltv") as file:
        assert {"NNOM", "NX", "NU", "NY", "NRBM", "DFT"} <= set(file.header_records)
        assert [flat(file, k) for k in ("NX", "NU", "NY", "DFT")] == [[2], [1], [1], [1]]
        np.testing.assert_allclose(file.get("A"), [[0, 1], [-1000, -5]], rtol=1e-12)
        np.testing.assert_allclose(file.get("D"), [[-6000]], rtol=1e-12)


def frame_of(run, **more) -> Frame:
    n = run.mechanism.numbering
    x, e = np.zeros(n.nx), np.zeros(n.ne)
    return Frame(t=0.0, x=run.mechanism.x0, xd=x, xdd=x, e=e, ed=e, edd=e, sig=e, fx=x, fxgrav=x, fxtot=x, **more)


def write(run, stem, error=None, **more):
    with result_sinks(stem, run.mode.files) as sinks:
        for sink in sinks:
            sink.start(run)
            sink.frame(frame_of(run, **more))
            sink.finish(error)


def test_empty_matrices_are_not_produced(tmp_path):
    """Without inputs or outputs there is no B, C, D (input-language.md section 2)."""
    run = spacar.frames(9, DATA / "lever.dat")
    space = {"A": np.eye(2), "B": np.zeros((2, 0)), "C": np.zeros((0, 2)), "D": np.zeros((0, 0))}
    write(run, tmp_path / "lever", state_space=space)
    with SbfFile(tmp_path / "lever.ltv") as file:
        assert list(file.step_records) == ["T", "A"]


@pytest.fixture
def nominal(tmp_path):
    """A mode 2 result of the manipulator with one step."""
    write(spacar.frames(2, DATA / "robotinv.dat"), tmp_path / "robotinv")
    return tmp_path / "robotinvlin.dat"


def test_setpoints_are_found_by_the_longest_name(nominal):
    found = find_setpoints(nominal)
    assert found.name == "robotinv.sbd"
    check_same_mechanism(found, spacar.frames(3, DATA / "robotinvlin.dat").mechanism.numbering)
    with pytest.raises(UsageError, match="element 1 is PLBEAM with nodes 1 2 3 4 here, HINGE with nodes 1 2 there"):
        check_same_mechanism(found, spacar.frames(1, DATA / "crank.dat").mechanism.numbering)
    write(spacar.frames(2, DATA / "robotinv.dat"), nominal.with_name("robotinvl"))
    assert find_setpoints(nominal).name == "robotinvl.sbd"
    assert find_setpoints(nominal, str(nominal.with_name("robotinv"))).name == "robotinv.sbd"


def test_refused_setpoints_are_named_with_the_reason(tmp_path):
    write(spacar.frames(1, DATA / "crank.dat"), tmp_path / "robotinv")
    (tmp_path / "robot.sbd").write_bytes(b"not a result")
    with pytest.raises(UsageError) as error:
        find_setpoints(tmp_path / "robotinvlin.dat")
    text = str(error.value)
    assert error.value.code == "files.setpoints-not-found"
    assert "robotinv.sbd: it is a result of mode 1" in text
    assert "robot.sbd is damaged" in text
    assert "absent: robotinvli.sbd, robotinvl.sbd, robotin.sbd" in text


def test_an_incomplete_nominal_motion_is_refused(tmp_path):
    write(spacar.frames(2, DATA / "robotinv.dat"), tmp_path / "robotinv", error=KeyboardInterrupt())
    (tmp_path / "robotinv.sbd.part").rename(tmp_path / "robotinv.sbd")
    with pytest.raises(UsageError, match=r"robotinv\.sbd: it is incomplete"):
        find_setpoints(tmp_path / "robotinvlin.dat")
