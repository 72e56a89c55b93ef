"""With Octave's control package `getss` gives an `ss` object, of results of the program, of `mrltv`, of `spacntrl`."""

import shutil
import subprocess

import numpy as np
import pytest
from spacar_formats.getss import frequency_response, getss
from spacar_formats.mex import FOLDER

from tests.examples import DATA

from .models import SHORT_ROBOT, TRANSFER
from .octave import PROGRAM, analyse, need, run_octave

SCRIPT = """
pkg load control
sys = getss('transfer');
out.kind = class(sys);
[out.A, out.B, out.C, out.D] = ssdata(sys);
out.names = {sys.InputName, sys.OutputName, sys.StateName};
response = freqresp(sys, 2 * pi * [1.5 40]);
out.response = response;
out.poles = pole(sys);
out.single = squeeze(freqresp(sys(2, 1), 2 * pi * 1.5));
sys.InputName = {'force y', 'force z'};
out.renamed = sys.InputName;
out.reduced = getss(mrltv('robotinvlin', 2), 5).a;
out.closed = pole(getss(spacntrl('robotinvlin', @(step) 50 * eye(3)), 5));
out.open = pole(getss('robotinvlin', 5));
[out.a, out.b, out.c, out.d] = getss('transfer');
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    need("octave-cli")
    here = ["octave-cli", "--norc", "--quiet", "--eval", "pkg load control"]
    if subprocess.run(here, capture_output=True, check=False).returncode:
        pytest.skip("Octave's control package is not installed (Debian: octave-control)")
    made = tmp_path_factory.mktemp("control")
    (made / "robotinv.dat").write_text(SHORT_ROBOT)
    shutil.copy(DATA / "robotinvlin.dat", made)
    (made / "transfer.dat").write_text(TRANSFER)
    for mode, name in ((2, "robotinv"), (3, "robotinvlin"), (9, "transfer")):
        analyse(mode, made / f"{name}.dat")
    return made


@pytest.fixture(scope="module")
def octave(folder):
    return run_octave(f"setenv('SPACAR_COMMAND', '{PROGRAM}');" + SCRIPT, folder, FOLDER)


def test_it_is_an_ss_object_with_the_matrices_and_the_names(folder, octave):
    system = getss(folder / "transfer")
    assert octave["kind"] == "ss"
    for name, matrix in (("A", system.A), ("B", system.B), ("C", system.C), ("D", system.feedthrough)):
        np.testing.assert_array_equal(octave[name], matrix)
        np.testing.assert_array_equal(octave[name.lower()], matrix)
    assert [tuple(names) for names in octave["names"]] == [system.inputs, system.outputs, system.states]
    assert list(octave["renamed"]) == ["force y", "force z"]


def test_its_poles_and_responses_are_those_of_the_program(folder, octave):
    """TRANSFER is without damping: the poles are eigenvalues on the imaginary axis."""
    system = getss(folder / "transfer")
    expected = np.linalg.eigvals(system.A)
    np.testing.assert_allclose(np.sort(np.abs(octave["poles"])), np.sort(np.abs(expected)), rtol=1e-9)
    response = frequency_response(system, 2 * np.pi * np.array([1.5, 40.0]))
    found = np.moveaxis(octave["response"], 2, 0)
    np.testing.assert_allclose(found, response, rtol=1e-8, atol=1e-10 * np.abs(response).max())
    assert octave["single"] == pytest.approx(response[0, 1, 0], rel=1e-8)


def test_the_files_of_mrltv_and_spacntrl_are_systems_too(folder, octave):
    """Poles of the system with the controller are those of the file that `spacntrl` wrote."""
    np.testing.assert_array_equal(octave["reduced"], getss(folder / "robotinvlinmr", 5).A)
    assert octave["reduced"].shape == (4, 4)
    closed = np.linalg.eigvals(getss(folder / "robotinvlinkp", 5).A)
    np.testing.assert_allclose(np.sort(np.abs(octave["closed"])), np.sort(np.abs(closed)), rtol=1e-9)
    assert not np.allclose(np.sort(np.abs(octave["open"])), np.sort(np.abs(octave["closed"])))
