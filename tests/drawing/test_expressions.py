"""Expressions of `spacar plot`: values, units, and the messages for wrong ones."""

import csv
import io

import numpy as np
import pytest
from spacar_cli.row_output import csv_text
from spacar_drawing.curves import evaluate
from spacar_drawing.history import axis_text, history_figure, panels
from spacar_drawing.picture_source import open_source, source_of_result

import spacar
from spacar.errors import UsageError
from spacar.expressions import unit, unit_text
from tests.examples import DATA

from .models import result_source


@pytest.fixture(scope="module")
def crank():
    return result_source("crank", 1, 0.035, 14)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("x[6,1]", "m"),
        ("xd[6,1]", "m/s"),
        ("xdd[6,1]", "m/s²"),
        ("x[2,1]", "rad"),
        ("xd[2,1]", "rad/s"),
        ("fxtot[6,2]", "N"),
        ("fxt[2,1]", "N m"),
        ("e[1,1]", "m"),
        ("sig[1,1]", "N"),
        ("t", "s"),
        ("deg(x[2,1])", "deg"),
        ("x[6,1]**2", "m²"),
        ("sqrt(x[6,1]**2 + x[6,2]**2)", "m"),
        ("sin(x[2,1])", ""),
        ("fxtot[2,1]*xd[2,1]", "N m rad/s"),
        ("x[6,1]/xd[6,1]", "s"),
        ("hypot(x[3,1],x[3,2])", "m"),
        ("atan2(x[3,2],x[3,1])", "rad"),
        ("2*x[6,1]-x[3,1]", "m"),
        ("1/t", "1/s"),
        ("-abs(x[6,1])", "m"),
        ("sig[1,1]/x[6,1]**2", "N/m²"),
    ],
)
def test_units(crank, text, expected):
    assert unit_text(evaluate(crank, text).unit) == expected


def test_units_of_other_elements():
    robot = result_source("robotinv", 2)
    assert unit_text(evaluate(robot, "sig[1,1]").unit) == "N m"  # hinge: a moment
    assert unit_text(evaluate(robot, "ed[1,1]").unit) == "rad/s"
    assert unit_text(evaluate(robot, "x[2,1]").unit) == ""  # an Euler parameter
    assert unit_text(unit(N=1, m=-2, s=1)) == "N s/m²"
    assert unit_text(unit(m=-1, s=-1)) == "1/(m s)"


def test_values(crank):
    x = crank.x()
    lnp = crank.scene.lnp
    np.testing.assert_array_equal(evaluate(crank, "x[6,1]").values, x[:, lnp[5, 0] - 1])
    # the crank pin stays at 0.15 m from its bearing; tolerance of the position iteration
    np.testing.assert_allclose(evaluate(crank, "hypot(x[3,1],x[3,2])").values, 0.15, atol=1e-9)
    np.testing.assert_allclose(evaluate(crank, "x[2,1] - 150*x[2,1]/150").values, 0, atol=1e-12)
    np.testing.assert_allclose(evaluate(crank, "cos(x[2,1])*2**2").values, 4 * np.cos(x[:, lnp[1, 0] - 1]))
    assert evaluate(crank, "3.5").values.shape == (len(x),)


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("x[6,1]+x[2,1]", "cannot add rad to m"),
        ("x[99,1]", "node 99 does not exist"),
        ("x[6,3]", "coordinates 1 to 2"),
        ("sig[1,9]", "modes 1 to 3"),
        ("e[7,1]", "element 7"),
        ("x[6]", "node and coordinate"),
        ("y[1,1]", "not a variable"),
        ("x", "two numbers"),
        ("spam", "not a variable"),
        ("x[6,1", "no expression"),
        ("", "no expression"),
        ("open('f')", "no expression"),
        ("x.shape", "no expression"),
        ("sin(x[6,1])", "without unit"),
        ("sin(t, t)", "1 argument"),
        ("x[6,1]**0.5", "whole powers"),
        ("sqrt(x[6,1])", "square root"),
        ("deg(x[6,1])", "radians"),
        ("x[True,1]", "node and coordinate"),
        ("xcompl[6,1]", "does not contain xcompl"),
        ("x[-1,1]", "node and coordinate"),
        ("a\0b", "no expression"),
        ("lambda: 1", "no expression"),
        ("hypot(x[6,1],t)", "same unit"),
    ],
)
def test_wrong_expressions(crank, text, part):
    with pytest.raises(UsageError) as found:
        evaluate(crank, text)
    assert part in str(found.value)


def test_modes_and_matrices_of_a_result(tmp_path):
    """They stand in the `.sbm` file beside, and in the matrices of a result in memory; expressions.md promises them."""
    result = spacar.run(10, DATA / "plbeam5buck.dat")
    result.save(tmp_path / "column")
    frame = result.frames[-1].matrices
    first = result.frequencies[-1, 0], frame["lmult"].flat[0], frame["k0"][1, 0], frame["eigval"][2, 1]
    texts = "frequency[1]@end", "lmult[1]@end", "k0[2,1]@end", "imag(eigval[3])@end"
    for source in (source_of_result(result), open_source(tmp_path / "column")):
        np.testing.assert_allclose([evaluate(source, text).values[0] for text in texts], first, rtol=1e-14)
    (tmp_path / "column.sbm").unlink()
    with pytest.raises(UsageError, match=r"column\.sbm not found; modes 3"):
        evaluate(source, texts[0])


def test_panels_and_labels(crank):
    curves = [evaluate(crank, text) for text in ("x[6,1]", "x[3,1]", "xdd[6,1]", "x[2,1]")]
    assert [[c.text for c in p] for p in panels(curves)] == [["x[6,1]", "x[3,1]"], ["xdd[6,1]"], ["x[2,1]"]]
    assert axis_text(curves[2]) == "xdd[6,1] (m/s²)"
    figure = history_figure(curves, evaluate(crank, "t"))
    assert [a.get_ylabel() for a in figure.axes] == ["coordinate (m)", "xdd[6,1] (m/s²)", "x[2,1] (rad)"]
    assert figure.axes[-1].get_xlabel() == "time t (s)"
    against = history_figure(curves[:1], evaluate(crank, "deg(x[2,1])"))
    assert against.axes[0].get_xlabel() == "deg(x[2,1]) (deg)"


def test_csv_keeps_all_digits(crank):
    curves = [evaluate(crank, "x[6,1]"), evaluate(crank, "xdd[6,1]")]
    columns = [evaluate(crank, "t"), *curves]
    text = csv_text(map(axis_text, columns), zip(*(c.values.tolist() for c in columns), strict=True))
    rows = list(csv.reader(io.StringIO(text)))
    assert rows[0] == ["t (s)", "x[6,1] (m)", "xdd[6,1] (m/s²)"]
    back = np.array([[float(v) for v in row] for row in rows[1:]])
    np.testing.assert_array_equal(back[:, 1], curves[0].values)
    np.testing.assert_array_equal(back[:, 2], curves[1].values)
