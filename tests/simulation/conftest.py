import pytest

import spacar
from spacar.simulation import TimeVarying, static_start, tracking_gains, with_gain
from tests.examples import DATA


@pytest.fixture(scope="session")
def robot():
    """Nominal motion and linearization of the rigid manipulator."""
    inverse = spacar.run(2, DATA / "robotinv.dat")
    along = spacar.run(3, DATA / "robotinvlin.dat", nominal=inverse)
    return TimeVarying.of(inverse), TimeVarying.of(along)


@pytest.fixture(scope="session")
def flexible():
    """Linearization of the manipulator with flexible links, tracking gains folded in, from its static deflection."""
    inverse = spacar.run(2, DATA / "robotflexinv.dat")
    along = TimeVarying.of(spacar.run(3, DATA / "robotflexinvlin.dat", nominal=inverse))
    return static_start(with_gain(along, *tracking_gains(along, 28.0, 0.85)))
