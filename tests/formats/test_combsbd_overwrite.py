"""combsbd: the original overwrites the output without warning; this one says why it does not."""

from __future__ import annotations

import pytest
from spacar_formats.combsbd import combsbd

from spacar.errors import UsageError


def test_the_refusal_says_what_the_original_does_and_what_to_do(tmp_path):
    output = tmp_path / "all.sbd"
    output.write_bytes(b"kept")
    with pytest.raises(UsageError) as caught:
        combsbd([tmp_path / "a", tmp_path / "b"], output)
    for words in ("all.sbd exists", "the original overwrites", "--overwrite"):
        assert words in str(caught.value)
    assert output.read_bytes() == b"kept"
