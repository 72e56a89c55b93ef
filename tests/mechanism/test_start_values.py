"""Start values of kinematic configuration coordinates: the vehicle starts elsewhere and moves in the same way."""

import numpy as np

import spacar
from tests.examples import DATA

TRIKE = (DATA / "trike2.dat").read_text()


def run(extra=""):
    deck = spacar.parse_deck(TRIKE.replace("TIMESTEP 1.0 100", f"{extra}\nTIMESTEP 0.2 4"), mode=1)
    return spacar.run(1, deck, atol=1e-9, rtol=1e-9)


def test_start_value_of_a_kinematic_coordinate():
    plain, moved = run(), run("STARTDX 1 1 2.3 0.0")
    # X 1 is 0.3; ten times the tolerance of the integration
    np.testing.assert_allclose(moved.node(1, 1) - plain.node(1, 1), 2.0, atol=1e-8)
    np.testing.assert_allclose(moved.node(9, 2), plain.node(9, 2), atol=1e-8)


def test_without_a_statement_kinematic_deformations_keep_the_reference_configuration():
    mechanism = spacar.frames(1, DATA / "trike3v.dat").mechanism
    assert np.isnan(mechanism.start.e_kinematic).all()
