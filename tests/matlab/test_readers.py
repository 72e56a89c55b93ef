"""The readers of formats/spacar_formats/matlab/ in Octave, against those of Python: one Octave process for all."""

import shutil
import zlib
from pathlib import Path

import numpy as np
import pytest
from spacar_drawing.picture_source import open_source
from spacar_drawing.settings import SectionShape
from spacar_drawing.stresses import resultants, section_points, stress_field
from spacar_formats.getss import getss
from spacar_formats.loadsbd import loadsbd, loadsbm
from spacar_formats.mex import FOLDER
from spacar_formats.sbf import SbfFile, SbfWriter

from tests.examples import DATA

from .models import BENT, SHORT_ROBOT, TRANSFER, WARPED
from .octave import PROGRAM, analyse, need, run_octave

RESULTS = (
    "plbeam5.sbd", "bent.sbd", "bent.sbm", "robotinv.sbd", "robotinv.ltv", "robotinvlin.sbm", "robotinvlin.ltv",
    "transfer.ltv", "trike2.sbd", "warped.sbd",
)  # fmt: skip
LENGTHS = (4, 5, 31, 32, 33, 60, 64, 65, 1000, 4097)
SECTIONS = {"rect": "RECT", "circ": "CIRC", "recthol": "RECTHOL", "circhol": "CIRCHOL", "i": "I"}
DIMENSIONS = {
    "rect": (0.05, 0.0002), "circ": (0.004,), "recthol": (0.05, 0.03, 0.04, 0.026), "circhol": (0.02, 0.016),
    "i": (0.05, 0.03, 0.004, 0.005),
}  # fmt: skip
WARPING = (("RECT", (0.05, 0.0002)), ("RECT", (0.0002, 0.05)), ("I", (0.05, 0.03, 0.004, 0.005)), ("CIRC", (0.004,)))
SCRIPT = """
out.found = {};
for k = 1:numel(names)
  c = checksbf(names{k});
  if ~c.sound || ~strcmp(c.state, 'complete'), error('%s', names{k}); end
  values = {};
  for n = 1:numel(c.names), values{n} = getfrsbf(names{k}, lower(c.names{n})); end
  out.found{k} = values;
  out.names{k} = c.names;
end
out.tdef = getfrsbf('robotinv', 'TDEF');
out.time = getfrsbf('robotinv.sbd', 'time');
out.step7 = getfrsbf('robotinv.sbd', 'x', 7);
out.some = getfrsbf('robotinv.sbd', 'fxtot', [2 5 9]);
out.range = getfrsbf('robotinv.sbd', 'x', 3:2:11);
out.down = getfrsbf('robotinv.sbd', 'x', [9 2]);
calls = {@() getfrsbf('robotinv.sbd', 'nothing'), @() getfrsbf('robotinv.sbd', 'd2x'), ...
         @() getfrsbf('robotinv.sbd', 'x', 1000), @() getfrsbf('robotinv.sbd', 'lnp', 1), ...
         @() getfrsbf('absent', 'x'), @() getfrsbf('plbeam5.dat', 'x'), ...
         @() getss('robotinv'), @() stressbeam('robotinv', 1, 1, [], struct( ...
         'CrossSection', 'circ', 'Dimensions', 1)), ...
         @() stressbeam('bent', 1, 1, [], struct('CrossSection', 'oval', ...
         'Dimensions', 1)), @() loadsbm('robotinv'), @() spacar(1, 'nowhere')};
for k = 1:numel(calls)
  try, calls{k}(); catch e, out.texts{k} = [e.identifier, '|', e.message]; end
end
out.sbd = loadsbd('bent');
out.sbm = loadsbm('bent.sbm', 'k0', 'time');
loadsbm('bent');
out.assigned = m0;
sys = getss('robotinvlin', 3);
out.sys = sys;
[out.A, out.B, out.C, out.D] = getss('transfer.ltv');
shapes = {'rect', 'circ', 'recthol', 'circhol', 'i'};
dims = {[0.05 0.0002], 0.004, [0.05 0.03 0.04 0.026], [0.02 0.016], [0.05 0.03 0.004 0.005]};
for k = 1:5
  s = struct('CrossSection', shapes{k}, 'Dimensions', dims{k});
  [a, b, c, d] = stressbeam('bent.sbd', [2 1], 4, [], [s s]);
  out.stress{k} = a{1}; out.extrema{k} = d; out.y{k} = b(1).y;
  a = stressbeam('plbeam5', 3, 1, [], s);
  out.planar{k} = a{1};
  a = stressbeam('angled', 3, 1, [], s); out.angled{k} = a{1};
end
shapes = {'rect', 'rect', 'i', 'circ'}; dims = {[0.05 0.0002], [0.0002 0.05], [0.05 0.03 0.004 0.005], 0.004};
for k = 1:4
  for n = 1:2
    a = stressbeam('warped', n, 1, [], struct('CrossSection', shapes{k}, 'Dimensions', dims{k}));
    out.warping{k}{n} = a{1};
  end
end
s = struct('CrossSection', 'rect', 'Dimensions', [0.05 0.0002]);
[a, b] = stressbeam('warped', 1, 1, [], s); out.warped = a{1};
out.y_warped = b.y; out.z_warped = b.z;
a = stressbeam('warped', 1, 1, struct('warping', false), s); out.not_warped = a{1};
out.warped_lines = getfield(spavisual('warped'), 'Lines');
[a, b, c, out.outline] = stressbeam('bent.sbd', [2 1], 4, struct('exterior', true), s);
[a, b, c, out.empty] = stressbeam('bent.sbd', [], 1, [], []);
h = spavisual('bent');
h.Children.XLabel.String = 'x';
out.lines = h.Lines;
out.planar_lines = getfield(spavisual('plbeam5'), 'Lines');
addpath('pieces');
for k = 1:numel(lengths), out.crc(k) = sbf_crc32(uint8(mod((1:lengths(k)) * 37 + 11, 256))); end
out.words = {quoted_word('C:\\Program Files\\my model\\', true), quoted_word('\\\\host\\a b\\x.dat', true), ...
             quoted_word('it''s $HOME `a` "b"', false)};
lastwarn('', ''); v = getfrsbf('stopped.sbd', 'x'); [out.stopped, out.stopped_id] = lastwarn();
bytes = fread(fopen('robotinv.sbd', 'r'), [1, Inf], 'uint8=>uint8'); fclose('all');
fid = fopen('cut.sbd', 'w'); fwrite(fid, bytes(1:end - 20)); fclose(fid);
lastwarn('', ''); out.cut_steps = getfrsbf('cut.sbd', 'tdef'); out.cut = lastwarn();
c = checksbf('cut'); out.cut_damage = c.damage;
copyfile('one.sbd', 'changing.sbd');
out.before = getfrsbf('changing.sbd', 'x');
copyfile('two.sbd', 'changing.sbd');
out.after = getfrsbf('changing.sbd', 'x');
bytes = fread(fopen('one.sbd', 'r'), [1, Inf], 'uint8=>uint8'); fclose('all');
out.noticed = true(1, numel(bytes));
for k = 1:9:numel(bytes)
  changed = bytes; changed(k) = bitxor(changed(k), uint8(64));
  fid = fopen('changed.sbd', 'w'); fwrite(fid, changed); fclose(fid);
  try
    c = checksbf('changed.sbd'); out.noticed(k) = ~c.sound;
  catch e
    out.noticed(k) = strcmp(e.identifier, 'spacar:damaged');
  end
end
addpath('shims');
out.table = table([1; 2], {'x'; 'y'}, 'VariableNames', {'number', 'word'});
out.year = str2double(datestr(datetime, 'yyyy'));
try, datetime(2020, 1, 1); catch e, out.date = e.message; end
fault = struct('message', 'what happened', 'identifier', 'a:b', 'stack', struct('file', '', 'name', 'n', 'line', 1));
try, error(fault); catch e, out.thrown = [e.identifier, '|', e.message]; end
try, error('c:d', 'number %d', 5); catch e, out.passed = [e.identifier, '|', e.message]; end
warning('on', 'all'); warning backtrace on
out.remarks = warning('query', 'Octave:language-extension').state;
out.user = username();
out.lines_of_help = numel(strfind(help('spacar'), sprintf('\\n')));
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Results in a folder whose name has a blank, a quote and a letter beyond ASCII."""
    need("octave-cli")
    made = tmp_path_factory.mktemp("it's à folder")
    texts = {name: (DATA / f"{name}.dat").read_text() for name in ("plbeam5", "robotinvlin", "trike2")}
    texts |= {"robotinv": SHORT_ROBOT, "bent": BENT, "transfer": TRANSFER, "warped": WARPED}
    texts["angled"] = texts["plbeam5"].replace("END", "ADEFORM 3\nEND", 1)
    for name, text in texts.items():
        (made / f"{name}.dat").write_text(text)
    modes = {"robotinv": 2, "robotinvlin": 3, "transfer": 9, "bent": 10}  # the second needs the first
    for name in (*modes, *(texts.keys() - modes)):
        analyse(modes.get(name, 7), made / f"{name}.dat")
    for name, header in (("one", {"NX": 2}), ("two", {"NY": 1, "NX": 2})):
        with SbfWriter(made / f"{name}.sbd", "sbd", header, {"T": (1, 1), "X": (2, 1)}) as out:
            out.append({"T": 0.0, "X": [1.0, -2.5] if name == "one" else [7.0, 8.0]})
    stopped = SbfWriter(made / "stopped.sbd", "sbd", {"NX": 2}, {"T": (1, 1), "X": (2, 1)})
    stopped.append({"T": 0.0, "X": [1.0, -2.5]})
    stopped.close(complete=False)
    shutil.copytree(FOLDER / "octave", made / "shims")
    pieces = made / "pieces"
    pieces.mkdir()
    for name in ("sbf_crc32.m", "quoted_word.m"):
        shutil.copy(FOLDER / "private" / name, pieces)
    return made


@pytest.fixture(scope="module")
def octave(folder):
    names = ", ".join(f"'{name}'" for name in RESULTS)
    lengths = " ".join(map(str, LENGTHS))
    start = f"setenv('SPACAR_COMMAND', '{PROGRAM}'); names = {{{names}}}; lengths = [{lengths}];"
    return run_octave(start + SCRIPT, folder, FOLDER)


def same(got: object, value: np.ndarray | list[str]) -> bool:
    if isinstance(value, list):
        return [line.rstrip() for line in np.atleast_1d(got)] == [line.rstrip() for line in value]
    return np.array_equal(np.squeeze(np.asarray(got, float)), np.squeeze(value))


@pytest.mark.parametrize("name", RESULTS)
def test_every_variable_of_every_kind_of_result(folder, octave, name):
    """Exactly the bits of the Python reader, at all steps, in the same order."""
    k = RESULTS.index(name)
    with SbfFile(folder / name) as file:
        assert list(octave["names"][k]) == list(file.ids)
        for ident, got in zip(file.ids, octave["found"][k], strict=True):
            assert same(got, file.get(ident)), ident


def test_steps(folder, octave):
    with SbfFile(folder / "robotinv.sbd") as file:
        assert octave["tdef"] == file.steps == 12
        assert same(octave["time"], file.get("t"))
        assert same(octave["step7"], file.get("x", 7))
        assert same(octave["some"], file.get("fxt", [2, 5, 9]))
        assert same(octave["range"], file.get("x", [3, 5, 7, 9, 11]))
        assert same(octave["down"], file.get("x", [9, 2]))


def test_errors_say_what_callers_look_for(octave):
    expected = (
        ("spacar:id", "ID not found: nothing"), ("spacar:id", "0 2 (d2x, d2e)"), ("spacar:step", "has 12 steps"),
        ("spacar:step", "has one value"), ("spacar:notFound", "absent.sbd not found"),
        ("spacar:damaged", "is not a SPACAR binary file"), ("spacar:id", "mode 2 has no linearized"),
        ("spacar:element", "no beam"), ("spacar:section", "oval"), ("spacar:notFound", "robotinv.sbm not found"),
        ("spacar:input", "nowhere.dat: no such file"),
    )  # fmt: skip
    for text, (identifier, words) in zip(octave["texts"], expected, strict=True):
        assert text.startswith(f"{identifier}|"), text
        assert words in text


def test_all_variables_of_a_result(folder, octave):
    expected = loadsbd(folder / "bent")
    assert set(octave["sbd"]) == set(expected)
    assert all(same(octave["sbd"][k], list(v) if v.dtype.kind == "U" else v) for k, v in expected.items())
    matrices = loadsbm(folder / "bent")
    assert set(octave["sbm"]) == {"k0", "time"}
    assert same(octave["sbm"]["k0"], matrices["k0"])
    assert same(octave["assigned"], matrices["m0"])


def test_state_space(folder, octave):
    system = getss(folder / "robotinvlin", 3)
    for name in "ABC":
        assert same(octave["sys"][name.lower()], getattr(system, name))
    assert same(octave["sys"]["d"], system.feedthrough)
    assert tuple(octave["sys"]["InputName"]) == system.inputs
    assert tuple(octave["sys"]["OutputName"]) == system.outputs
    system = getss(folder / "transfer")
    for name in "ABC":
        assert same(octave[name], getattr(system, name))
    assert same(octave["D"], system.feedthrough)


def compare_stress(name: Path, section: SectionShape, element: int, step: int, found: np.ndarray) -> None:
    """Von Mises stresses at all points and places, to rounding; the points come in another order."""
    source = open_source(name)
    beam, sig, e = source.scene.elements[element - 1], source.get("sig", step), source.get("e", step)
    r = resultants(source.scene, beam, sig, e, 11)
    assert r is not None
    normal, shear = stress_field(section, r)
    expected = np.sort(np.sqrt(normal**2 + 3 * shear**2).T / 1e6, axis=0)
    assert found.shape == expected.shape
    np.testing.assert_allclose(np.sort(found, axis=0), expected, rtol=1e-11, atol=1e-11 * expected.max())


@pytest.mark.parametrize("shape", SECTIONS)
def test_stresses_are_those_of_the_pictures(folder, octave, shape):
    """The other program for the same formulas: the field of `spacar visual --stress`, to rounding."""
    k = list(SECTIONS).index(shape)
    section = SectionShape(SECTIONS[shape], DIMENSIONS[shape])
    for name, element, step, got in (("bent", 2, 4, "stress"), ("plbeam5", 3, 1, "planar"), ("angled", 3, 1, "angled")):
        compare_stress(folder / name, section, element, step, octave[got][k])
    np.testing.assert_allclose(np.sort(octave["y"][k]), np.sort(section_points(section)[0]), atol=1e-16)


def test_stress_of_a_bimoment(folder, octave):
    """A bar under torque, clamped with its warping at p: 36 |B|/(w t)^2 at the corners there, B = l0^2 sigma7
    (theory-warping.md section 5), about M sqrt(ECw/GIt) in so long a bar; nothing along the axes."""
    with SbfFile(folder / "warped.sbd") as file:
        sig, le = np.asarray(file.get("sig")).ravel(), np.asarray(file.header["LE"])
        B = float(np.ravel(file.header["RL0"])[0]) ** 2 * sig[le[0, 6] - 1]
    assert abs(B) == pytest.approx(0.001 * np.sqrt(1.458333e-6 / 0.0093098), rel=0.2)  # two elements
    y, z = octave["y_warped"], octave["z_warped"]
    corner = np.isclose(np.abs(y), 0.025) & np.isclose(np.abs(z), 0.0001)
    axes = (np.abs(y) < 1e-12) | (np.abs(z) < 1e-12)
    assert corner.sum() == 4
    expected = 36 * abs(B) / (0.05 * 0.0002) ** 2 / 1e6
    found, without = octave["warped"], octave["not_warped"]
    # Saint-Venant's stress vanishes there but for the rest of its series, of which this torque has a part
    assert (found[corner, 0] >= expected * (1 - 1e-12)).all()
    assert (found[corner, 0] < np.hypot(expected, without[corner, 0])).all()
    assert found[axes, 0].max() < 0.1 * without[axes, 0].max()  # most of the torque is warping there


@pytest.mark.parametrize("k", range(len(WARPING)), ids=["thin z", "thin y", "I", "circle"])
def test_stresses_of_warping_are_those_of_spacar_stress(folder, octave, k):
    """Bimoment, Saint-Venant's part of the torque and warping torque, in both elements at every point."""
    for element in (1, 2):
        compare_stress(folder / "warped", SectionShape(*WARPING[k]), element, 1, octave["warping"][k][element - 1])


def test_extremes_of_stress(octave):
    all_points, outline = octave["extrema"][0], octave["outline"]
    assert all_points["element"] in (1, 2)
    assert outline["max"] == all_points["max"]  # bending: the largest is at the outline
    assert outline["min"] >= all_points["min"] >= 0
    assert np.isnan(octave["empty"]["max"])


def test_lines_go_through_the_nodes(folder, octave):
    """Ends of the drawn elements are the nodes; the first beam leaves its clamp along the undeformed axis. A bar that
    turns and warps stays a straight line of two parts."""
    warped = octave["warped_lines"]
    assert np.isnan(warped[0]).sum() == 2
    np.testing.assert_allclose(np.nanmax(np.abs(warped), axis=1), [0.1, 0, 0], atol=1e-9)
    with SbfFile(folder / "bent.sbd") as file:
        x, lnp = np.asarray(file.get("x", 4)).ravel(), np.asarray(file.get("lnp"))
    lines = octave["lines"]
    parts = np.split(lines, np.flatnonzero(np.isnan(lines[0])), axis=1)
    first, second = parts[0], parts[1][:, 1:]
    for point, node in ((first[:, 0], 1), (first[:, -1], 7), (second[:, 0], 7), (second[:, -1], 4)):
        np.testing.assert_allclose(point, x[lnp[node - 1, :3] - 1], atol=1e-15)
    axis = np.array([0.05, 0.01, 0.0])
    s, slope = 1 / 12, first[:, 1] - first[:, 0]
    across = slope - axis * (slope @ axis) / (axis @ axis)
    assert np.linalg.norm(across) < 4 * s * np.linalg.norm(slope)
    assert np.nanmax(np.abs(octave["planar_lines"][2])) == 0


def test_checksums(octave):
    """Every ninth byte of a file; byte 13, the state, is under no checksum."""
    for length, crc in zip(LENGTHS, octave["crc"], strict=True):
        assert crc == zlib.crc32(bytes((37 * k + 11) % 256 for k in range(1, length + 1)))
    assert octave["noticed"][np.arange(len(octave["noticed"])) != 13].all()


def test_a_file_that_was_replaced_is_read_anew(octave):
    """The directory is kept between calls: another file under the same name has another one."""
    np.testing.assert_array_equal([octave["before"], octave["after"]], [[1.0, -2.5], [7.0, 8.0]])


def test_incomplete_results_are_told(octave):
    assert octave["stopped_id"] == "spacar:incomplete"
    assert octave["stopped"].endswith("stopped.sbd is incomplete: stopped after step 1")
    assert octave["cut_steps"] == 11
    assert octave["cut"].endswith("stopped after step 11")
    assert "it has 11 of the 12 steps" in octave["cut_damage"]


def test_names_reach_the_program_as_they_stand(octave):
    windows, share, posix = octave["words"]
    assert windows == '"C:\\Program Files\\my model\\\\"'
    assert share == '"\\\\host\\a b\\x.dat"'
    assert posix == "'it'\\''s $HOME `a` \"b\"'"


def test_what_octave_lacks(octave):
    """The sub-folder octave: as much of MATLAB as front-ends use, and what is not there is refused."""
    rows = [line.split() for line in octave["table"].splitlines()]
    assert rows == [["number", "word"], ["1", "x"], ["2", "y"]]
    assert octave["year"] > 2024
    assert "only the present time" in octave["date"]
    assert octave["thrown"] == "a:b|what happened"
    assert octave["passed"] == "c:d|number 5"
    assert octave["remarks"] == "off"
    assert np.size(octave["user"]) <= 1


def test_help(octave):
    assert octave["lines_of_help"] > 15
    for path in FOLDER.glob("*.m"):
        if path.stem != "Contents":
            second = path.read_text(encoding="utf-8").splitlines()[1]
            assert second.startswith(f"% {path.stem.upper()}  "), path
