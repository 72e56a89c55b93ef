"""Built-in blocks together: against the blocks one by one, and the Jacobian against differences of the loop."""

import numpy as np
import pytest

from spacar import simulation as sim
from spacar.simulation.affine_blocks import by_differences, diagram_jacobian
from spacar.simulation.diagram import schedule
from spacar.simulation.diagram_evaluator import DiagramEvaluator
from spacar.simulation.switching_blocks import DeadZone

from .diagrams import chain, ring

RANDOM = np.random.default_rng(7)
BLOCKS = [
    sim.PID("pid", [4.0, 3.0], 2.0, 0.5, filter=80.0, lower=-1.0, upper=1.0, size=2),
    sim.PID("clamps", 4.0, 2.0, lower=-1.0, upper=1.0, anti_windup="clamping", size=2),
    sim.Integrator("integral", gain=[2.0, 3.0], lower=-1.0, upper=1.0, size=2),
    sim.RateLimiter("rate", 2.0, bandwidth=30.0, size=2), sim.Saturation("limit", -0.5, 0.5, 2),
    DeadZone("dead", -0.2, 0.3, 2),
    sim.Gain("gain", [[1.0, 2.0], [0.5, -1.0]]), sim.transfer_function("notch", [1.0, 2.0, 90.0], [1.0, 30.0, 100.0]),
]  # fmt: skip


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
    d = ring(
        sim.PID("pid", 4.0, 2.0, 0.5, filter=80.0, lower=-1.0, upper=1.0),
        sim.transfer_function("notch", [1, 2, 90], [1, 30, 100]), sim.Saturation("limit", -0.5, 0.5),
        sim.RateLimiter("rate", 2.0, bandwidth=30.0), sim.Integrator("body", 0.3), sim.Gain("back", -1.0),
    )  # fmt: skip
    s = schedule(d)
    start = np.concatenate([b.start() for b in s.blocks])
    run = DiagramEvaluator(s)
    for scale in (0.01, 1.0):
        x = start + scale * RANDOM.normal(size=len(start))
        run.settle(0.0, x)
        u = run.evaluate(0.0, x)
        for name, b in d.blocks.items():
            own = x[s.states[name]], u[s.inputs[name]]
            np.testing.assert_allclose(run.y[s.outputs[name]], b.outputs(0.0, *own), rtol=1e-12, atol=1e-13)
            np.testing.assert_allclose(
                run.rates(0.0, x)[s.states[name]], b.derivative(0.0, *own), rtol=1e-12, atol=1e-12
            )
        step = 1e-6
        columns = [(run.rates(0.0, x + step * e) - run.rates(0.0, x - step * e)) / (2 * step) for e in np.eye(len(x))]
        exact = diagram_jacobian(s, 0.0, x, u, 1e-8)
        np.testing.assert_allclose(exact, np.array(columns).T, rtol=1e-6, atol=1e-5)


@pytest.mark.parametrize("delay", [False, True])
def test_a_sample_that_changes_a_mode_behind_it(delay):
    """u(k) = 3 k at t = k/10 through a saturation of 4 into an integrator: 0.1 (0 + 3 + 4 + 4 ...), one later with
    delay."""
    count = sim.Sampled("count", lambda t, x, u: (x + 1, [3.0 * x]), 0.1, 0, 1, x0=0, delay=delay)
    d = chain(count, sim.Saturation("limit", -4.0, 4.0), sim.Integrator("sum"))
    found = sim.simulate(d, [0.0, 1.0])["sum"][-1, 0]
    assert found == pytest.approx(0.1 * (3.0 + (7 if delay else 8) * 4.0), rel=1e-12)


def test_many_limits_are_each_met():
    """x' = -clip(k (x - r)): where a limit is met follows by hand; 20 of them, at times that nobody chose."""
    n = 20
    limit, gain = RANDOM.uniform(0.5, 2.0, n), RANDOM.uniform(3.0, 9.0, n)
    far = limit / gain + RANDOM.uniform(0.1, 1.0, n)  # from the target: driven at the limit first
    d = ring(
        sim.Gain("gain", -np.diag(gain)), sim.Saturation("limit", -limit, limit, n), sim.Integrator("x", far, size=n)
    )
    times = np.linspace(0.0, 3.0, 16)
    r = sim.simulate(d, times, rtol=1e-10, atol=1e-12)
    met = (far - limit / gain) / limit
    t = np.maximum(times[:, None], met)
    truth = np.maximum(far - limit * times[:, None], limit / gain) * np.exp(-gain * (t - met))
    np.testing.assert_allclose(r["x"], truth, rtol=1e-7, atol=1e-11)
    np.testing.assert_allclose([t for t, _ in r.events], np.sort(met), rtol=0, atol=1e-8)
    assert {name for _, name in r.events} == {"limit of limit"}
