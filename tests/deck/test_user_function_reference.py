"""`spacar keywords` tells what a user of USERSIG and DRPINBOD must know."""

from spacar.deck.keyword_table import KEYWORDS
from spacar.deck.table_types import BlockKind


def test_rows_and_places_of_user_functions_are_documented() -> None:
    text = " ".join(KEYWORDS["USERSIG", BlockKind.DYNAMICS].notes)
    for words in ("element number, mode number, stress", "node number, coordinate number, force", "le[i - 1, m - 1]",
                  "lnp[n - 1, c - 1]", "-1 for what does not exist", "dsigma/de",
                  "fixed or prescribed mode"):  # fmt: skip
        assert words in text


def test_start_values_with_drpinbod_are_documented() -> None:
    assert "counted from these projections" in " ".join(KEYWORDS["DRPINBOD", BlockKind.KINEMATICS].notes)
