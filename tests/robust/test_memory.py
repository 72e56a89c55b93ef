"""Nothing is allocated before the first step that grows with the number of steps or cases; Ctrl-C always works."""

import itertools
import resource
import signal
import time

import numpy as np
import pytest
from spacar_formats.sbf import SbfFile

from spacar.errors import UsageError
from spacar.integrators import EvenTimes
from spacar.studies.assignments import Combinations, axis, combine
from tests.examples import DATA

from .processes import done, model, start, until

GIGABYTE = 1 << 30


def poor():
    """As `ulimit -v`: a gigabyte and a half of addresses, what Python, NumPy and SciPy take included."""
    resource.setrlimit(resource.RLIMIT_AS, (3 * GIGABYTE // 2, 3 * GIGABYTE // 2))
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.mark.parametrize("n", [1, 2, 3, 7, 1000])
@pytest.mark.parametrize("interval", [(0.0, 1.0), (0.0, 0.1), (0.3, 7.7), (0.0, 1e-300)])
def test_output_times_are_those_of_linspace(n, interval):
    times = EvenTimes(*interval, n)
    expected = np.linspace(*interval, n + 1).tolist()
    assert list(times) == expected
    assert [times[i] for i in range(-n - 1, n + 1)] == expected * 2
    assert times[1:] == expected[1:]
    with pytest.raises(IndexError):
        times[n + 1]


@pytest.mark.parametrize("wrong", [(0.0, 1e-320, 10**6), (0.0, 1.0, 0), (1e9, 1e9 + 1e-5, 10**6), (0.0, 1.0, 10**16)])
def test_times_that_do_not_differ_are_refused(wrong):
    with pytest.raises(UsageError, match="times that differ"):
        EvenTimes(*wrong)


@pytest.mark.parametrize("name", ["crank", pytest.param("slider", marks=pytest.mark.slow)])
def test_a_billion_steps_begin_at_once_and_can_be_interrupted(tmp_path, name):
    """A billion times are 8 GB: under a limit of 1.5 GB only times that are computed one by one can be run."""
    model(tmp_path, name)
    process = start(tmp_path, 1, name, "--time", "1e6", "--steps", 10**9, "--force", preexec_fn=poor)
    part = tmp_path / f"{name}.sbd.part"
    until(lambda: part.exists() and part.stat().st_size > 20_000, process)
    begun = time.monotonic()
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "interrupted after" in err
    assert time.monotonic() - begun < 10.0  # 0.1 s on an idle machine
    with SbfFile(part) as file:
        assert file.steps > 5


def test_trajectories_are_not_stored_either(tmp_path):
    text = (model(tmp_path, "robotinv") / "robotinv.dat").read_text()
    changed = text.replace("TRTIME 1.0 100", "TRTIME 1.0 1000000000")
    assert changed != text
    (tmp_path / "robotinv.dat").write_text(changed)
    process = start(tmp_path, 2, "robotinv", "--force", preexec_fn=poor)
    part = tmp_path / "robotinv.sbd.part"
    until(lambda: part.exists() and part.stat().st_size > 20_000, process)
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=60)
    assert process.returncode == 130


def test_combinations_are_those_of_the_product():
    first, second, third = [(1.0,), (2.0,)], [(3.0, 4.0)], [(5.0,), (6.0,), (7.0,)]
    expected = [a + b + c for a, b, c in itertools.product(first, second, third)]
    found = Combinations(first, second, third)
    assert len(found) == 6
    assert list(found) == expected == [found[k] for k in range(6)] == [found[k] for k in range(-6, 0)]
    assert found[2:4] == expected[2:4]
    assert list(Combinations()) == [()]


def test_a_sweep_over_a_billion_of_cases_stores_its_axes_only():
    _, cases = combine([axis("ESTIFF.3[EI]=1:2:1000000"), axis("ESTIFF.2[EI]=1:2:1000")])
    assert len(cases) == 10**9
    assert cases[-1] == (2.0, 2.0)
    assert next(iter(cases)) == (1.0, 1.0)
    with pytest.raises(UsageError, match="more than can ever be run"):
        combine([axis(f"ESTIFF.{k}[EI]=1:2:1000000") for k in range(4)])


@pytest.mark.parametrize("jobs", [1, 2])
def test_such_a_sweep_begins_at_once_and_can_be_interrupted(tmp_path, jobs):
    model(tmp_path)
    words = ("sweep", "crank", "--force", "--set", "EM.2=0.1:0.2:100000", "--set", "XM.6=0.03:0.04:100000",
             "--result", "x[6,1]@end", "--steps", 2, "--time", 0.001, "--no-batch", "--jobs", jobs)  # fmt: skip
    process = start(tmp_path, *words, **{"preexec_fn": poor} if jobs == 1 else {})
    rows = tmp_path / "crank.sweep.csv"
    until(lambda: rows.exists() and rows.read_text().count("\n") > 4, process)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 130, err
    assert err.strip() == "error: interrupted"


@pytest.mark.parametrize("kind", [0, 1, 2, 3])
@pytest.mark.parametrize(("initial", "additional", "every"), [(0, 1, 1), (3, 7, 2), (1, 10, 20), (4, 0, 0), (2, 6, 3)])
def test_stored_load_levels_are_counted_without_being_made(kind, initial, additional, every):
    from spacar.mechanism import SolverSettings
    from spacar.stationary.loading import LoadProgram

    settings = SolverSettings(stationary_type=kind, initial_steps=initial, load_steps=additional, store_every=every)
    assert settings.stored_levels == sum(level.store for level in LoadProgram(settings))


@pytest.mark.slow
def test_simulations_that_stay_in_memory_have_a_largest_number_of_times(tmp_path):
    model(tmp_path, "robotsim")
    text = (DATA / "robotsim.sim").read_text().replace("step = 0.01", "step = 1e-12")
    (tmp_path / "a.sim").write_text(text)
    for name, mode in (("robotinv", 2), ("robotinvlin", 3)):
        model(tmp_path, name)
        assert done(tmp_path, mode, name)[0] == 0
    status, _, err = done(tmp_path, "sim", "a")
    assert status == 2
    assert "stay in memory" in err
