"""Model files: the paper's example gives the script's motion; every row of the error table; the command line."""

# ruff: noqa: E501  (tables of input and message, one line each)

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from spacar.symbolic.model_reader import read_model
from tests.command_line import call as run

DATA = Path(__file__).parents[2] / "data" / "symbolic"
BASE = (DATA / "manipulator.toml").read_text()


@pytest.fixture
def model(tmp_path):
    """Write a model file, by default the example with some pieces replaced."""

    def write(*changes, text=BASE, name="manip.toml"):
        for old, new in changes:
            assert old in text, old
            text = text.replace(old, new, 1)
        path = tmp_path / name
        path.write_text(text)
        return path

    return write


@pytest.fixture(scope="module")
def both():
    """The model file and the script."""
    return [read_model(DATA / f"manipulator.{e}") for e in ("toml", "py")]


def test_toml_and_script_have_one_kinematics_and_one_set_of_values(both):
    """As vectors of the axes, without deriving anything: velocities of both tips, loads, numbers."""
    toml, script = both
    assert toml.values == script.values
    assert toml.start == script.start
    assert toml.system.speeds == script.system.speeds
    assert [str(b.tip.velocity) for b in toml.system.beams] == [str(b.tip.velocity) for b in script.system.beams]


@pytest.mark.slow
@pytest.mark.parametrize("n", [1, 2])
def test_toml_and_script_describe_one_machine(both, n):
    toml, script = both
    times = np.array([0.0, 0.1, 1.0])[: n + 1]
    runs = []
    for m in (toml, script):
        program = m.system.derive("recursive").program(m.outputs)
        runs.append(program.simulate(m.values, m.start, t_end=times[-1], at=times, rtol=1e-9))
    assert np.max(np.abs(runs[0].state - runs[1].state)) < 3e-8  # two runs at rtol 1e-9
    # R1 of symbolic.md 8.5
    assert runs[0]["q1"][1:] == pytest.approx([-0.43622494787, -0.26445050190][:n], abs=2e-8)
    assert runs[0]["tip1"][1:] == pytest.approx([-5.8480974598e-03, -5.8055951959e-03][:n], abs=2e-9)


def test_order_of_the_tables_is_free(model):
    head, *rest = BASE.split("[[frame]]")
    frames = ["[[frame]]" + r for r in rest]
    tail = frames[1][frames[1].index("[[torque]]") :]
    frames[1] = frames[1][: frames[1].index("[[torque]]")]
    path = model(text=head + frames[1] + frames[0] + tail)
    assert len(read_model(path).system.speeds) == 8
    path.write_text(f"\ufeff{path.read_text()}")  # the byte order mark of editors on Windows
    assert len(read_model(path).system.speeds) == 8


# -- errors: input, piece of the message ------------------------------------------------------------------------

TORQUE = "-D2*s4 - K2*(q4 - Q4)"
ERRORS = {
    "unknown name": ([(TORQUE, "-D2*s4 - K2*(qq4 - Q4)")], "[[torque]] 2 vector: unknown name 'qq4', did you mean 'q4'?"),
    "call": ([(TORQUE, "__import__('os').system('x')")], "\"__import__('os').system('x')\" is not allowed in an expression"),
    "attribute": ([(TORQUE, "q4.func")], '"q4.func" is not allowed in an expression'),
    "lambda": ([(TORQUE, "lambda: 1")], '"lambda: 1" is not allowed in an expression'),
    "word": ([(TORQUE, "-lambda*2")], "'lambda' cannot be a name in expressions: choose another one"),
    "syntax": ([(TORQUE, "(1")], "cannot read expression '(1' ('(' was never closed)"),
    "division": ([(TORQUE, "q4 + 1/0")], "division by zero in '1/0'"),
    "exponent": ([(TORQUE, "q4**1000000000")], "exponent 1000000000 is too large (at most 64)"),
    "too long": ([(TORQUE, "q4" + "+q4" * 700)], "is too long (at most 2000)"),
    "too deep": ([(TORQUE, "-" * 150 + "q4")], "nested deeper than 100"),
    "tower": ([(TORQUE, "((9**64)**64)**64")], "is too large"),
    "function": ([(TORQUE, "sinn(q4)")], "unknown function 'sinn', did you mean 'sin'?"),
    "missing key": ([('length = "L"\n', "")], "[[beam]] link1: key 'length' is missing (length [m])"),
    "unknown key": ([('damping = "gam"', 'dampng = "gam"')], "unknown key 'dampng', did you mean 'damping'?"),
    "unknown table": ([("[[torque]]", "[[torqe]]")], "unknown table 'torqe', did you mean 'torque'?"),
    "wrong type": ([("axis = 3", "axis = 3.5")], "key 'axis' must be 1, 2, 3 or a sequence such as \"321\", not 3.5"),
    "vector": ([('["0", "-g", "0"]', '["0", "-g"]')], "[system] gravity: must be a list of 3 expressions, not 2"),
    "frame": ([('parent = "link1.tip"', 'parent = "link9.tip"')], "[[frame]] B2: refers to ['link9.tip'], which is not defined"),
    "beam root": ([('root = "link1.tip"', 'root = "link9.tip"')], "[[beam]] link2: refers to ['link9.tip'], which is not defined"),
    "cycle": ([('parent = "N"', 'parent = "link2.tip"')], "in a cycle"),
    "reaction": ([('reaction = "N"', 'reaction = "M"')], "[[torque]] 1: reaction refers to ['M'], which is not defined"),
    "essential": ([('"x**2/L**4"', '"x/L"')], "field x/L does not satisfy u(0) = u'(0) = 0"),
    "parameter and coordinate": ([("rho = 2.6", "s4 = 1.0\nrho = 2.6")], "stands in [parameters] s4"),
    "only case": ([("gam = 0.4", "GAM = 1.0\ngam = 0.4")], "'GAM', which differs only in case, stands in [parameters] GAM"),
    "duplicate": ([('name = "link2"', 'name = "link1"')], "the same name stands in [[beam]] link1"),
    "not linear": (
        [("[simulate]", '[[constraint]]\nexpression = "s1*s4"\n\n[simulate]')],
        "[[constraint]] 1: constraint1: s1(t)*s4(t) = 0 is not linear in the speeds",
    ),
    "dependent": (
        [("[simulate]", '[[constraint]]\nexpression = "s1"\n[[constraint]]\nexpression = "2*s1"\n\n[simulate]')],
        "2 constraints have rank 1",
    ),
    "not finite": ([("rho = 2.612898", "rho = nan")], "parameter rho = nan is not finite"),
    "no value": ([("rho = 2.612898", 'rho = ""')], "parameter rho has no value"),
    "length": ([("L = 0.9144", "L = 0.0")], "parameter L = 0 is a length and must be > 0"),
    "mass": ([("rho = 2.612898", "rho = -1.0")], "parameter rho = -1 is a mass per length and must be >= 0"),
    "toml": ([("[system]", "[system")], "cannot read the file"),
    "output": ([('"link1.tip.u"', '"link1.tip.v"')], "is not allowed in an expression"),
    "tolerance": ([("rtol = 1e-8", "rtol = 0.1")], "at most 0.01"),
    # scripts
    "frames": ("from spacar.symbolic import *\nomega(ReferenceFrame('N'), ReferenceFrame('Q'))\n", "no angular velocity is known between frames N and Q"),
    "sum": ("from spacar.symbolic import *\nReferenceFrame('N')[1] + 1\n", "TypeError: cannot add a vector and 1"),
    "product": ("from spacar.symbolic import *\nN = ReferenceFrame('N')\nN[1]*N[2]\n", "TypeError: product of vectors: use dot (&), cross (^) or outer (|), not *"),
    "no system": ("x = 1\n", "the script must define `system`"),
}  # fmt: skip


DERIVED_FIRST = ("no value", "length", "mass")  # as "not finite", but each derives the equations again


@pytest.mark.parametrize("name", [pytest.param(n, marks=[pytest.mark.slow] * (n in DERIVED_FIRST)) for n in ERRORS])
def test_wrong_models_are_refused_in_one_line(model, name):
    changes, message = ERRORS[name]
    if script := isinstance(changes, str):
        err = run.refused("symbolic", "check", model(text=changes, name="manip.py"))
    else:
        err = run.refused("symbolic", "simulate", model(*changes))
    assert err.startswith("error: manip.py" if script else "error: manip.toml: ")
    assert message in err
    assert err.count("\n") == 1


MASSLESS = """[coordinates]
a = { speed = "u" }
[[frame]]
name = "A"
parent = "N"
axis = 3
angle = "a"
"""


def test_failure_while_running_is_status_1(model):
    err = run.refused("symbolic", "simulate", model(text=MASSLESS), status=1)
    assert "mass matrix is not positive definite at u" in err


# -- command line -----------------------------------------------------------------------------------------------


def test_check_says_what_the_model_contains(model):
    out = run.done("symbolic", "check", model()).out
    for piece in (
        "coordinates  8: q1, q4, phi1_1", "link2: u (bending, 3 shapes)", "2 forces and torques", "torque1 = -D1*s1",
    ):  # fmt: skip
        assert piece in out


def test_derive_in_three_notations_and_formats(model):
    path = model()
    out = run.done("symbolic", "derive", path).out
    assert "equation of s1:" in out
    assert "b12.b22" in out
    out = run.done("symbolic", "derive", path, "--notation", "transformed", "--format", "latex").out
    assert r"\begin{align*}" in out
    assert r"\hat" not in out
    record = json.loads(run.done("symbolic", "derive", path, "--strategy", "recursive", "--format", "json").out)
    assert record["operations"]["step"] < 450
    assert len(record["results"]) == 36 + 8 + 8 + 2


@pytest.mark.parametrize(
    ("words", "said"),
    [(("derive", "--strategy", "recursive", "--notation", "held"), "only the held strategy"),
     (("simulate", "--set", "zeta=1"), "zeta")],
)  # fmt: skip
def test_options_that_are_refused(model, words, said):
    assert said in run.refused("symbolic", words[0], model(), *words[1:])


@pytest.mark.parametrize("language", ["c", "latex", *(pytest.param(x, marks=pytest.mark.slow) for x in ("python", "fortran"))])
def test_export(model, tmp_path, language):
    target = tmp_path / "out.txt"
    out = run.done("symbolic", "export", model(), "--language", language, "-o", target).out
    assert "operations per step" in out
    assert "two-link flexible" in target.read_text()


def test_simulate_writes_log_result_and_figures(model, tmp_path):
    path = model()
    words = ("--time", "0.5", "--steps", "5", "--set", "g=0", "--set", "q4=0.5", "--plot", "all", "--equations")
    out = run.done("symbolic", "simulate", path, *words).out
    assert "largest real part" in out
    log = (tmp_path / "manip.log").read_text()
    for piece in ("g = 0", "operations per step", "equations in vector notation", "b12.b22", "[[torque]]"):
        assert piece in log
    assert sorted(p.name for p in tmp_path.glob("*.png")) == [f"manip-{n}.png" for n in ("q1", "q4", "tip1", "tip2")]
    out = run.done("getfrsbf", tmp_path / "manip.sbd", "q", "end").out
    assert float(out.split()[0]) == pytest.approx(0.12042788611, abs=1e-8)  # R0 at 0.5 s
    assert run.done("getfrsbf", tmp_path / "manip.sbd", "qname").out.split()[:2] == ["q1", "q4"]
    run.done("loadsbd", tmp_path / "manip.sbd")


# -- SymPy stays inside -----------------------------------------------------------------------------------------


def test_help_and_core_do_not_import_sympy():
    code = (
        "import sys, io\nfrom spacar_cli.main import main\nfrom spacar_cli.environment import Environment\n"
        "quiet = Environment(stdout=io.StringIO())\n"
        "main(['--help'], quiet); main(['symbolic', '--help'], quiet); main(['symbolic', 'simulate', '--help'], quiet)\n"
        "import spacar; spacar.run\n"
        "assert 'sympy' not in sys.modules"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_without_sympy_only_this_command_stops(model, tmp_path):
    crank = str(DATA.parent / "crank.dat")
    code = (
        "import sys\nfrom importlib.abc import MetaPathFinder\n"
        "import importlib.util as u\nfind = u.find_spec\nu.find_spec = lambda name, *a: None if name == 'sympy' else find(name, *a)\n"
        "sys.modules['sympy'] = None\nfrom spacar_cli.main import main\n"
        f"assert main(['keywords']) == 0\nassert main(['check', {crank!r}]) == 0\n"
        f"assert main(['1', {crank!r}, '--quiet', '--output-dir', {str(tmp_path)!r}]) == 0\nsys.exit(main(['symbolic', 'check', {str(model())!r}]))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 2
    assert done.stderr.strip() == 'error: spacar symbolic needs SymPy: pip install "spacar[symbolic]"'


@pytest.mark.slow
@pytest.mark.parametrize("strategy", ["held", "recursive"])
def test_texts_do_not_depend_on_hash_order(tmp_path, strategy):
    """Two processes with different seeds of the string hash write the same bytes."""
    texts = []
    for seed in ("1", "2"):
        target = tmp_path / f"{seed}.c"
        words = [
            "symbolic", "export", DATA / "manipulator.toml", "--language", "c", "--strategy", strategy, "-o", target,
        ]  # fmt: skip
        command = [sys.executable, "-m", "spacar_cli.main", *map(str, words)]
        done = subprocess.run(command, env=os.environ | {"PYTHONHASHSEED": seed}, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        texts.append(target.read_bytes())
    assert texts[0] == texts[1]
