"""300 hostile cases in every run of the fast tests; `make fuzz` runs the long version of the same."""

import pytest

from .cases import COMMANDS, case
from .harness import finding, sound_results

COUNTS = {"deck": 160, "file": 80, "words": 2 * len(COMMANDS), "forged": 40}


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    return sound_results(tmp_path_factory.mktemp("sound"))


@pytest.mark.parametrize("kind", COUNTS)
def test_no_case_gives_anything_but_an_answer_or_a_sentence(results, kind):
    found = {}
    for seed in range(COUNTS[kind]):
        own = case(kind, seed, results)
        if (text := finding(own)) is not None:
            found[seed] = (own.words, text)
    assert not found


def test_a_case_is_the_same_everywhere(results):
    for kind in COUNTS:
        assert case(kind, 3, results) == case(kind, 3, results)
        assert case(kind, 3, results) != case(kind, 4, results)


def test_every_subcommand_is_called():
    from spacar_cli.command_table import COMMANDS as ALL

    assert set(ALL) <= set(COMMANDS)
