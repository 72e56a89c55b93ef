"""`spacar.Model`: decks written by calls are the decks of the files, and what is wrong is said with the Python line."""

import ast
import inspect
from pathlib import Path

import numpy as np
import pytest

import spacar
from spacar.deck.findings import Findings
from spacar.deck.keyword_methods import ModelStatements
from spacar.deck.keyword_table import ELEMENT_TYPES, KEYWORDS
from spacar.deck.lexer import integer_of, number_of, scan
from spacar.deck.model_arguments import NAMES, element_arguments, method_name, statement_arguments, without_component
from spacar.deck.model_methods import stub
from spacar.deck.splitter import split
from spacar.errors import InputError

HOUSE = Path(__file__).parents[2]
HERE = Path(__file__).name
FILES = sorted([*(HOUSE / "data").rglob("*.dat"), *(HOUSE / "tests").rglob("*.dat")])


def of_word(text: str) -> int | float | str:
    """The number that somebody would write in Python."""
    value = number_of(text)
    if value is None:
        return text
    return value if "." in text or "e" in text.lower() or "d" in text.lower() else int(integer_of(text) or 0)


def call(model: spacar.Model, keyword: str, block: int, words: list[str]) -> None:
    """The method of a statement, with its words as arguments."""
    values = [of_word(w) for w in words]
    method = getattr(model, method_name(keyword, block))
    if keyword in ELEMENT_TYPES:
        arguments = []
        for a in element_arguments(keyword):
            if not values:
                break
            if a.kind == "Vector" and len(values) < a.count:  # BEAM with six numbers: the coupling only
                arguments.append(None)
                continue
            taken, values = values[: a.count], values[a.count :]
            arguments.append(tuple(taken) if a.count > 1 else taken[0])
        assert not values
        assert method(*arguments) == arguments[0]
        return
    row = next(k for (name, kind), k in KEYWORDS.items() if name == keyword and kind.number == block)
    first, _, _ = statement_arguments(row)
    arguments = []
    for a in first:
        if values:
            taken, values = values[: a.count], values[a.count :]
            arguments.append(tuple(taken) if a.count > 1 else taken[0])
    assert method(*arguments, *values) is None


@pytest.mark.parametrize("path", FILES, ids=lambda p: p.stem)
def test_calls_give_the_deck_of_the_file(path):
    """Bit for bit: every statement of every block, what follows from sections, and the visualization."""
    deck = spacar.read_deck(path)
    model = spacar.Model(deck.source)
    scanned = scan(deck.text)
    for raw in split(scanned, Findings("")).raws:
        call(model, raw.keyword, raw.block, [w.text for w in raw.words])
    model.visualization(*(scanned.visualization or ()))
    assert same(model.deck(), deck, drawn=scanned.visualization is not None)
    assert same(spacar.Model.from_deck(deck).deck(), deck)


def same(one: spacar.Deck, other: spacar.Deck, drawn: bool = True) -> bool:
    def content(deck):
        plain = [(s.keyword, s.block, [(type(v), v) for v in s.values]) for s in (*deck.statements, *deck.shorthand)]
        return plain, deck.visualization if drawn else (), deck.third, deck.metre, deck.sections

    return content(one) == content(other)


def test_the_stub_declares_the_methods():
    """For editors and type checkers; `hatch_build.py` has written it."""
    path = HOUSE / "spacar" / "deck" / "keyword_methods.pyi"
    assert path.read_text(encoding="utf-8") == stub(), "run: python hatch_build.py"
    [declared] = [node for node in ast.parse(stub()).body if isinstance(node, ast.ClassDef)]
    for node in declared.body[2:]:
        arguments = list(inspect.signature(getattr(ModelStatements, node.name)).parameters)
        given = node.args
        names = [a.arg for a in given.args] + [a.arg for a in (given.vararg,) if a] + [a.arg for a in given.kwonlyargs]
        assert names == arguments
    assert len(declared.body) == 2 + len({method_name(k.name, k.block.number) for k in KEYWORDS.values()})


def test_a_call_with_wrong_arguments_names_the_method():
    with pytest.raises(TypeError, match=r"timestep\(\): missing a required argument: 'steps'"):
        spacar.Model().timestep(1.0)


@pytest.mark.parametrize("row", list(KEYWORDS.values()), ids=lambda k: f"{k.block.name}-{k.name}")
def test_every_keyword_is_a_described_method(row):
    method = getattr(ModelStatements, method_name(row.name, row.block.number))
    text = " ".join((inspect.getdoc(method) or "").split())
    assert text.startswith(f"{row.name}: {row.help}")
    if row.name not in ELEMENT_TYPES:
        units = {p.unit for v in row.variants for p in v.parameters if p.unit}
        assert all(f"[{unit}]" in text for unit in units)
    names = [p for p in inspect.signature(method).parameters if p not in ("self", "values")]
    assert all(name in text for name in names)
    assert all(name.isidentifier() for name in names)


def cantilever() -> spacar.Model:
    m = spacar.Model("cantilever")
    a, b = m.node(1, (0.0, 0.0)), m.node(3, np.array([0.5, 0.0]))
    beam = m.plbeam(1, (a, 2), (b, 4), section="strip", material="steel")
    m.section("strip", "RECT", 0.001, 0.02)
    m.fix(1)
    m.fix(2)
    m.dyne(beam, 2, 3)
    m.xf(3, Fy=-0.1)
    return m


def test_a_model_runs():
    """Tip of a cantilever under F: F l^3/(3 E I); small, so that the linear formula holds to (w/l)^2."""
    result = spacar.run(7, cantilever())
    inertia = 0.02 * 0.001**3 / 12
    assert result.node(3, 2)[-1] == pytest.approx(-0.1 * 0.5**3 / (3 * 210e9 * inertia), rel=2e-3)
    assert result.mechanism.deck.source == "cantilever"


def test_a_model_is_written_and_read(tmp_path):
    path = cantilever().save(tmp_path / "beam")
    assert path == tmp_path / "beam.dat"
    assert same(spacar.read_deck(path), cantilever().deck())
    assert "BEAMSEC 1 strip steel" in path.read_text()
    assert len(repr(cantilever()).splitlines()) <= 10


def test_short_names_are_those_of_the_table():
    """A meaning that is written anew does not lose the name that users' files have of its argument."""
    meanings = {without_component(p.meaning) for row in KEYWORDS.values() for v in row.variants for p in v.parameters}
    stems = {meaning.rpartition(" ")[0] for meaning in meanings if meaning[-1].isdigit()}
    assert NAMES.keys() <= meanings | stems


def test_names_and_positions_give_the_same_row():
    def rows(fill) -> list[str]:
        m = spacar.Model()
        m.beam(1, (1, 2), (3, 4), (0, 1, 0))
        m.hinge(2, 2, 5, (0, 0, 1))
        m.plbeam(3, (6, 7), (8, 9))
        m.pltube(4, (8, 9), (10, 11))
        fill(m)
        return str(m).splitlines()[5:-1]

    pairs = [
        (lambda m: m.estiff(1, EA=1.0, EIz=4.0), "ESTIFF 1 1.0 0.0 0.0 4.0"),
        (lambda m: m.estiff(2, S1=2.0), "ESTIFF 2 2.0"),
        (lambda m: m.estiff(3, EI=2.0), "ESTIFF 3 0.0 2.0"),
        (lambda m: m.xf(2, Mx=1.0), "XF 2 1.0 0.0 0.0"),
        (lambda m: m.em(1, mass=1.0, Jyy=3), "EM 1 1.0 0.0 3"),
        (lambda m: m.em(4, mass=1.0, J=3.0), "EM 4 1.0 0.0 0.0 1.0 0 3.0"),
        (lambda m: m.em(3, mass=1.0, J=3.0), "EM 3 1.0 3.0"),
        (lambda m: m.xf(2, Mx=1.0, My=2.0, Mz=3.0), "XF 2 1.0 2.0 3.0"),
        (lambda m: m.xf(2, lambda0=1.0, lambda2=2.0), "XF 2 1.0 0.0 2.0 0.0"),
        (lambda m: m.xm(2, Jzz=2.0), "XM 2 0.0 0.0 0.0 0.0 0.0 2.0"),
        (lambda m: m.iterstep(load_steps=9), "ITERSTEP 10 9"),
        (lambda m: m.iterstep(tolerance=1e-9), "ITERSTEP 10 4 1e-09"),
        (lambda m: m.inputx_motion(1, 1, 0.0, acceleration=2.0), "INPUTX 1 1 0.0 0.0 2.0"),
    ]
    for fill, row in pairs:
        assert rows(fill) == [row], row


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        (lambda m: m.xm(6, "heavy"), "XM 6: second argument 'heavy' is not a number; expected"),
        (lambda m: m.plbeam(1, (1, 2), (3, 0)), "PLBEAM 1: q orientation node 0 must be positive"),
        (lambda m: m.plbeam(1, (1, 2), (3, 4, 5)), "PLBEAM 1: surplus argument '5'"),
        (lambda m: m.dyne(9, 4), "DYNE 9: mode 4 does not exist; element 9 (PLBEAM) has mode 1 to 3"),
        (lambda m: m.estiff(9, EIy=1.0), "ESTIFF: there is no EIy here; expected EA, EI, shear"),
        (lambda m: m.estiff(9, 1.0, EI=1.0), "ESTIFF: numbers in the order of the deck and by name (EI) at once"),
        (lambda m: m.em(1, mass=1.0, J=1.0), "EM: element number 1 must be known before it is given by name"),
        (lambda m: m.inputx_motion(1, 1, rate=1.0), "INPUTX: start value"),
        (lambda m: m.usersig("os.system"), "USERSIG os.system: first argument 'os.system' is not a name of a function"),
        (lambda m: m.fix(1, True), "FIX 1: second argument 'True' is not a number"),
        (lambda m: m.plbeam(1, (1, 2), (3, 4), section="a"), "BEAMSEC 1: too few arguments"),
        (lambda m: m.section("a", "RECT", "1\nEND"), "is not a number"),
    ],
)
def test_a_wrong_statement_is_refused_at_once(wrong, sentence):
    m = spacar.Model()
    m.plbeam(9, (31, 32), (33, 34))
    line = wrong.__code__.co_firstlineno
    with pytest.raises(InputError) as found:
        wrong(m)
    [message] = [x for x in found.value.messages if x.severity == "error"]
    assert str(message).startswith(f"error: {HERE}:{line}: ")
    assert sentence in str(message)


def test_what_is_wrong_in_the_whole_has_its_line_too():
    m = cantilever()
    line = inspect.currentframe().f_lineno + 1
    m.xf(77, 1.0)
    with pytest.raises(InputError, match=rf"{HERE}:{line}: XF: node 77 is not used by any element; nodes 1-4 exist"):
        m.deck(7)
    with pytest.raises(InputError, match=rf"{HERE}:{line}: XF: node 77"):
        spacar.run(7, m)


def test_warnings_have_their_line():
    m = cantilever()
    line = inspect.currentframe().f_lineno + 1
    m.x(88, 1.0, 2.0)
    assert [f"{x.file}:{x.line}" for x in m.deck().messages if x.severity == "warning"] == [f"{HERE}:{line}"]


def test_statements_may_come_in_any_order():
    m, n = spacar.Model(), spacar.Model()
    m.estiff(1, 8.0)
    m.fix(1)
    m.pltruss(1, 1, 2)
    m.x(2, 1.0, 0.0)
    n.pltruss(1, 1, 2)
    n.x(2, 1.0, 0.0)
    n.fix(1)
    n.estiff(1, 8.0)
    assert sorted(str(m).splitlines()) == sorted(str(n).splitlines())
    assert m.deck().first("ESTIFF").values == (1, 8.0)
