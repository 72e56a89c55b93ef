"""Built-in blocks together: against the blocks one by one, and the Jacobian against differences of the loop."""

from __future__ import annotations

import numpy as np
import pytest

from spacar.simulation import PID, Diagram, Gain, Integrator, RateLimiter, Saturation, transfer_function
from spacar.simulation.affine_blocks import by_differences, diagram_jacobian
from spacar.simulation.engine import _Simulation
from spacar.simulation.switching_blocks import DeadZone

RANDOM = np.random.default_rng(7)
BLOCKS = [
    PID("pid", [4.0, 3.0], 2.0, 0.5, filter=80.0, lower=-1.0, upper=1.0, size=2),
    PID("clamps", 4.0, 2.0, lower=-1.0, upper=1.0, anti_windup="clamping", size=2),
    Integrator("integral", gain=[2.0, 3.0], lower=-1.0, upper=1.0, size=2),
    RateLimiter("rate", 2.0, bandwidth=30.0, size=2),
    Saturation("limit", -0.5, 0.5, 2),
    DeadZone("dead", -0.2, 0.3, 2),
    Gain("gain", [[1.0, 2.0], [0.5, -1.0]]),
    transfer_function("notch", [1.0, 2.0, 90.0], [1.0, 30.0, 100.0]),
]


@pytest.mark.parametrize("block", BLOCKS, ids=lambda b: b.name)
def test_a_block_is_what_its_matrices_say_in_every_mode(block):
    for scale in (0.01, 0.3, 3.0):
        x = block.start() + scale * RANDOM.normal(size=block.n_states)
        u = scale * RANDOM.normal(size=block.n_in)
        block.switch(0.0, x, u)
        f = block.affine()
        np.testing.assert_allclose(f.C @ x + f.D @ u + f.c, block.outputs(0.0, x, u), rtol=1e-13, atol=1e-13)
        np.testing.assert_allclose(f.A @ x + f.B @ u + f.a, block.derivative(0.0, x, u), rtol=1e-13, atol=1e-12)
        seen = by_differences(block, 0.0, x, u, 1e-8)
        np.testing.assert_allclose(seen.A, f.A, atol=1e-4)
        np.testing.assert_allclose(seen.D, f.D, atol=1e-6)
    block.start()


def test_a_loop_of_all_of_them():
    """Outputs and rates together are those one by one; the Jacobian is that of differences of the whole loop."""
    d = Diagram().add(
        PID("pid", 4.0, 2.0, 0.5, filter=80.0, lower=-1.0, upper=1.0),
        transfer_function("notch", [1, 2, 90], [1, 30, 100]), Saturation("limit", -0.5, 0.5),
        RateLimiter("rate", 2.0, bandwidth=30.0), Integrator("body", 0.3),
        Gain("back", -1.0),
    )  # fmt: skip
    names = list(d.blocks)
    for a, b in zip(names, [*names[1:], names[0]], strict=True):
        d.connect(a, b)
    run = _Simulation(d, np.array([0.0, 1.0]), 155, 1e-8, 1e-6, np.inf, (), {})
    for scale in (0.01, 1.0):
        x = run.x + scale * RANDOM.normal(size=len(run.x))
        run.settle(0.0, x)
        alone = run.evaluate(0.0, x, (), True).copy()
        np.testing.assert_allclose(run.evaluate(0.0, x), alone, rtol=1e-12, atol=1e-13)
        u = run.evaluate(0.0, x)
        step = 1e-6
        columns = [(run.rhs(0.0, x + step * e) - run.rhs(0.0, x - step * e)) / (2 * step) for e in np.eye(len(x))]
        exact = diagram_jacobian(run.s, 0.0, x, u, 1e-8)
        np.testing.assert_allclose(exact, np.array(columns).T, rtol=1e-6, atol=1e-5)
