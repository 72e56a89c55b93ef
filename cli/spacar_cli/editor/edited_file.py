"""The input file of the editor: read, and written only over what was read.

The page has lines that end with \\n; the file keeps its line ends, its byte order mark and bytes that are no UTF-8.
"""

from hashlib import sha256
from pathlib import Path
from typing import Any

from spacar_formats.safety import replacing

from spacar.errors import UsageError
from spacar_cli.input_files import result_stem

MARK = "\ufeff"
EXAMPLE = """% A pendulum of 1 m swings from the horizontal [m, kg, s, N]
PLBEAM 1  1 2  3 4     % a beam from point 1 with angle 2 to point 3 with angle 4
X 1  0.0  0.0          % start positions
X 3  1.0  0.0
FIX 1                  % the bearing does not move
DYNX 2 1               % the angle is a degree of freedom
END
HALT
EM 1  0.5              % mass of the beam per length
GRAVITY 0.0 -9.81
TIMESTEP 2.0 100       % 2 s in 100 steps
END
END
"""


def result_file(path: Path, kind: str) -> Path:
    """Where a run of an input file writes a result, or its log."""
    stem = result_stem(path, None)
    return stem.with_name(f"{stem.name}.{kind}")


class EditedFile:
    """One file; `read` and `save` exchange digests (of the bytes; empty: there is no file) with the page."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def digest(self) -> str:
        data = self._bytes()
        return "" if data is None else sha256(data).hexdigest()

    def read(self) -> dict[str, Any]:
        """text with \\n, or a short example where there is no file; digest; newline: how lines end; marked: whether a
        byte order mark begins it. Raises UsageError."""
        data = self._bytes()
        if data is None:
            return {"text": EXAMPLE, "digest": "", "newline": "\n", "marked": False}
        text = data.decode("utf-8", "surrogateescape")
        newline = next((end for end in ("\r\n", "\n", "\r") if end in text), "\n")
        lines = text.removeprefix(MARK).replace("\r\n", "\n").replace("\r", "\n")
        digest = sha256(data).hexdigest()
        return {"text": lines, "digest": digest, "newline": newline, "marked": text.startswith(MARK)}

    def save(self, text: str, digest: str, newline: str, marked: bool) -> str:
        """Replace the file as a whole; returns its new digest.

        Raises UsageError when it is not the one with this digest (edit.changed), and when it cannot be written.
        """
        if self.digest() != digest:
            raise UsageError(f"{self.path.name} was changed by another program", "edit.changed")
        end = newline if newline in ("\n", "\r\n", "\r") else "\n"
        data = (MARK * marked + text.replace("\n", end)).encode("utf-8", "surrogateescape")
        with replacing(self.path) as side:
            side.write_bytes(data)
        return sha256(data).hexdigest()

    def _bytes(self) -> bytes | None:
        try:
            return self.path.read_bytes()
        except FileNotFoundError:
            return None
        except OSError as error:
            raise UsageError(f"cannot read {self.path}: {error.strerror or error}", "files.not-readable") from None
