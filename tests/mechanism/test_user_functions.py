"""USERSIG and USERINP: what they are given, what they may return, and every way in which they can be wrong."""

import os
import sys
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import spacar
from spacar.errors import AnalysisError, InputError

OSCILLATOR = """
PLTRUSS 3 1 2   PLTOR 5 3 4   X 2 1.0 0.0   FIX 1   FIX 2 2   FIX 3   DYNE 3 1   {classes}
END HALT
XM 2 2.0   XM 4 1.0   {dynamics}   TIMESTEP 1.0 10   ERROR 1e-10 1e-10   END END
"""


def model(folder: Path, dynamics: str, function: str, classes: str = "INPUTE 5 1") -> Path:
    path = folder / "model.dat"
    path.write_text(OSCILLATOR.format(dynamics=dynamics, classes=classes))
    if function:
        (folder / "myfun.py").write_text(function)
    return path


def failure(path: Path, kind: type[Exception] = AnalysisError) -> str:
    """Text of the error, which must come without a RuntimeWarning."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(kind) as caught:
            spacar.run(1, path)
    return str(caught.value)


# -- stresses and forces -------------------------------------------------------------------------------------------
SPRING = """
def myfun(t, ne, le, e, ep, nx, lnp, x, xp):
    i = le[2, 0]
    assert lnp[0, 2] == -1 and lnp[1, 0] >= 0 and len(e) == ne and len(x) == nx
    return t, [[3, 1, 8.0 * e[i] + 0.4 * ep[i], 8.0, 0.4]], [[2, 1, 3.0]]
"""


def test_usersig_as_spring_damper_and_force(tmp_path: Path) -> None:
    """m x'' + d x' + k x = F: the same as ESTIFF, EDAMP and XF, to the tolerance of the integration."""
    user = spacar.run(1, model(tmp_path, "USERSIG myfun\nSTARTDE 3 1 0.1 0.0", SPRING))
    same = tmp_path / "same"
    same.mkdir()
    builtin = spacar.run(1, model(same, "ESTIFF 3 8.0\nEDAMP 3 0.4\nXF 2 3.0 0.0\nSTARTDE 3 1 0.1 0.0", ""))
    np.testing.assert_allclose(user.node(2, 1), builtin.node(2, 1), atol=1e-9)
    np.testing.assert_allclose(user.element(3, 1, "sig"), builtin.element(3, 1, "sig"), atol=1e-8)
    np.testing.assert_allclose(user["fx"], builtin["fx"], atol=0)


def test_usersig_stiffness_columns_enter_the_linearization(tmp_path: Path) -> None:
    path = model(tmp_path, "USERSIG myfun", SPRING)
    r = spacar.run(7, path)
    n = r.mechanism.numbering
    k = n.q_names.index("element 3 (PLTRUSS) e1 elongation") - len(n.rheonomic)
    assert r["k0"][0][k, k] == pytest.approx(8.0, rel=1e-12)
    assert r["d0"][0][k, k] == pytest.approx(0.4, rel=1e-12)


LIGHT = "ESTIFF 3 8.0\nSTARTDE 3 1 0.1 0.0"
USUAL = {  # what is returned behind t, what else the model has, its path, tolerances
    "None": ("None, None", LIGHT, lambda t: 1 + 0.1 * np.cos(2 * t), {"atol": 1e-8}),
    "empty lists": ("[], []", LIGHT, lambda t: 1 + 0.1 * np.cos(2 * t), {"atol": 1e-8}),
    "empty arrays": ("(), __import__('numpy').zeros((0, 3))", LIGHT, lambda t: 1 + 0.1 * np.cos(2 * t), {"atol": 1e-8}),
    "a single row": ("None, [2, 1, 4.0]", "", lambda t: 1 + t**2, {"rtol": 1e-9, "atol": 0}),
    # Multipliers are what they must be; a stress added there changes nothing (theory-system.md 2.1).
    "a fixed deformation": ("[[5, 1, 100.0]], []", "", np.ones_like, {"atol": 1e-15}),
    # Constant force from t = 1/3: the variable step code passes the jump with reduced steps: ten times the tolerance.
    "a jump": ("None, [[2, 1, 4.0 if t >= 1 / 3 else 0.0]]", "",
               lambda t: 1 + np.where(t > 1 / 3, (t - 1 / 3) ** 2, 0.0), {"atol": 1e-8}),
}  # fmt: skip


@pytest.mark.parametrize("name", USUAL)
def test_what_usersig_may_return(tmp_path: Path, name: str) -> None:
    result, more, expected, tolerances = USUAL[name]
    body = f"def myfun(t, ne, le, e, ep, nx, lnp, x, xp):\n    return t, {result}\n"
    r = spacar.run(1, model(tmp_path, f"USERSIG myfun\n{more}", body))
    np.testing.assert_allclose(r.node(2, 1), expected(r.t), **({"rtol": 0} | tolerances))
    if name == "a fixed deformation":
        np.testing.assert_allclose(r["sig"], 0.0, atol=1e-15)


# -- prescribed motion ---------------------------------------------------------------------------------------------
SINE = """
import math
def myfun(t, step):
    assert step == int(step)
    return t, [[5, 1, math.sin(3 * t), 3 * math.cos(3 * t), -9 * math.sin(3 * t)]], None
"""


def test_userinp(tmp_path: Path) -> None:
    r = spacar.run(1, model(tmp_path, "USERINP myfun", SINE))
    np.testing.assert_allclose(r.node(4, 1), np.sin(3 * r.t), atol=1e-14)
    np.testing.assert_allclose(r.node(4, 1, "xd"), 3 * np.cos(3 * r.t), atol=1e-13)
    # J = 1 on node 4: the driving stress is -J phi''
    np.testing.assert_allclose(r.element(5, 1, "sig"), 9 * np.sin(3 * r.t), atol=1e-12)


def test_inputs_that_userinp_does_not_mention_follow_their_statement(tmp_path: Path) -> None:
    body = "def myfun(t, step):\n    return t, None, None\n"
    r = spacar.run(1, model(tmp_path, "USERINP myfun\nINPUTE 5 1 0.1 2.0 0.5", body))
    np.testing.assert_allclose(r.node(4, 1), 0.1 + 2 * r.t + 0.25 * r.t**2, atol=1e-14)


BENDING = "INPUTE 1 2 0.1 0.2\nINPUTE 1 3 -0.05 -0.3"
MOTION = {2: "0.1 + 0.2*t, 0.2, 0.", 3: "-0.05 - 0.3*t, -0.3, 0."}


@pytest.mark.parametrize("how", ["option", "file"])
@pytest.mark.parametrize("named", [(2, 3), (2,), (3,)])
def test_userinp_about_a_divided_beam(tmp_path: Path, named: tuple[int, ...], how: str) -> None:
    """What a function prescribes of a beam is divided among its parts as INPUTE is; the other modes follow INPUTE."""
    law = "EM 1 0.\nESTIFF 1 0. 1." if how == "option" else ""
    section = "" if how == "option" else "SECTION s CUSTOM 1. 1. 1. 1.\nMATERIAL m 1. 1. 0.\nBEAMSEC 1 s m 3\n"
    rows = ", ".join(f"[1, {m}, {MOTION[m]}]" for m in named)
    (tmp_path / "bend.py").write_text(f"def bend(t, n):\n    return t, [{rows}], []\n")

    def run(motion: str) -> spacar.Result:
        path = tmp_path / "model.dat"
        path.write_text(
            f"PLBEAM 1 1 2 3 4\nX 3 1. 0.\nFIX 1\nFIX 2\nINPUTE 1 2 3\n{section}END HALT\nXM 3 1.\n{law}\n{motion}\n"
            "TIMESTEP 0.1 2\nEND END\n"
        )
        return spacar.run(1, path, **({"elements": 3} if how == "option" else {}))

    stated, by_function = run(BENDING), run(f"{BENDING if len(named) == 1 else ''}\nUSERINP bend")
    for name in ("x", "xd", "xdd", "e", "sig"):
        assert by_function[name] == pytest.approx(stated[name], rel=1e-12, abs=1e-12)
    assert abs(stated.node(3)[-1, 1]) > 0.01


def test_usersig_beside_a_divided_beam_is_warned_of(tmp_path: Path) -> None:
    (tmp_path / "push.py").write_text("def push(t, *told):\n    return t, [], [[3, 2, 1.0]]\n")
    path = tmp_path / "model.dat"
    path.write_text(
        "PLBEAM 1 1 2 3 4\nX 3 1. 0.\nFIX 1\nFIX 2\nDYNE 1 2 3\nEND HALT\n"
        "EM 1 1. 0.1\nESTIFF 1 0. 1.\nUSERSIG push\nEND END\n"
    )
    said = [[line for line in spacar.run(7, path, elements=n).report if "first part" in line] for n in (1, 2)]
    assert list(map(len, said)) == [0, 1]


# -- what can be wrong ---------------------------------------------------------------------------------------------
def test_missing_file(tmp_path: Path) -> None:
    """Published models come with NAME.m: the message says that it was seen, and what to write."""
    text = failure(model(tmp_path, "USERSIG nowhere", ""), InputError)
    assert "model.dat:4: USERSIG" in text
    assert "nowhere.py" in text
    (tmp_path / "nowhere.m").write_text("function [t, sig, f] = nowhere(t, ne, le, e, ep, nx, lnp, x, xd)\n")
    text = failure(model(tmp_path, "USERSIG nowhere", ""), InputError)
    assert "nowhere.m is there" in text
    assert "spacar keywords USERSIG" in text


@pytest.mark.parametrize("keyword", ["USERSIG", "USERINP"])
@pytest.mark.parametrize(
    ("content", "expected"),
    [
        ("def other(t):\n    return 1\n", "does not define a function myfun"),
        ("myfun = 3\n", "does not define a function myfun"),
        ("def myfun(:\n", "SyntaxError"),
        ("import no_such_module_at_all\n", "ModuleNotFoundError"),
        ("raise SystemError('no')\n", "SystemError: no"),
    ],
)
def test_function_file_that_cannot_be_used(tmp_path: Path, keyword: str, content: str, expected: str) -> None:
    text = failure(model(tmp_path, f"{keyword} myfun", content), InputError)
    assert f"model.dat:4: {keyword}" in text
    assert expected in text


SIGNATURE = {"USERSIG": "t, ne, le, e, ep, nx, lnp, x, xp", "USERINP": "t, step"}


@pytest.mark.parametrize(
    ("keyword", "result", "code", "expected"),
    [
        ("USERSIG", "1 / 0", "failed", ("myfun", "t = 0", "ZeroDivisionError")),
        ("USERSIG", "(_ for _ in ()).throw(ValueError('bad\\nluck'))", "failed", ("myfun", "t = 0", "bad")),
        ("USERSIG", "None", "failed", ("myfun", "t = 0")),
        ("USERSIG", "(t, None)", "failed", ("myfun", "t = 0")),
        ("USERSIG", "(t, [[3, 1]], None)", "shape", ("sig", "3 or 5", "(1, 2)")),
        ("USERSIG", "(t, [[3, 1, 2.0, 1.0]], None)", "shape", ("sig", "3 or 5")),
        ("USERSIG", "(t, None, [[[2, 1, 2.0]]])", "shape", ("f", "3 or 5")),
        ("USERSIG", "(t, [['a', 1, 2.0]], None)", "shape", ("sig", "numbers")),
        ("USERSIG", "(t, None, [{2, 1, 2.0}])", "shape", ("f", "not an array")),
        ("USERSIG", "(t, None, [[2, 1, [2.0]]])", "shape", ("f", "not an array")),
        ("USERSIG", "(t, [[3, 1, 2.0], [3, 1]], None)", "shape", ("sig",)),
        ("USERSIG", "(t, [[3, 1, 2.0], [3, 1, float('nan')]], None)", "not-finite", ("row 2 of sig", "t = 0")),
        ("USERSIG", "(t, None, [[2, 1, float('inf')]])", "not-finite", ("row 1 of f", "t = 0")),
        ("USERSIG", "(t, [[3, 1, 10**400]], None)", "shape", ("sig", "t = 0", "too large")),
        ("USERSIG", "(t, [[3, 1, 10**400, 0.0, 0.0]], None)", "shape", ("sig", "t = 0", "too large")),
        ("USERSIG", "(t, [[9, 1, 2.0]], None)", "index", ("row 1 of sig", "9 1", "does not exist")),
        ("USERSIG", "(t, [[3, 2, 2.0]], None)", "index", ("row 1 of sig", "3 2", "does not exist")),
        ("USERSIG", "(t, [[0, 0, 2.0]], None)", "index", ("0 0",)),
        ("USERSIG", "(t, [[3.5, 1, 2.0]], None)", "index", ("3.5 1",)),
        ("USERSIG", "(t, None, [[2, 3, 2.0]])", "index", ("row 1 of f", "2 3")),
        ("USERINP", "undefined", "failed", ("myfun", "t = 0", "NameError")),
        ("USERINP", "(t, [[5, 1, 0.0]], None)", "shape", ("e", "5 numbers")),
        ("USERINP", "(t, [[5, 1, 0.0, float('nan'), 0.0]], None)", "not-finite", ("row 1 of e",)),
        ("USERINP", "(t, [[3, 1, 0.0, 0.0, 0.0]], None)", "index", ("3 1", "no input deformation")),
        ("USERINP", "(t, None, [[2, 1, 0.0, 0.0, 0.0]])", "index", ("2 1", "no input coordinate")),
        ("USERINP", "(t, [[77, 1, 0.0, 0.0, 0.0]], None)", "index", ("77 1",)),
    ],
)
def test_wrong_results(tmp_path: Path, keyword: str, result: str, code: str, expected: tuple[str, ...]) -> None:
    path = model(tmp_path, f"{keyword} myfun", f"def myfun({SIGNATURE[keyword]}):\n    return {result}\n")
    with pytest.raises(AnalysisError) as caught:
        spacar.run(1, path)
    assert caught.value.code == f"user-function.{code}"
    for part in expected:
        assert part in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_failure_in_the_middle_says_when_and_keeps_what_was_computed(tmp_path: Path) -> None:
    body = "def myfun(t, ne, le, e, ep, nx, lnp, x, xp):\n    return t, None, [[2, 1, 1.0 if t < 0.55 else float('nan')]]\n"  # noqa: E501
    frames = []
    with pytest.raises(AnalysisError, match=r"t = 0\.5[5-9].* row 1 of f") as caught:  # noqa: PT012
        for frame in spacar.frames(1, model(tmp_path, "USERSIG myfun", body)):
            frames.append(frame.t)
    assert frames == pytest.approx([0.0, 0.1, 0.2, 0.3, 0.4, 0.5])
    assert caught.value.code == "user-function.not-finite"


def test_exceptions_that_end_the_program_are_not_swallowed(tmp_path: Path) -> None:
    body = "def myfun(t, step):\n    raise KeyboardInterrupt\n"
    with pytest.raises(KeyboardInterrupt):
        spacar.run(1, model(tmp_path, "USERINP myfun", body))


def test_the_same_text_is_compiled_once_and_executed_for_every_model(tmp_path: Path, monkeypatch) -> None:
    """An edited file counts, what a file remembers is that of one model, and nothing is written beside it."""
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    path = model(tmp_path, "USERSIG myfun", SPRING)

    def loaded() -> Callable[..., Any]:
        return spacar.frames(1, path).mechanism.user_signal.function.function

    first, second = loaded(), loaded()
    assert first.__code__ is second.__code__
    assert first.__globals__ is not second.__globals__
    stat = (tmp_path / "myfun.py").stat()
    (tmp_path / "myfun.py").write_text(SPRING.replace("8.0 * e[i]", "9.0 * e[i]"))
    os.utime(tmp_path / "myfun.py", ns=(stat.st_atime_ns, stat.st_mtime_ns))  # of the same time and size
    assert 9.0 in loaded().__code__.co_consts
    assert 9.0 not in first.__code__.co_consts
    (tmp_path / "other").mkdir()
    elsewhere = model(tmp_path / "other", "USERSIG myfun", SPRING)
    other = spacar.frames(1, elsewhere).mechanism.user_signal.function.function
    assert other.__code__.co_filename == str(tmp_path / "other" / "myfun.py")
    assert other.__globals__["__file__"] == other.__code__.co_filename
    assert {found.name for found in tmp_path.rglob("*")} == {"model.dat", "myfun.py", "other"}


def test_a_file_in_small_letters_serves(tmp_path: Path) -> None:
    path = model(tmp_path, "USERSIG MyFun", "")
    (tmp_path / "myfun.py").write_text(SPRING)
    assert spacar.frames(1, path).mechanism.user_signal is not None
    (tmp_path / "myfun.py").unlink()
    (tmp_path / "MyFun.py").mkdir()
    assert "cannot be loaded: IsADirectoryError" in failure(path, InputError)
