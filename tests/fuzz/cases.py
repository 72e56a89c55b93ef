"""Hostile input from a seed: the same number gives the same case on every machine.

Four kinds: `deck` (a changed example model, run in a mode), `file` (a damaged or forged result, given to a reader),
`words` (a command line of odd words for every subcommand), `forged` (`forged.py`).
"""

# ruff: noqa: E501  (tables of odd words)

import random
import struct
import tempfile
import zlib
from dataclasses import dataclass
from pathlib import Path

from tests.examples import DATA

from .forged import forged

MODES = ("0", "1", "2", "4", "7", "8", "9", "10", "check")
NUMBERS = [
    "0", "1", "-1", "2", "3", "4", "7", "99", "1000000", "-5", "0.", "1.", ".5", "-2.5", "1e-3", "1e3", "1e8",
    "-1e12", "1e50", "-1e90", "1e99", "1e-99", "1e101", "1e150", "1e308", "1e309", "1e-320", "1d5", "nan", "inf",
    "1,2", "0x1", "1..2", "-", "99999999999", "1e18", "9007199254740993",
]  # fmt: skip
WORDS = [
    "PLBEAM", "PLTRUSS", "PLTOR", "PLRBEAM", "PLWHEEL", "PLBELT", "BEAM", "TRUSS", "HINGE", "WHEEL", "TUBE", "SCREW",
    "X", "FIX", "RLSE", "DYNE", "DYNX", "INPUTX", "INPUTE", "XM", "EM", "ESTIFF", "EDAMP", "ESIG", "XF", "GRAVITY",
    "TIMESTEP", "ERROR", "INTEGRAT", "STARTDE", "STARTDX", "OUTLEVEL", "TRAJECT", "TRTIME", "LDEFORM", "USERSIG",
    "ITERSTEP", "END", "HALT", "VISUALIZATION", "%", "#", ";", "q", "\x1b[31m", "�", "\x00", "é", "KKKK",
]  # fmt: skip
NAMES = ["", ".", "..", "/", "crank", "lever", "lateral4", "robotinv", "nothing", "crank.sbd", "crank.dat", "crank.log",
         "a\x1b[31mb", "\udcff", "x" * 300, "-", "--", "/dev/null", "/proc/self/mem", "folder", "é"]  # fmt: skip
VALUES = ["0", "1", "-1", "2", "3", "99", "1e3", "1e-3", "nan", "inf", "-inf", "1e400", "9" * 400, "end", "all", "1:3", "3:1",
          "1:0:3", "1:1:1e9", "x[6,1]", "x[1,99]", "1/0", "9**9**9", "t*", "sig[1,1]", "(" * 200, "[1,2", "NaN", "[[1],[2,3]]",
          '"text"', "CIRC 1e400", "RECT 1 1", "$\\frac{$", "iso", "1,2,3", "0,0", "XM.6=1:2:3", "XM.6=1:2:1000000000",
          "EM.2=@nothing.csv:a", "a.png", "a.svg", "a.csv", "a.json", "a.npz", "a.mat", "a.gif", "folder/a.png", "no/a.png",
          "a\x00b", "\x1b[2J", "T", "NX", "LNP", "x" * 3000]  # fmt: skip
COMMANDS: dict[str, tuple[int, tuple[str, ...]]] = {  # arguments, options; never those that open windows
    "1": (1, ("--steps", "--time", "--atol", "--rtol", "--integrator", "--output-dir", "-v!", "--json!")),
    "0": (1, ("-v!", "--json!", "--output-dir")), "7": (1, ("--json!",)), "9": (1, ("--json!",)),
    "3": (1, ("--setpoints",)), "check": (1, ("--mode", "--json!")), "keywords": (1, ("--json!", "--to")),
    "edit": (3, ()),  # too many words: with one it serves until it is ended
    "examples": (1, ("--output-dir", "--overwrite!")), "help": (1, ()),
    "sweep": (1, ("--set", "--from", "--result", "--mode", "--steps", "--time", "--output", "--zip!", "--batch!", "--json!")),
    "trade": (1, ("--integrators", "--tolerances", "--substeps", "--elements", "--target", "--steps", "--time", "-o")),
    "draw": (1, ("-o", "--at", "--strobe", "--trace", "--view", "--section", "--opacity", "--hide", "--title", "--dpi")),
    "visual": (2, ("-o", "--at", "--title", "--dpi", "--view")),
    "stress": (1, ("--at", "--element", "--points", "--csv", "-o", "--json!")),
    "plot": (2, ("-o", "--against", "--csv", "--title", "--dpi")), "report": (1, ("--output", "--plot", "--log-lines")),
    "checksbf": (1, ("--json!",)), "getfrsbf": (3, ("--json!",)), "repinsbf": (3, ("--at",)),
    "loadsbd": (2, ("--to", "--output")), "loadsbm": (2, ("--to", "--output")), "combsbd": (3, ("--overwrite!",)),
    "eigen": (1, ("--at", "--lowest", "--json!")), "bode": (1, ("--at", "--input", "--output", "--low", "--high", "--points")),
    "compliance": (2, ("--at", "--json!")), "getss": (2, ("--output", "--json!")), "sim": (1, ("--output",)),
    "ltv": (1, ("--substeps", "--modes", "--output")), "mrltv": (2, ("--quasi-static", "--output")),
    "spacntrl": (1, ("--omega", "--damping", "--output")), "matlab": (0, ()),
    "flexure": (1, ("--move", "--force", "--node", "--steps", "--modes", "--axes", "--csv", "-o", "--json!")),
    "sensitivity": (1, ("-p", "--of", "--csv", "--json!", "--beams")), "view": (1, ("-o", "--frames", "--fps", "--view")),
    "completion": (1, ()), "fmu": (1, ("--output",)), "symbolic": (2, ("--set", "--time", "--steps", "--language")),
}  # fmt: skip
READERS = (
    ("checksbf", "F"), ("checksbf", "F", "--json"), ("draw", "F", "-o", "x.png"), ("report", "F", "-o", "x.html"),
    ("plot", "F", "x[2,1]", "--csv", "-"), ("compliance", "F", "2"), ("visual", "F", "-o", "x.svg"), ("eigen", "F"),
    ("bode", "F", "--csv", "-"), ("getss", "F"), ("mrltv", "F", "1", "-o", "y.ltv"), ("ltv", "F", "-o", "y.npz"),
    ("spacntrl", "F", "--omega", "3", "--damping", "1"), ("loadsbd", "F"), ("getfrsbf", "F", "x", "end"),
    ("combsbd", "F", "F", "z", "--overwrite"), ("repinsbf", "F", "T", "1", "--at", "1"),
)  # fmt: skip


@dataclass(frozen=True)
class Case:
    """Files to write (name: bytes) and the command line to run in their folder."""

    kind: str
    seed: int
    files: dict[str, bytes]
    words: tuple[str, ...]


def case(kind: str, seed: int, results: dict[str, bytes]) -> Case:
    """The case of a number; `results` are sound result files by name."""
    rng = random.Random(f"{kind} {seed}")
    return {"deck": _deck, "file": _file, "words": _words, "forged": _forged}[kind](rng, seed, results)


def _forged(rng: random.Random, seed: int, results: dict[str, bytes]) -> Case:
    with tempfile.TemporaryDirectory() as folder:
        files, words = forged(rng, (DATA / "crank.dat").read_bytes(), Path(folder))
    return Case("forged", seed, files, words)


def _deck(rng: random.Random, seed: int, results: dict[str, bytes]) -> Case:
    if seed % 20 == 19:
        return _model(rng, seed)
    source = rng.choice(sorted(DATA.glob("*.dat")))
    lines = source.read_text().splitlines()
    for _ in range(rng.choice((1, 1, 1, 2, 3, 6))):
        k = rng.randrange(len(lines)) if lines else 0
        words = lines[k].split() if lines else []
        what = rng.randrange(7)
        if what == 0 and words:
            words[rng.randrange(len(words))] = rng.choice(NUMBERS)
        elif what == 1 and len(words) > 1:
            words[rng.randrange(1, len(words))] = rng.choice(NUMBERS)
        elif what == 2 and words:
            words.pop(rng.randrange(len(words)))
        elif what == 3:
            words.insert(rng.randint(0, len(words)), rng.choice((*NUMBERS, *WORDS)))
        elif what == 4 and lines:
            lines.insert(rng.randrange(len(lines)), lines[k])
            continue
        elif what == 5 and lines:
            lines.pop(k)
            continue
        elif words:
            words[0] = rng.choice(WORDS)
        if lines:
            lines[k] = " ".join(words)
    text = "\n".join(lines).encode("utf-8", "surrogateescape")
    if rng.random() < 0.02:
        text = text[: rng.randrange(len(text) + 1)]
    mode = rng.choice(MODES)
    extra = ("--steps", "20") if mode in ("1", "4") and rng.random() < 0.5 else ()
    return Case("deck", seed, {"F.dat": text}, (mode, "F", *extra))


def _model(rng: random.Random, seed: int) -> Case:
    """A changed .toml model (symbolic check) or .sim model."""
    toml = rng.random() < 0.7
    source = DATA / ("symbolic/manipulator.toml" if toml else "robotsim.sim")
    text = source.read_text()
    for _ in range(rng.choice((1, 1, 2, 4))):
        a = rng.randrange(len(text))
        piece = rng.choice(
            (*NUMBERS, "'", '"', "[", "]", "{", "=", "\n", "\x1b", "name", "q1", "**9**9", "[[body]]", "inf")
        )
        text = text[:a] + piece + text[a + rng.randrange(6) :]
    name = "F.toml" if toml else "F.sim"
    return Case("deck", seed, {name: text.encode()}, ("symbolic", "check", name) if toml else ("sim", "F"))


def _file(rng: random.Random, seed: int, results: dict[str, bytes]) -> Case:
    names = sorted({name.rpartition(".")[0] for name in results})
    stem = rng.choice(names)
    own = {f"F.{name.rpartition('.')[2]}": data for name, data in results.items() if name.rpartition(".")[0] == stem}
    victim = rng.choice(sorted(own))
    own[victim] = _damaged(rng, own[victim])
    return Case("file", seed, own, tuple(w.rstrip("!") for w in rng.choice(READERS)))


def _damaged(rng: random.Random, raw: bytes) -> bytes:
    out = bytearray(raw)
    data = struct.unpack_from("<Q", out, 32)[0]
    what = rng.randrange(6)
    if what == 0:
        return bytes(out[: rng.randrange(len(out) + 1)])
    if what == 1:
        for _ in range(rng.choice((1, 1, 8, 64))):
            out[rng.randrange(len(out))] = rng.randrange(256)
        return bytes(out)
    if what == 2:
        return bytes(out) + rng.randbytes(rng.randrange(1000))
    # right checksums over wrong numbers: in the directory, in a header value, in a step
    stride = struct.unpack_from("<Q", out, 40)[0]
    for _ in range(rng.choice((1, 1, 2, 5))):
        at = rng.randrange(64, max(data, 72)) & ~7 if what < 5 else min(data + 8 * rng.randrange(40), len(out) - 16)
        value = rng.choice((0, 1, 2, 3, 7, 255, 10**6, 2**31, 2**63 - 1, 2**64 - 1, 0x7FF0 << 48, 0x7FF8 << 48))
        struct.pack_into("<Q", out, max(at, 64), value)
    return repaired(bytes(out), stride)


def repaired(raw: bytes, stride: int = 0) -> bytes:
    """The same bytes with right checksums, those of steps of `stride` bytes too, as far as the offsets allow."""
    out = bytearray(raw)
    tdef, data = struct.unpack_from("<QQ", out, 24)
    if 64 <= tdef <= data - 48 and data <= len(out):
        body = bytearray(out[64:data])
        body[tdef - 64 + 24 : tdef - 64 + 32] = bytes(8)
        struct.pack_into("<I", out, 56, zlib.crc32(body))
        for end in range(data + stride, len(out) + 1, stride) if stride >= 8 else ():
            struct.pack_into("<I", out, end - 4, zlib.crc32(bytes(out[end - stride : end - 4])))
    covered = bytearray(out[:60])
    covered[13] = 0
    struct.pack_into("<I", out, 60, zlib.crc32(covered))
    return bytes(out)


def _words(rng: random.Random, seed: int, results: dict[str, bytes]) -> Case:
    command = sorted(COMMANDS)[seed % len(COMMANDS)]
    count, options = COMMANDS[command]
    words = [command]
    if command == "symbolic":
        words.append(rng.choice(("check", "export", "nothing")))
    for k in range(max(0, count + rng.choice((0, 0, 0, 0, -1, 1)))):
        words.append(rng.choice(NAMES if k == 0 or rng.random() < 0.2 else VALUES))
    for _ in range(rng.randrange(4) if options else 0):
        option = rng.choice(options)
        words += (
            [option[:-1]] if option.endswith("!") else [option, rng.choice(VALUES if rng.random() < 0.8 else NAMES)]
        )
    decks = {f"{name}.dat": (DATA / f"{name}.dat").read_bytes() for name in ("crank", "lever", "lateral4", "robotinv")}
    return Case("words", seed, {**decks, **results, "folder/x": b""}, tuple(words))
