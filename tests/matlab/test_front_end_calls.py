"""The calls that a front-end makes, in its order, through the MEX file, in one Octave process.

Check of the constraints, statics and frequencies, buckling, transfer functions, linearization along a motion,
compliance, stresses, failures.
"""

import shutil

import numpy as np
import pytest
from spacar_cli.main import main
from spacar_formats.combsbd import combsbd
from spacar_formats.compliance import node_compliance
from spacar_formats.getfrsbf import getfrsbf
from spacar_formats.getss import getss
from spacar_formats.mex import build

from spacar.simulation.feedback import with_gain
from spacar.simulation.reduction import reduce_modes
from tests.examples import DATA

from .models import BENT, MASSLESS, SHORT_ROBOT, TRANSFER
from .octave import PROGRAM, need, run_octave

pytestmark = pytest.mark.slow
SCRIPT = """
out.kind = exist('spacar', 'file');
[~] = spacar(0, 'my bent');
nep = getfrsbf('my bent.sbd', 'nep'); nxp = getfrsbf('my bent.sbd', 'nxp'); D = getfrsbf('my bent.sbd', 'bigd', 1);
out.Dcc = D(1:(nep(1) + nep(3) + nep(4)), nxp(1) + (1:nxp(2)));
run = spacar(-10, 'my bent'); out.mode = run.mode;
x = getfrsbf('my bent.sbd', 'x'); fxt = getfrsbf('my bent.sbd', 'fxt'); lnp = getfrsbf('my bent.sbd', 'lnp');
dx = getfrsbf('my bent.sbd', 'dx'); nxp = getfrsbf('my bent.sbd', 'nxp'); nep = getfrsbf('my bent.sbd', 'nep');
nx = getfrsbf('my bent.sbd', 'nx');
K0 = getfrsbf('my bent.sbm', 'k0'); N0 = getfrsbf('my bent.sbm', 'n0'); G0 = getfrsbf('my bent.sbm', 'G0');
M0 = getfrsbf('my bent.sbm', 'm0');
n = sqrt(size(K0, 2));
dofs = [nxp(3) + (1:nxp(4)), nxp(3) + nxp(4) + nep(3) + (1:nep(4))];
for k = 1:getfrsbf('my bent.sbd', 'tdef')
  K = reshape(K0(k, :), n, n) + reshape(N0(k, :), n, n) + reshape(G0(k, :), n, n);
  out.frequencies(:, k) = sort(sqrt(eig(K, reshape(M0(k, :), n, n)))) / (2 * pi);
  out.multipliers(:, k) = sort(abs(eig(-reshape(K0(k, :), n, n), reshape(G0(k, :), n, n))));
  l = x(k, lnp(5, 1:4)); DX = reshape(dx(k, :), nx, []);
  DX = DX([lnp(4, 1:3), lnp(5, 1:4)], dofs);
  bar = [-l(2) l(1) -l(4) l(3); -l(3) l(4) l(1) -l(2); -l(4) -l(3) l(2) l(1)];
  T = blkdiag(eye(3), 2 * bar);
  out.compliance(:, :, k) = T * DX * (K \\ (DX' * T'));
  out.sums(k, :) = fxt(k, lnp(1, 1:3)) + fxt(k, lnp(4, 1:3)) + fxt(k, lnp(7, 1:3));
  [~, ~, ~, e] = stressbeam('my bent.sbd', [1 2], k, struct('exterior', true), ...
                            repmat(struct('CrossSection', 'rect', 'Dimensions', [0.05 0.0002]), 1, 2));
  out.stress(k) = e.max * 1e6;
end
h = spavisual('my bent'); h.Children.XLabel.String = 'x';
[~] = spacar(-9, 'transfer');
sys = getss('transfer');
sys.a(1, 1) = sys.a(1, 1) + 0;
sys.InputName{1} = 'force';
out.response = sys.c * ((2i * pi * 1.5 * eye(size(sys.a)) - sys.a) \\ sys.b) + sys.d;
[~] = spacar(2, 'robot');
[~] = spacar(-3, 'robot_3');
out.along = getfrsbf('robot_3.ltv', 'a', 5);
calls = {@() spacar(7, 'massless'), @() spacar(1, 'absent'), @() spacar(5, 'robot'), @() spacar(1), ...
         @() spacar(1, 'robot', 3), @() spacar('x', 'robot'), @() spacar(1, 7)};
for k = 1:numel(calls)
  try, calls{k}(); catch e, out.texts{k} = [e.identifier, '|', e.message]; end
end
repinsbf('robot_3.ltv', 'u0', -[1.5; 2.25; 1/3], 2);
out.replaced = getfrsbf('robot_3.ltv', 'u0', 1:3);
repinsbf('robot.sbd', 'source', 'a "b" \\ c');
out.source = getfrsbf('robot.sbd', 'source');
out.joined = combsbd('robot', 'robot.sbd', 'twice');
try, combsbd('robot', 'robot', 'twice'); catch e, out.exists = e.message; end
combsbd('robot', 'robot', 'robot', 'twice', '-force');
out.reduced = mrltv('robot_3', 2);
gains = @(step) diag([100 200 300]) + step * [0 1 2; 3 4 5; 6 7 8] * (step > 0);
out.controlled = spacntrl('robot_3', gains);
try, spacntrl('robot_3', @(step) 1); catch e, out.gain = e.message; end
spacar_build('built here');
out.built = {exist(fullfile('built here', 'spacar.mex'), 'file'), exist('octave_script.m', 'file'), ...
             numel(dir('built here'))};
home = getenv('HOME'); setenv('HOME', pwd());
out.home = getfrsbf('~/robot.sbd', 'tdef'); run = spacar(0, '~/transfer.dat'); out.home_nx = run.nx;
setenv('HOME', home);
spavisual('robot', 'picture.png');
setenv('SPACAR_COMMAND', '/nowhere/spacar');
try, spacar(0, 'robot'); catch e, out.nowhere = [e.identifier, '|', e.message]; end
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    need("octave-cli", "mkoctfile")
    made = tmp_path_factory.mktemp("it's à folder")
    (made / "robot.dat").write_text(SHORT_ROBOT)
    shutil.copy(DATA / "robotinvlin.dat", made / "robot_3.dat")
    for name, text in (("my bent", BENT), ("transfer", TRANSFER), ("massless", MASSLESS)):
        (made / f"{name}.dat").write_text(text)
    return made


@pytest.fixture(scope="module")
def octave(folder, monkeypatch_module):
    monkeypatch_module.setattr("sys.argv", [str(PROGRAM)])  # what spacar_command.txt names
    monkeypatch_module.delenv("SPACAR_COMMAND", raising=False)
    files = folder / "bridge here"
    assert [path.name for path in build(files)] == ["spacar.mex"]
    return run_octave(SCRIPT, folder, files)


@pytest.fixture(scope="module")
def monkeypatch_module():
    with pytest.MonkeyPatch.context() as patch:
        yield patch


def test_mex_files(folder, octave):
    """Octave builds one itself into a folder with a blank, from one with a quote, which its compiler does not take."""
    assert (octave["kind"], octave["mode"]) == (3, 10)
    assert (folder / "bridge here" / "spacar_command.txt").read_text() == f"{PROGRAM}\n"
    assert octave["built"][0] in (2, 3)
    assert tuple(octave["built"][1:]) == (2, 3)  # with . and ..


def test_constraints(octave):
    """Exactly constrained: the part of the difference matrix that is inverted is square and regular."""
    Dcc = octave["Dcc"]
    assert Dcc.shape[0] == Dcc.shape[1]
    assert np.linalg.matrix_rank(Dcc) == len(Dcc)


def test_frequencies_and_multipliers_are_those_of_the_program(folder, octave):
    for k in range(4):
        value = np.asarray(getfrsbf(folder / "my bent.sbm", "eigval", k + 1)).reshape(-1, 2, order="F")
        expected = np.sort(value[value[:, 1] > 0, 1]) / (2 * np.pi)
        np.testing.assert_allclose(octave["frequencies"][:, k].real, expected, rtol=1e-8)
        assert np.abs(np.imag(octave["frequencies"][:, k])).max() == 0
        found = np.sort(np.abs(np.ravel(np.asarray(getfrsbf(folder / "my bent.sbm", "lmult", k + 1)))))
        finite = np.isfinite(found) & (found < 1e6)
        np.testing.assert_allclose(octave["multipliers"][: finite.sum(), k], found[finite], rtol=1e-6)


def test_compliance_is_that_of_the_program(folder, octave):
    for k in range(4):
        expected = node_compliance(folder / "my bent", 4, 5, k + 1)[0].fixed
        largest = np.abs(expected).max()
        np.testing.assert_allclose(octave["compliance"][:, :, k], expected, rtol=1e-9, atol=1e-9 * largest)


def test_statics(octave):
    """Loads and reactions together are zero at every step (force, gravity of beams and mass); the stress grows with the
    load from step 1, where there is only gravity."""
    np.testing.assert_allclose(octave["sums"], 0, atol=1e-9)
    assert (np.diff(octave["stress"]) > 0).all()


def test_transfer_function(folder, octave):
    system = getss(folder / "transfer")
    s = 2j * np.pi * 1.5
    expected = system.C @ np.linalg.solve(s * np.eye(len(system.A)) - system.A, system.B) + system.feedthrough
    np.testing.assert_allclose(octave["response"], expected, rtol=1e-9)


def test_linearization_along_a_motion_finds_its_set_points(folder, octave):
    assert octave["along"].shape == (6, 6)
    np.testing.assert_array_equal(octave["along"], getfrsbf(folder / "robot_3.ltv", "A", 5))


def test_errors_have_the_texts_that_callers_compare(octave):
    texts = octave["texts"]
    for text, start, part in (
        (texts[0], "spacar:singularMass|ERROR in subroutine SOLDYN: Singular mass matrix", ""),
        (texts[1], "spacar:input|", "absent.dat"),
        (texts[2], "spacar:input|", "mode"),
        (texts[3], "spacar:arguments|SPACAR requires 2 or 3 input arguments", ""),
        (texts[4], "", "CCONST"),
        (texts[5], "spacar:arguments|MODE has an invalid value", ""),
        (texts[6], "spacar:arguments|FILENAME must be a text", ""),
        (octave["nowhere"], "spacar:command|", "SPACAR_COMMAND"),
    ):
        assert text.startswith(start) if part else text == start
        assert part in text
    assert "a degree of freedom carries no mass" in octave["printed"]


def test_values_are_replaced_and_results_joined(folder, octave, tmp_path):
    np.testing.assert_array_equal(octave["replaced"][1], [-1.5, -2.25, -1 / 3])
    assert octave["source"] == 'a "b" \\ c'
    assert octave["joined"] == 24
    assert "exists" in octave["exists"]
    combsbd([folder / "robot"] * 3, tmp_path / "twice")
    assert (folder / "twice.sbd").read_bytes() == (tmp_path / "twice.sbd").read_bytes()


def test_reduction_and_controller(folder, octave):
    from spacar_formats.ltvfile import read_ltv

    data, _ = read_ltv(folder / "robot_3")
    reduced, _ = read_ltv(folder / "robot_3mr.ltv")
    assert octave["reduced"] == str(folder / "robot_3mr.ltv")
    np.testing.assert_array_equal(reduced.A, reduce_modes(data, 2, None).system.A)
    gains = np.array([np.diag([100.0, 200, 300]) + k * np.arange(9.0).reshape(3, 3) for k in range(1, 13)])
    controlled, _ = read_ltv(folder / "robot_3kp.ltv")
    np.testing.assert_array_equal(controlled.k0b, with_gain(data, gains, None).k0b)
    assert "KP is 1 x 1, 3 x 3 is needed" in octave["gain"]


def test_a_table_of_gains_has_the_right_size(folder, octave, tmp_path, capsys):
    table = tmp_path / "gains.csv"
    for text, message in (("1,2,3\n", "12 (or 1) of 9 are needed"), ("a,b\n", ""), (None, "")):
        table.unlink() if text is None else table.write_text(text)
        assert main(["spacntrl", str(folder / "robot_3"), "--kp", str(table)]) == 2
        assert message in capsys.readouterr().err


def test_the_home_folder_and_a_picture_of_the_program(folder, octave):
    assert octave["home"] == 12
    assert octave["home_nx"] > 0
    assert (folder / "picture.png").read_bytes().startswith(b"\x89PNG")
