"""No text whatever gives anything but a deck or an InputError. 10,000 generated decks in all (slow tests), the first
fifth of them in the fast ones."""

import random
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from spacar.deck import Deck, echo, parse_deck, read_deck
from spacar.deck.keyword_table import KEYWORDS
from spacar.errors import InputError
from tests.examples import DATA

VALID = [p.read_text() for p in sorted(DATA.glob("*.dat"))]
MODES = (None, 0, 1, 2, 3, 4, 7, 8, 9, 10, "simulation")
NAMES = sorted({name for name, _ in KEYWORDS})
NUMBERS = [
    "0", "1", "2", "3", "4", "5", "7", "9", "-1", "0.", "1.", ".5", "-2.5", "1d3", "1e-300", "1e300", "-1e308", "1e308",
    "1e999", "99999999999", "nan", "inf", "1,2", "0x1", "1..2", "-",
]  # fmt: skip
ODD = [
    "END", "HALT", "END HALT", "END END", "\n", "\r", "\t", "%", "#", ";", "VISUALIZATION", "\x00", "\ufeff", "é", "ß",
    "\udce9", "O.5", "name", "_", "x" * 300,
]  # fmt: skip
WORDS = NAMES + NUMBERS * 4 + ODD

settings.register_profile(
    "fuzz", deadline=None, suppress_health_check=list(HealthCheck), database=None, derandomize=True
)
FUZZ = settings.get_profile("fuzz")
FAST = 10  # of so many examples one is tried in the fast tests; they come in the same order


def fuzz(count: int, *strategies: Any, **named: Any) -> Callable[[Callable], Callable]:
    """A property of `count` examples as a slow test NAME_many, and of the first of them as the fast test NAME."""

    def tests(f: Callable) -> Callable:
        many = settings(FUZZ, max_examples=count)(given(*strategies, **named)(f))
        globals()[f"{f.__name__}_many"] = pytest.mark.slow(many)
        return settings(FUZZ, max_examples=count // FAST)(given(*strategies, **named)(f))

    return tests


def check(text: str, mode: object) -> Deck | None:
    """Parse; a good deck must survive its own canonical text, a bad one must name its errors."""
    try:
        deck = parse_deck(text, "<deck>", mode)  # type: ignore[arg-type]
    except InputError as error:
        messages = error.messages
    else:
        survives(deck, mode)
        return deck
    assert any(m.severity == "error" for m in messages)
    assert all(str(m).isprintable() for m in messages)
    return None


def survives(deck: Deck, mode: object) -> None:
    """The canonical text reads back to the same statements; every block can be echoed."""
    again = parse_deck(deck.to_text(), "<deck>", mode)  # type: ignore[arg-type]
    assert [(s.keyword, s.values, s.block) for s in again.statements] == [
        (s.keyword, s.values, s.block) for s in deck.statements
    ]
    for block in (1, 2, 3):
        echo(deck, block)


@fuzz(1000, st.text(max_size=200), st.sampled_from(MODES))
def test_any_text(text: str, mode: object) -> None:
    check(text, mode)


@fuzz(300, data=st.binary(max_size=200))
def test_any_bytes(data: bytes, tmp_path_factory) -> None:
    file = tmp_path_factory.getbasetemp() / "fuzz.dat"
    file.write_bytes(data)
    try:
        read_deck(file)
    except InputError as error:
        messages = error.messages
    else:
        return
    assert messages


@fuzz(2700, st.integers(0, 2**63), st.sampled_from(MODES))
def test_words_in_any_order(seed: int, mode: object) -> None:
    """A cheap strategy: the seed drives a generator, so that one example costs no more than its deck."""
    rng = random.Random(seed)
    check(" ".join(rng.choices(WORDS, k=rng.randrange(60))), mode)


@fuzz(2000, st.integers(0, 2**63), st.sampled_from(MODES))
def test_plausible_statements(seed: int, mode: object) -> None:
    """Right keywords in the right block with small numbers: gets past the reader into the checks."""
    rng = random.Random(seed)
    planar = rng.random() < 0.5
    blocks: list[list[str]] = [[], [], []]
    for _ in range(rng.randrange(2, 40)):
        keyword = rng.choice(list(KEYWORDS.values()))
        variant = rng.choice(keyword.variants)
        if variant.space == ("spatial" if planar else "planar") and rng.random() < 0.9:
            continue
        words = [_word(p.kind, rng) for p in variant.parameters[: rng.choice(variant.counts)]]
        blocks[keyword.block.number - 1].append(" ".join([keyword.name, *words]))
    check("\nEND HALT\n".join("\n".join(b) for b in blocks) + "\nEND END\n", mode)


def _word(kind: str, rng: random.Random) -> str:
    if kind == "name":
        return "f"
    return (
        str(rng.randrange(1, 6)) if kind == "integer" else rng.choice(["0.", "1.", "-1.", "1e300", f"{rng.random()}"])
    )


@fuzz(4000, st.integers(0, 2**63), st.sampled_from(VALID), st.sampled_from(MODES))
def test_mutated_examples(seed: int, text: str, mode: object) -> None:
    """Words of a valid deck dropped, doubled, swapped or replaced."""
    rng = random.Random(seed)
    lines = [line.split() for line in text.splitlines()]
    for _ in range(rng.randrange(1, 4)):
        line = rng.choice(lines)
        if not line:
            continue
        i = rng.randrange(len(line))
        action = rng.randrange(5)
        if action == 0:
            del line[i]
        elif action == 1:
            line.insert(i, line[i])
        elif action == 2:
            line[i] = rng.choice(WORDS)
        elif action == 3:
            lines.remove(line)
        else:
            line.insert(i, rng.choice(WORDS))
    check("\n".join(" ".join(line) for line in lines), mode)
