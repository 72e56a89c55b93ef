"""The file of the editor keeps its bytes: line ends, byte order mark, what is no UTF-8; a change is never lost."""

import pytest
from spacar_cli.editor.edited_file import EditedFile

from spacar.deck import parse_deck
from spacar.errors import UsageError


@pytest.mark.parametrize("data", [
    b"X 1 0.\nEND\n", b"X 1 0.\r\nEND\r\n", b"\xef\xbb\xbfX 1\r\nEND", b"% caf\xe9 \xff\nEND\n", b"", b"X 1\rEND\r",
])  # fmt: skip
def test_what_was_read_is_written_again(tmp_path, data):
    path = tmp_path / "a.dat"
    path.write_bytes(data)
    file = EditedFile(path)
    read = file.read()
    assert "\r" not in read["text"]
    assert file.save(**read) == read["digest"]
    assert path.read_bytes() == data


def test_a_file_that_came_or_went_is_a_change(tmp_path):
    path = tmp_path / "a.dat"
    file = EditedFile(path)
    read = file.read()
    assert parse_deck(read["text"]).messages == ()
    path.write_text("somebody was first\n")
    with pytest.raises(UsageError, match=r"a\.dat was changed by another program"):
        file.save(**read)
    assert path.read_text() == "somebody was first\n"
    read = file.read()
    path.unlink()
    with pytest.raises(UsageError, match="was changed by another program"):
        file.save(**read)
    assert not path.exists()
