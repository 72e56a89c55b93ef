"""One mistake gives one message: what follows from an element that could not be read is not reported."""

import pytest

from spacar.deck import parse_deck
from spacar.errors import InputError

MODEL = """SPRING 1 1 2 3 4
PLBEAM 2 3 4 5 6
X 1 0. 0.
X 3 1. 0.
X 5 2. 0.
FIX 1
FIX 2
DYNE 1 1
DYNE 2 2 3
END HALT
XM 1 1.
XM 3 1.
ESTIFF 1 1. 2. 3.
EM 1 3.
XF 1 1. 2.
STARTDE 1 1 0.1
INPUTE 1 2 0.
END END
"""


def messages(text: str) -> list[str]:
    with pytest.raises(InputError) as caught:
        parse_deck(text)
    return [str(m) for m in caught.value.messages if m.severity != "information"]


@pytest.mark.parametrize(
    ("text", "sentences"),
    [
        (MODEL, ["unknown keyword 'SPRING'"]),
        ("PLTRUS 1 1 2\nX 2 1. 0.\nFIX 1\nFIX 2 2\nDYNE 1\nEND HALT\nXM 2 1.\nXF 2 1. 0.\nESTIFF 1 4.\nEND END\n",
         ["nearest: PLTRUSS"]),
        ("PLTRUSS 1 1 2\nX 2 1. 0.\nFIXX 1 1 2\nRLSE 1 2\nEND END\n",
         ["unknown keyword 'FIXX'", "mode 2 does not exist"]),
    ],
    ids=["unknown type", "the only element", "a misspelled statement takes the place of no element"],
)  # fmt: skip
def test_only_the_mistakes_are_reported(text: str, sentences: list[str]) -> None:
    found = messages(text)
    assert len(found) == len(sentences), found
    for sentence, message in zip(sentences, found, strict=True):
        assert sentence in message
