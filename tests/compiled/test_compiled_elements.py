"""Families whose functions are in C against the NumPy families, relative to the largest entry."""

import pickle

import numpy as np
import pytest

from spacar.compiled.compiled_elements import CompiledElements, compiled_family
from spacar.compiled.library import unavailable
from spacar.elements.family import Family
from tests.elements.derivatives import close, written

from .test_definitions import MODELS, family_of

pytestmark = pytest.mark.skipif(unavailable() is not None, reason=str(unavailable()))
TOLERANCE = 1e-11  # as test_definitions.py


def in_c(form: str) -> tuple[CompiledElements, np.ndarray]:
    general, x0 = family_of(form)
    family = compiled_family(general)
    assert isinstance(family, CompiledElements)
    return family, x0


def several(family: CompiledElements, n: int) -> CompiledElements:
    """The first element n times, without a NumPy family."""

    class Copies(Family):
        n = 0

    copies = Copies()
    for name, value in vars(family).items():
        if name not in ("general", "_parameters", "elements", "_at", "_shape", "_call"):
            setattr(copies, name, value)
    copies.n = n
    return CompiledElements(copies, family.elements.kind, np.repeat(family._parameters[:, :1], n, axis=1))


def state(x0: np.ndarray, n: int = 0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Random x near x0, v and a, of n elements like the first; Euler parameters as they are, of any norm."""
    rng = np.random.default_rng(11)
    shape = (len(x0), n or x0.shape[1])
    moved, v, a = rng.standard_normal((3, *shape))
    return (x0[:, :1] if n else x0) + 0.1 * moved, v, a


def answers(one: Family, x: np.ndarray, v: np.ndarray, a: np.ndarray, sigma: np.ndarray) -> dict[str, np.ndarray]:
    """Every function of the contract that C has."""
    m, nx, n = one.n_deformations, *x.shape
    e, V = np.zeros((m, n)), np.zeros((m, nx, n))
    c = one.strain(x, np.zeros((m, n)), e, V)
    found = {"e": e, "V": V}
    if m and not one.constant_gradient:
        found["convective"] = written(one.convective_strain, (m, n), float, c, v)
        for name in ("gradient_rate", "gradient_transport", "rate_gradient"):
            found[name] = written(getattr(one, name), (m, nx, n), float, c, v)
        found["Hs"] = written(one.geometric_stiffness, (nx, nx, n), float, c, sigma)
    if one.has_mass and not one.constant_mass:
        found["mass"] = written(one.mass, (nx, nx, n), float, c)
        found["force"], found["h"] = one.inertia_force(c, v, a), one.inertia_force(c, v, None)
        found["dx"], found["dv"] = one.inertia_gradient(c, v, a)
    return found


@pytest.mark.parametrize("form", MODELS)
def test_both_families_give_the_same(form: str) -> None:
    """Those of NumPy are derivatives by complex steps (tests/elements); also at large stresses."""
    family, x0 = in_c(form)
    sigma = 1e6 * np.random.default_rng(3).standard_normal((family.n_deformations, family.n))
    want, got = (answers(one, *state(x0), sigma) for one in (family.general, family))
    for name, value in want.items():
        close(got[name], value, name, TOLERANCE)


@pytest.mark.parametrize("form", MODELS)
@pytest.mark.parametrize("n", [2, 3, 5, 9])
def test_elements_side_by_side_do_not_mix(form: str, n: int) -> None:
    """Lanes of a vector, the last one partly filled: each element as if it were alone."""
    one, x0 = in_c(form)
    given = *state(x0, n), np.random.default_rng(3).standard_normal((one.n_deformations, n))
    alone = [answers(several(one, 1), *(u[:, [k]] for u in given)) for k in range(n)]
    for name, got in answers(several(one, n), *given).items():
        np.testing.assert_allclose(got, np.concatenate([a[name] for a in alone], axis=-1), rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("form", MODELS)
def test_limits_are_those_of_numpy(form: str) -> None:
    """At the start, and with the end q turned by 1.3 rad, both in the plane."""
    family, x0 = in_c(form)
    m, n = family.n_deformations, family.n
    turned = x0.copy()
    if form.startswith("PL"):
        turned[-1] += 1.3
    elif family.n_coordinates >= 14:
        turned[10:14] = np.array([[np.cos(0.65)], [0.0], [0.0], [np.sin(0.65)]])
    for x in (x0, turned):
        texts = []
        for one in (family.general, family):
            e, V = np.zeros((m, n)), np.zeros((m, *x.shape))
            texts.append([t.text for t in one.troubles(one.strain(x, e.copy(), e, V), e, e)])
        assert texts[0] == texts[1]


def test_whole_turns_are_counted() -> None:
    family, x0 = in_c("HINGE")
    e, V = np.zeros((3, 1)), np.zeros((3, 8, 1))
    family.strain(x0, np.array([[13.0], [0.0], [0.0]]), e, V)
    np.testing.assert_allclose(e[:, 0], [4 * np.pi, 0, 0], atol=1e-12)


def test_numpy_answers_complex_numbers_and_further_axes() -> None:
    family, x0 = in_c("BEAM angle")
    x = x0[:, :, None] + np.zeros(4)
    e, V = np.zeros((6, 1, 4)), np.zeros((6, 14, 1, 4))
    c = family.strain(x, np.zeros((6, 1, 4)), e, V)
    out = np.zeros((14, 14, 1, 4))
    family.geometric_stiffness(c, np.ones((6, 1, 4)), out)
    want = np.zeros((14, 14, 1))
    family.geometric_stiffness(family.strain(x0, e[..., 0], e[..., 0].copy(), V[..., 0].copy()), np.ones((6, 1)), want)
    np.testing.assert_allclose(out, np.repeat(want[..., None], 4, axis=-1), atol=1e-11)


def test_a_compiled_family_can_be_pickled() -> None:
    family, _ = in_c("BEAM")
    again = pickle.loads(pickle.dumps(family))
    assert isinstance(again, CompiledElements)
    assert np.array_equal(again._parameters, family._parameters)
