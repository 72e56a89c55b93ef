"""Generated Python, C and Fortran: compiled without warning, equal to each other, legal and unique names."""

import ctypes
import re
import shutil
import subprocess

import numpy as np
import pytest
import sympy as sp

from spacar.errors import AnalysisError, UsageError
from spacar.symbolic import MultibodySystem
from spacar.symbolic.compiled_program import CompiledFunction, compiler
from spacar.symbolic.emit.scalars import CText, FortranText, PythonText, Writer

from .systems import links

COMPILERS = {
    "c": ("gcc", ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror"], ".c"),
    "fortran": ("gfortran", ["-std=f2008", "-Wall", "-Werror"], ".f90"),
}


def build(language, text, folder, *more):
    """The library; it compiles without a word, unless `more` options ask for some."""
    program, flags, ending = COMPILERS[language]
    if shutil.which(program) is None:
        pytest.skip(f"{program} is not installed: the generated {language} cannot be compiled here")
    source, library = folder / f"equations{ending}", folder / f"{language}.so"
    source.write_text(text)
    command = [program, *flags, *more, "-O1", "-shared", "-fPIC", "-o", str(library), str(source), "-lm"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert more or done.stderr == ""
    return ctypes.CDLL(str(library))


def call_accel(library, *arrays):
    library.accel(*(a.ctypes.data_as(ctypes.c_void_p) for a in arrays))


def random_state(seed=1):
    rng = np.random.default_rng(seed)
    return rng.normal(size=16) * np.array([1, 1] + [1e-3] * 6 + [1] * 2 + [1e-2] * 6), rng.normal(size=2)


@pytest.mark.parametrize(
    ("language", "strategy"),
    [
        ("fortran", "recursive"),
        *(pytest.param(*c, marks=pytest.mark.slow) for c in (("c", "held"), ("c", "recursive"), ("fortran", "held"))),
    ],
)
def test_compiled_programs_equal_python(programs, arm, tmp_path, strategy, language):
    """1e-13 of the largest entry: the three texts ask for the same operations."""
    program, values = programs(strategy), arm().values
    library = build(language, program.text(language), tmp_path)
    parameters = np.array([values[s.name] for s in program.parameters])
    python = program.function(values, jacobian=False)
    for seed in range(5):
        y, u = random_state(seed)
        M, f = np.zeros((8, 8)), np.zeros(8)
        call_accel(library, parameters, y, u, M, f)
        upper, rhs = python.accel(y.tolist(), u.tolist())
        assert np.max(np.abs(M[np.triu_indices(8)] - upper)) < 1e-13 * np.max(np.abs(upper))
        assert np.max(np.abs(M - M.T)) == 0
        assert np.max(np.abs(f - rhs)) < 1e-13 * np.max(np.abs(rhs))


def test_float_program_equals_many_digits(programs, arm):
    """Python numbers against the 40-digit evaluation: the program loses at most three digits."""
    program, values = programs("recursive"), arm().values
    y, u = random_state()
    named = values | {s.name: x for s, x in zip(program.state, y, strict=True)} | {"Ta1": u[0], "Ta2": u[1]}
    exact = program.evaluate(named, 40)
    upper, rhs = program.function(values).accel(y.tolist(), u.tolist())
    M = np.array(exact["mass"], dtype=float)[np.triu_indices(8)]
    assert np.max(np.abs(M - upper)) < 1e-13 * np.max(np.abs(M))
    f = np.array(exact["rhs"], dtype=float).ravel()
    assert np.max(np.abs(f - rhs)) < 1e-13 * np.max(np.abs(f))


def test_exact_jacobian_against_differences(programs, arm):
    """Central differences of the same program in floats: 1e-4 of each column is their noise (cond I = 6e6)."""
    f = programs("recursive").function(arm().values)
    y, _ = random_state(3)
    J = f.jac(0.0, y.tolist())
    for j in range(16):
        h = 1e-6 * max(abs(y[j]), 1e-2)
        e = np.zeros(16)
        e[j] = h
        difference = (np.array(f(0.0, (y + e).tolist())) - np.array(f(0.0, (y - e).tolist()))) / (2 * h)
        assert np.max(np.abs(J[:, j] - difference)) < 1e-4 * np.max(np.abs(difference))


def test_jacobian_against_many_digits(programs):
    """∂g/∂q1 of the 60-digit evaluation by a difference of 1e-25: agrees to 1e-20, so the chain rule is exact."""
    program = programs("recursive")
    J = program.jacobian
    values = {s.name: 0.5 + 0.01 * k for k, s in enumerate([*program.parameters, *program.state])}
    accelerations = {s: sp.Float(0.3 + 0.1 * k, 70) for k, s in enumerate(program.accelerations)}

    def g(shift):
        moved = dict(values)
        moved["phi1_2"] = sp.Float(values["phi1_2"], 70) + shift
        numbers = program.evaluate(moved, 60)
        a = sp.Matrix(list(accelerations.values()))
        return numbers["rhs"] - numbers["mass"] * a

    h = sp.Float("1e-25", 70)
    difference = (g(h) - g(-h)) / (2 * h)
    known = {s: sp.Float(values[s.name], 70) for s in [*program.parameters, *program.state]} | accelerations
    for s, e in program.inputs.items():
        known[s] = e.xreplace(known)
    for s, e in [*J.once, *J.step]:
        known[s] = sp.N(e.xreplace(known), 60)
    column = [s.name for s in program.state].index("phi1_2")
    exact = [sp.N(J.dg[i, column].xreplace(known), 60) for i in range(8)]
    assert max(abs(x - d) for x, d in zip(exact, difference, strict=True)) < 1e-20 * max(abs(x) for x in exact)


@pytest.mark.skipif(compiler() is None, reason="no C compiler")
def test_compiled_function_serves_the_simulation(programs, arm):
    """rhs, Jacobian, inputs and outputs in C equal the Python ones; 1e-9 is the condition number times rounding."""
    program, values = programs("recursive"), arm().values
    f, g = program.function(values), CompiledFunction(program, values)
    y, _ = random_state(7)
    a, b = np.array(f(0.0, y.tolist())), g(0.0, y)
    assert np.max(np.abs(a - b)) < 1e-9 * np.max(np.abs(a))
    assert np.max(np.abs(f.jac(0.0, y.tolist()) - g.jac(0.0, y))) < 1e-8 * np.max(np.abs(g.jac(0.0, y)))
    assert g.outputs(0.0, y) == pytest.approx(f.outputs(0.0, y.tolist()), rel=1e-13)
    assert g.inputs(0.0, y) == pytest.approx(f.inputs(0.0, y.tolist()), rel=1e-13)


@pytest.mark.parametrize("language", ["python", "c", "fortran", "latex"])
def test_every_file_describes_itself(programs, language):
    program = programs("recursive")
    text = program.text(language)
    for word in ("spacar", program.digest, "units: SI", "phi2_3", "operations: "):
        assert word in text
    if language == "fortran":
        assert max(map(len, text.splitlines())) <= 132


def test_names_differ_in_more_than_case(programs):
    """q1 and Q1, Z and z: in no routine two names are equal without case."""
    for strategy in ("held", "recursive"):
        text = programs(strategy).text("fortran")
        for routine in re.split(r"end (?:subroutine|function)", text):
            declared = re.findall(r"real\(dp\) :: (.*)", routine)
            names = [n.strip().split("(")[0].lower() for line in declared for n in re.split(r",(?![^(]*\))", line)]
            assert len(names) == len(set(names))


@pytest.mark.parametrize("language", [PythonText, CText, FortranText])
def test_scalars_are_written_as_they_are_meant(language):
    x, y, do, Sin = sp.symbols("x z do Sin", real=True)
    w = Writer(language, [x, y, do, Sin])
    assert w.names[do] != "do" or language is PythonText
    assert w.names[Sin].lower() != "sin"
    text = w(x**2 / 3 - y ** sp.Rational(1, 2) / (x + y) ** 3)
    assert "1/3" not in text
    if language is PythonText:
        scope = {"x": 1.3, "z": 0.4, "sqrt": np.sqrt}
        assert eval(text, scope) == pytest.approx(1.3**2 / 3 - 0.4**0.5 / 1.7**3, rel=1e-15)
    with pytest.raises(UsageError, match="cannot write"):
        w(sp.gamma(x))


def test_massless_chain_names_its_coordinate():
    """A pivot that is not positive ends the run with the speed's name."""
    S = MultibodySystem()
    q, _ = S.coordinate("q", speed="s")
    r, _ = S.coordinate("r", speed="v")
    m, L = S.parameters("m L")
    A = S.frame("A", S.N, 3, q)
    S.frame("B", A, 3, r)
    S.particle("P", S.point("P", S.O, L * A[1]), m)
    with pytest.raises(AnalysisError, match="mass matrix is not positive definite at v"):
        S.derive("recursive").program().simulate({"m": 1.0, "L": 1.0}, {}, t_end=1.0)


def test_unknown_language_and_missing_jacobian(programs):
    with pytest.raises(UsageError, match="choose one of python"):
        programs("recursive").text("cobol")
    with pytest.raises(UsageError, match="Jacobian"):
        programs("recursive").text("latex", jacobian=True)


@pytest.mark.skipif(not compiler(), reason="no C compiler")
def test_a_call_of_the_compiled_right_hand_side_takes_what_python_takes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Lists, tuples, slices with steps; the same numbers with and without the headers of Python; errors in words."""
    values = {"g": 9.81, "m": 1.3, "L": 0.4, "J": 0.02}
    program = links(2)[0].derive("recursive").program()
    direct = CompiledFunction(program, values)
    monkeypatch.setattr("spacar.symbolic.compiled_program.compiler_options", lambda: None)
    by_ctypes = CompiledFunction(program, values)
    y = np.random.default_rng(3).uniform(-0.1, 0.1, len(program.state))
    expected = program.function(values)(0.2, y.tolist())
    spread = np.zeros(2 * len(y))
    spread[::2] = y
    for given in (y, y.tolist(), tuple(y), spread[::2], y.astype(np.float32).astype(float)[...]):
        for function in (direct, by_ctypes):
            rates = function(0.2, given)
            assert rates.shape == y.shape
            assert rates.dtype == float
        np.testing.assert_array_equal(direct(0.2, given), by_ctypes(0.2, given))
    np.testing.assert_allclose(direct(0.2, y), expected, rtol=1e-9)
    first = direct(0.2, y)
    direct(0.3, 2 * y)
    np.testing.assert_array_equal(first, direct(0.2, y))  # every call gives an array of its own
    with pytest.raises(ValueError, match="y has 3 numbers, the system has"):
        direct(0.0, [1.0, 2.0, 3.0])
