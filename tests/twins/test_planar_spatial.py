"""Tricycles with planar and with spatial elements: the same motion and forces, and published numbers.

Other mechanisms are compared with their spatial twins in tests/combinations ("as spatial").
"""

import numpy as np

import spacar
from tests.examples import DATA


def test_tricycle() -> None:
    """trike2 (planar) and trike3v (spatial, same steer angle): motion to 1e-6."""
    options = {"atol": 1e-10, "rtol": 1e-10, "duration": 1.0, "n_steps": 20}
    a = spacar.run(1, DATA / "trike2.dat", **options)
    b = spacar.run(1, DATA / "trike3v.dat", **options)
    for k in (1, 2):
        np.testing.assert_allclose(b.node(1, k), a.node(1, k), atol=1e-6)
        np.testing.assert_allclose(b.node(1, k, "xdd"), a.node(1, k, "xdd"), atol=1e-6 * 30)
    turned = {12: a.node(2, 1), 8: a.element(6, 1), 2: a.node(4, 1), 5: a.node(6, 1), 10: a.node(10, 1)}
    for element, angle in turned.items():  # yaw, steer, wheels
        np.testing.assert_allclose(b.element(element, 1), angle, atol=1e-6)
    normal = sum(b.element(w, 3, "sig") for w in (3, 6, 11))
    np.testing.assert_allclose(normal, -9.81 * (80 + 2 + 2 + 1.5), rtol=1e-10)


def test_tricycle_against_published_numbers() -> None:
    """theory-spatial.md section 14: x, y, yaw, steer and rate of wheel 1 after 1 s."""
    r = spacar.run(1, DATA / "trike3v.dat", atol=1e-10, rtol=1e-10)
    found = [r.node(1, 1)[-1], r.node(1, 2)[-1], r.element(12, 1)[-1], r.element(8, 1)[-1], r.element(2, 1, "ed")[-1]]
    np.testing.assert_allclose(found, [2.7761162, -0.7113584, -0.3045697, -0.0045997, 8.6174554], atol=1e-6)
    forces = [r.element(w, 3, "sig")[-1] for w in (3, 6, 11)]
    np.testing.assert_allclose(forces, [-295.4587, -293.1418, -250.1545], atol=2e-4)


def test_inclined_tricycle_against_published_numbers() -> None:
    r = spacar.run(1, DATA / "trike3i.dat", atol=1e-10, rtol=1e-10)
    x, y = r.node(1, 1)[-1], r.node(1, 2)[-1]
    np.testing.assert_allclose([x, y], [2.6830252, -0.9857472], atol=1e-6)
