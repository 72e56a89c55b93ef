"""Small things that users of Python and of the command line try first."""

import sys
from pathlib import Path

import numpy as np
import pytest

import spacar
from spacar.errors import UsageError
from tests.command_line import call
from tests.examples import DATA


def test_a_result_prints_ten_lines(crank, cantilever):
    for result in (crank, cantilever, spacar.run(10, DATA / "lateral4.dat"), spacar.run(0, DATA / "trike2.dat")):
        assert len(repr(result).splitlines()) <= 10
        assert result.mechanism.deck.source in repr(result)
    assert "mode 1: forward dynamics" in repr(crank)
    assert "5, t = 0 to 0.02 s" in repr(crank)


@pytest.mark.parametrize("path", sorted(DATA.glob("*.dat")), ids=lambda p: p.stem)
def test_a_deck_prints_ten_lines(path):
    text = repr(spacar.read_deck(path))
    assert path.name in text
    assert len(text.splitlines()) <= 10


def test_a_notebook_shows_a_picture(crank):
    html = crank._repr_html_()
    assert ">Result of crank.dat" in html
    assert '<img alt="mechanism" src="data:image/png;base64,iVBOR' in html


def test_a_notebook_shows_a_model():
    """A deck and a Model in their start position; one that is not complete yet without a picture."""
    deck = spacar.read_deck(DATA / "trike2.dat")
    for model in (deck, spacar.Model.from_deck(deck)):
        assert model._repr_html_().count("<img alt=") == 1
    text = "Model &lt;model&gt;: no elements; 0 statements\n  .run(1), .deck(), str()"
    assert spacar.Model()._repr_html_() == f'<pre style="font-family: monospace">{text}</pre>'


def test_a_notebook_does_without_a_picture(crank, monkeypatch):
    monkeypatch.setitem(sys.modules, "spacar_drawing", None)
    assert "<img" not in crank._repr_html_()
    assert "crank.dat" in crank._repr_html_()


def test_dir_shows_the_public_names():
    assert [n for n in dir(spacar) if not n.startswith("_")] == sorted(spacar.__all__)


def test_a_result_plots_expressions(crank, tmp_path):
    figure = crank.plot("x[6,1]", "sig[1,1]", path=tmp_path / "a.png")
    assert [a.get_ylabel() for a in figure.axes] == ["x[6,1] (m)", "sig[1,1] (N)"]
    assert np.array_equal(figure.axes[0].lines[0].get_ydata(), crank.node(6, 1))
    assert (tmp_path / "a.png").stat().st_size > 1000
    with pytest.raises(UsageError, match="nothing to plot"):
        crank.plot()


def test_all_coordinates_of_a_node_at_once(crank):
    assert np.array_equal(crank.node(6), np.column_stack([crank.node(6, 1), crank.node(6, 2)]))
    assert np.array_equal(crank.element(1, variable="sig")[:, 0], crank.element(1, 1, "sig"))


def test_frequencies_are_those_of_the_eigenvalues(cantilever, crank):
    """Of 20 eigenvalues in ten pairs, the ten moduli over 2 pi; to rounding of one hypot."""
    values = cantilever["eigval"][0] @ np.array([1.0, 1j])
    moduli = np.sort(np.abs(values))[::2] / (2 * np.pi)
    assert cantilever.frequencies.shape == (1, 10)
    assert cantilever.frequencies[0] == pytest.approx(moduli, rel=1e-14)
    with pytest.raises(UsageError, match="eigval was not computed"):
        _ = crank.frequencies


@pytest.mark.parametrize(
    ("ask", "sentence"),
    [
        (lambda r: r.node(99), "node 99 does not exist; nodes are 1 to 7"),
        (lambda r: r.element(5), "element 5 does not exist; elements are 1 to 2"),
        (lambda r: r.node(99, 1), "node 99 does not exist; nodes are 1 to 7"),
        (lambda r: r.node(0, 1), "node 0 does not exist; nodes are 1 to 7"),
        (lambda r: r.node(6, 3), "node 6 has the coordinates 1 to 2, not 3"),
        (lambda r: r.element(9, 1), "element 9 does not exist; elements are 1 to 2"),
        (lambda r: r.element(1, 4), "element 1 has the deformation modes 1 to 3, not 4"),
    ],
)
def test_errors_list_what_exists(crank, ask, sentence):
    with pytest.raises(UsageError, match=f"^{sentence}$"):
        ask(crank)


def test_version_and_help_of_a_mode():
    assert call("-V") == call("--version")
    assert call("help", "7")[:2] == call("7", "--help")[:2]
    assert call("help", "plot")[:2] == call("plot", "--help")[:2]
    assert call("help")[:2] == call("--help")[:2]
    status, _, said = call("help", "plott")
    assert (status, "did you mean 'plot'?" in said) == (2, True)


def test_a_model_from_standard_input(tmp_path, monkeypatch):
    """The same numbers as from the file; results are stdin.* here, or in --output-dir."""
    monkeypatch.chdir(tmp_path)
    text = (DATA / "plbeam5.dat").read_text()
    assert call(7, "-", stdin=text)[0] == 0
    assert {p.name for p in tmp_path.iterdir()} >= {"stdin.log", "stdin.sbd", "stdin.sbm"}
    assert not Path("stdin.dat").exists()
    assert "Input file: standard input" in Path("stdin.log").read_text()
    assert call(7, "-", "--output-dir", "there", stdin=text)[0] == 0
    assert Path("there/stdin.sbm").exists()
    call(7, DATA / "plbeam5.dat", "--output-dir", tmp_path)
    assert call("eigen", "stdin")[1] == call("eigen", "plbeam5")[1]
    assert call("plot", "stdin", "x[11,2]", "--csv", "-")[1] == call("plot", "plbeam5", "x[11,2]", "--csv", "-")[1]


def test_a_wrong_model_from_standard_input(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert "stdin:1:" in call.refused(1, "-", stdin="PLBEEM 1\nEND\nEND\n")
    status, _, said = call(0, "-", "--release", stdin="END\nEND\n")
    assert (status, "--release needs an input file" in said) == (2, True)
