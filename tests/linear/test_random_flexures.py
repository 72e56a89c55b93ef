"""Eigenvalues and load multipliers of beam and flexure models in SI units: never refused, right to rounding.

Truths that know nothing of our scaling and reduction: SciPy's solver for the same matrices, and 40 digits.

Tolerance against SciPy. For a pair (w, v) of the definite pencil (A, B) with residual r = A v - w B v an eigenvalue
lies within |r|_{B^-1} / |v|_B of w (Parlett, The Symmetric Eigenvalue Problem, 15.4), to which the rounding of r,
n eps |A||v| in the same norm, is added. Two solvers may differ by the sum of their bounds.
"""

import numpy as np
import pytest
from scipy.linalg import eigh, solve_triangular

import spacar
from spacar.linear.buckling import NOTHING

from .flexure_models import Model, Strip, cantilever_leaf, guide, random_model
from .test_few_modes import eigenvalue_near

EPS = np.finfo(float).eps


def bounds(A: np.ndarray, B: np.ndarray, w: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Distance to the next eigenvalue that is certain for every pair."""
    d = 1 / np.sqrt(np.diag(B))
    L = np.linalg.cholesky(B * np.outer(d, d))

    def norm(r: np.ndarray) -> np.ndarray:
        return np.linalg.norm(solve_triangular(L, r * d[:, None], lower=True), axis=0)

    size = np.sqrt(np.einsum("ik,ij,jk->k", v, B, v))
    inverse = np.abs(solve_triangular(L, np.diag(d), lower=True))
    rounding = len(A) * EPS * np.linalg.norm(inverse @ (np.abs(A) @ np.abs(v) + np.abs(B) @ np.abs(v) * abs(w)), axis=0)
    return (norm(A @ v - B @ v * w) + rounding) / size


def check(A: np.ndarray, B: np.ndarray, w: np.ndarray, v: np.ndarray, extra: np.ndarray | float = 0.0) -> np.ndarray:
    """Our pairs, ascending, against SciPy's; the tolerance as a fraction of the largest, to which `extra` is added."""
    truth, shapes = eigh(A, B)
    tolerance = bounds(A, B, w, v) + bounds(A, B, truth, shapes) + extra * np.max(np.abs(truth))
    assert np.all(np.abs(w - truth) <= tolerance), (w, truth, tolerance)
    return tolerance / np.max(np.abs(truth))


def squares(frame: spacar.frame.Frame) -> tuple[np.ndarray, np.ndarray]:
    """omega^2 and shapes, ascending, from the stored state eigenvectors."""
    values = frame.matrices["eigval"] @ [1, 1j]
    half = (values.imag > 0) | ((values.imag == 0) & (values.real > 0))
    w2 = (-(values[half] ** 2)).real
    order = np.argsort(w2)
    vectors = frame.matrices["eigvre"][: len(w2), half]
    return w2[order], vectors[:, order]


def matrices(frame: spacar.frame.Frame) -> tuple[np.ndarray, ...]:
    """M0, K0 + N0 + G0, K0, G0."""
    m = frame.matrices
    return m["m0"], m["k0"] + m["n0"] + m["g0"], m["k0"], m["g0"]


@pytest.mark.parametrize("first", range(0, 240, 24))
def test_random_beams_and_flexures_agree_with_scipy(first):
    """24 models at a time in mode 10, every third in modes 7 and 8 too, which must say the same."""
    for seed in range(first, first + 24):
        text = random_model(seed).text()
        both = spacar.run(10, spacar.parse_deck(text, mode=10))
        frame = both.frames[-1]
        for mode, name in ((7, "eigval"), (8, "lmult")) if seed % 3 == 0 else ():
            assert np.array_equal(spacar.run(mode, spacar.parse_deck(text, mode=mode))[name][-1], frame.matrices[name])
        M, K, K0, G0 = matrices(frame)
        tolerance = check(K, M, *squares(frame))
        assert np.all(tolerance < 1e-5), (seed, tolerance)  # the comparison means something
        assert not any("fewer digits" in line for line in both.report), seed
        lmult, modes = frame.matrices["lmult"], frame.matrices["bmode"]
        if not G0.any():
            assert np.all(np.isinf(lmult))
            continue
        mu = np.where(np.isinf(lmult), 0.0, 1 / lmult)
        order = np.argsort(mu)
        check(-G0, K0, mu[order], modes[:, order], extra=NOTHING * np.isinf(lmult[order]))


def skew_line() -> str:
    """The smallest model that was refused: two planar beams on a line that is not parallel to an axis."""
    kinematics = "PLBEAM 1 1 2 3 4\nPLBEAM 2 3 4 5 6\nX 1 0 0\nX 3 0.3 0.4\nX 5 0.6 0.8\nFIX 1\nFIX 2"
    dynamics = "EM 1 1\nEM 2 1\nESTIFF 1 4330 1\nESTIFF 2 4330 1"
    return f"{kinematics}\nDYNE 1 1 2 3\nDYNE 2 1 2 3\nEND\nHALT\n{dynamics}\nEND\nEND\n"


def leaf_guide(n: int, thickness: float) -> str:
    model = Model(False)
    guide(model, n, 0.1, 0.05, Strip(0.02, thickness), np.eye(3), 0.1)
    return model.text()


CASES = {
    "skew line": skew_line(),
    **{f"leaf of {n}": cantilever_leaf(n).text() for n in (3, 5, 10)},
    "skew leaf": cantilever_leaf(4, direction=(1, 2, 3)).text(),
    "guide 0.2 mm": leaf_guide(3, 2e-4),
    "guide 1 mm": leaf_guide(3, 1e-3),
}


LARGE = ("leaf of 10", "guide 0.2 mm", "guide 1 mm")


@pytest.mark.parametrize("name", [pytest.param(n, marks=[pytest.mark.slow] * (n in LARGE)) for n in CASES])
def test_frequencies_against_40_digits(name):
    """Although omega^2 spans up to ten decades, it is as good as the entries of the matrices: a relative change of
    eps in each of them changes omega^2 by up to eps |x|^T |K| |x|; n eps for sums of n terms, and for the
    solver n eps/POLISHED, below 1e-12.
    """
    result = spacar.run(10, spacar.parse_deck(CASES[name], mode=10))
    M, K, _, _ = matrices(result.frames[0])
    w2, shapes = squares(result.frames[0])
    for k in (0, 1, 2, len(w2) - 1):
        x = shapes[:, k]
        entries = len(K) * EPS * (np.abs(x) @ np.abs(K) @ np.abs(x)) / abs(x @ K @ x)
        truth = eigenvalue_near(K, M, w2[k])
        assert w2[k] == pytest.approx(truth, rel=1e-12 + entries), (k, w2[k], truth)
    assert not any("fewer digits" in line for line in result.report)
