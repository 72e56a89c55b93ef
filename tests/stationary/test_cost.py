"""What small stationary solutions cost, in evaluations, which do not depend on the machine."""

import pytest
from statics import cantilever

from tests.examples import DATA

from .walk import walked


@pytest.mark.parametrize(("name", "most"), [("crankfl", 10), ("finger", 10), ("fingersim", 27), ("lateral4", 8)])
def test_examples(name, most):
    """Four load steps each; a crank under inertia forces, fingers whose stiffness is that of their loads,
    one of them from a displaced start, which is held under all loads."""
    assert walked((DATA / f"{name}.dat").read_text()).dynamics.sweep.count <= most


def test_the_way_back_ends_when_it_is_known_where_it_leads():
    """A cantilever bent by 82 degrees in ten steps; the first part is walked back to the unloaded state, where no
    residual is small beside the forces."""
    text = cantilever(10).replace("ITERSTEP 20 4", "ITERSTEP 20 10")
    assert walked(text).dynamics.sweep.count <= 50
