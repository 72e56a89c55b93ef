"""Files that somebody else wrote or changed: rows of studies, text in headers of results, deep TOML, odd names."""

import json
import random
from pathlib import Path

import numpy as np
from spacar_formats.signal_tables import table_of_arrays, write_table

COLUMNS = ("case", "XM.6", "tip", "status", "seconds", "reason")
ROWS = (
    ("0123456789abcdef", "1.0", "0.5", "done", "0.01", ""),
    ("fedcba9876543210", "2.0", "", "failed", "0.01", "why"),
)
CSV = "".join(",".join(row) + "\n" for row in (COLUMNS, *ROWS)).encode()
JSON = "".join(json.dumps(dict(zip(COLUMNS, row, strict=True))) + "\n" for row in ROWS).encode()
PIECES = (
    b"", b"\n", b"\r\n", b"\xef\xbb\xbf", b"\xe9", b"\x00", b'"', b",", b";", b"\t", b"," * 2000, b"x" * 140_000,
    b"=1+1", b"{}", b"[" * 5000, b'{"a":' * 5000, b"9" * 5000, b"null", b"\xff\xfe", b"case", "\u2028".encode(),
)  # fmt: skip
SCOPE = {"title": "t", "unit": "m", "labels": ["a", "b"], "columns": [1, 2]}
ODD = (0, -1, 3, 2**63, 1.5, True, None, "", "\x1b[2J", [], ["a"], [[1], 2], {}, {"a": 1}, "x" * 5000, [1] * 5000)
NAMES = ("=cmd:x[6,1]@end", "@a:x[6,1]@end", "a\x1b[2J:x[6,1]@end", "a,b\n:x[6,1]@end", "é" * 3000 + ":x[6,1]@end",
         "case:x[6,1]@end", "XM.6:x[6,1]@end", ":x[6,1]@end")  # fmt: skip
DEEP = ("a." * 5000 + "a = 1", "[" + "a." * 5000 + "a]\nb = 1", "a = " + "[" * 5000, "a = " + "{b=" * 5000,
        "[[" + "a." * 400 + "a]]\nb = 1", '"\\u001b" = 1', '"=a" = 1')  # fmt: skip
Files = dict[str, bytes]


def forged(rng: random.Random, crank: bytes, folder: Path) -> tuple[Files, tuple[str, ...]]:
    """Files and a command line."""
    what = rng.randrange(8)
    if what < 4:
        name = rng.choice(("r.csv", "r.jsonl"))
        data = _changed(rng, rng.choice((CSV, JSON)) if rng.random() < 0.1 else CSV if name == "r.csv" else JSON)
        words = ("sweep", "F", "--set", "XM.6=1,2", "-r", "tip:x[6,1]@end", "--steps", "1", "-o", name)
        return {"F.dat": crank, name: data}, words
    if what == 4:
        rows = rng.choice(("r.csv", "r.jsonl"))
        return {"F.dat": crank}, ("sweep", "F", "--set", "XM.6=1", "-r", rng.choice(NAMES), "--steps", "1", "-o", rows)
    if what == 5:
        stem = rng.choice(("a" * 240, "a" * 251, "\u00e9" * 120, "=a", "a b"))
        return {f"{stem}.dat": crank}, ("1", stem, "--steps", "1")
    if what == 6:
        text = "\n".join(rng.sample(DEEP, rng.choice((1, 2))))
        return {"F.toml": text.encode()}, ("symbolic", "check", "F.toml")
    reader = rng.choice((("report", "F", "-o", "x.html"), ("checksbf", "F"), ("loadsbd", "F")))
    return {"F.sbd": _signals(rng, folder)}, reader


def _changed(rng: random.Random, data: bytes) -> bytes:
    for _ in range(rng.choice((1, 1, 2, 4))):
        a = rng.randrange(len(data) + 1)
        data = data[:a] + rng.choice(PIECES) + data[a + rng.choice((0, 0, 1, 5, 1000)) :]
    return data


def _signals(rng: random.Random, folder: Path) -> bytes:
    """A sound container with other text in SCOPES and SIGNAME."""
    table = table_of_arrays({"plant": (("a", "b"), np.arange(6.0).reshape(3, 2))})
    scopes = [json.dumps(SCOPE | {rng.choice([*SCOPE]): rng.choice(ODD)}) for _ in range(rng.choice((1, 2)))]
    if rng.random() < 0.3:
        scopes[0] = rng.choice((*map(str, ODD), "[" * 5000, "{}", "9" * 5000))
    header = table.header() | {"SCOPES": scopes}
    if rng.random() < 0.2:
        header["SIGNAME"] = rng.choice((["a"], ["a\tb"] * 5, ["\x1b[2J\tb", "c"], []))

    class Forged(type(table)):  # type: ignore[misc]
        def header(self) -> dict[str, object]:
            return header

    path = write_table(folder / "F", [0.0, 1.0, 2.0], Forged(table.blocks, table.names, table.values), Path("F.sim"))
    return path.read_bytes()
