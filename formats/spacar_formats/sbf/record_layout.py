"""Byte layout of the SBF container, version 1 (reference/files.md section 8), and names of variables.

A file is a preamble of 64 bytes, a directory of records of 48 bytes (header variables with their values, the
TDEF record whose `rows` are the number of committed steps, the step variables, TDAT), and step blocks of one
length (`stride`). `build` makes everything in front of the step blocks, `parse` reads and checks it. Variables have
identifiers in the file and names in MATLAB; both are accepted (section 4, messages.md section 2).
"""

import re
import struct
import zlib
from collections.abc import Container, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from spacar.deck.findings import nearest
from spacar.errors import UsageError

MAGIC = b"\x89SBF\r\n\x1a\n"
VERSION = (1, 0)
KINDS = {"sbd": 1, "sbm": 2, "ltv": 3}
KIND_NAMES = {code: name for name, code in KINDS.items()}
WRITING, COMPLETE, STOPPED = 0, 1, 2  # the state byte
STATE_AT = 13
INTEGER, REAL, TEXT = 1, 2, 3
TYPE_NAMES = {INTEGER: "integer", REAL: "real", TEXT: "text"}
DTYPES = {INTEGER: "<i8", REAL: "<f8", TEXT: "u1"}
HEADER, TDEF, STEP, TDAT = 0, 1, 2, 3  # roles

PREAMBLE = struct.Struct("<8sHHBBHQQQQQII")
RECORD = struct.Struct("<16sIIQQQ")
TRAILER = struct.Struct("<II")  # behind the variables of a step: its number, checksum
COUNT = struct.Struct("<Q")
COUNT_IN_RECORD = 24  # where `rows` is in a record
LARGEST = 2**31  # rows or columns beyond this are taken as damage

_ID = re.compile(rb"[A-Z0-9_]{1,15}")

Value = np.ndarray | float | int | str | Sequence[str]


class SbfError(UsageError):
    """The bytes of a result file are not what they should be; the text names the file, the place and the damage."""

    def __init__(self, text: str, code: str = "files.damaged") -> None:
        super().__init__(text, code)


@dataclass(frozen=True, slots=True)
class Record:
    """One entry of the directory; `offset` is absolute for header variables, inside the step block for others."""

    id: str
    type: int
    role: int
    rows: int
    cols: int
    offset: int

    @property
    def size(self) -> int:
        """Number of items (bytes for text)."""
        return self.rows * self.cols

    @property
    def length(self) -> int:
        """Bytes of the value without padding."""
        return self.size * (1 if self.type == TEXT else 8)

    @property
    def is_step(self) -> bool:
        return self.role == STEP

    def pack(self) -> bytes:
        return RECORD.pack(self.id.encode(), self.type, self.role, self.rows, self.cols, self.offset)


@dataclass(frozen=True, slots=True)
class Directory:
    """What is in front of the step blocks, checked: every offset is inside the file and in the order it must have."""

    kind: str
    state: int
    committed: int
    header: tuple[Record, ...]
    steps: tuple[Record, ...]
    tdef_offset: int
    data_offset: int
    stride: int


def padded(length: int) -> int:
    """The next multiple of 8."""
    return -(-length // 8) * 8


def check_id(name: str) -> str:
    """The identifier as stored (capitals); ValueError when it cannot be one."""
    ident = name.upper()
    if not ident.isascii() or not _ID.fullmatch(ident.encode()):
        raise ValueError(f"'{name}' is not an SBF identifier: 1 to 15 of A-Z, 0-9, _")
    return ident


def encode(value: Value) -> tuple[int, int, int, bytes]:
    """Type, rows, cols and payload (not padded) of a value.

    A number is 1 x 1, a vector of n numbers n x 1; integers and booleans become int64, real numbers float64;
    a string is one line of text, a sequence of strings one line each. ValueError for anything else.
    """
    if isinstance(value, str):
        value = [value]
    if isinstance(value, Sequence) and all(isinstance(line, str) for line in value):
        return encode_text([str(line) for line in value])
    array = np.asarray(value)
    if array.dtype.kind == "U":
        return encode_text([str(line) for line in array.ravel()])
    if array.ndim > 2 or array.dtype.kind not in "biuf":
        raise ValueError(f"cannot store an array of type {array.dtype} with {array.ndim} dimensions")
    kind = REAL if array.dtype.kind == "f" else INTEGER
    matrix = array if array.ndim == 2 else array.reshape(-1, 1)
    return kind, *matrix.shape, matrix.astype(DTYPES[kind]).tobytes(order="F")


def encode_text(lines: Sequence[str], cols: int | None = None) -> tuple[int, int, int, bytes]:
    """As `encode`; `cols` bytes per line if given, ValueError when a line is longer."""
    coded = [line.encode("utf-8", "replace") for line in lines]
    longest = max(map(len, coded), default=0)
    width = longest if cols is None else cols
    if longest > width:
        raise ValueError(f"a line of text has {longest} bytes, there is room for {width}")
    return TEXT, len(coded), width, b"".join(line.ljust(width) for line in coded)


def decode(record: Record, payload: bytes | memoryview, file: str) -> np.ndarray | list[str]:
    """Value of one variable: (rows, cols) array of int64 or float64, or the lines of a text without trailing blanks."""
    if record.type != TEXT:
        flat = np.frombuffer(payload, DTYPES[record.type], record.size)
        return flat.astype(flat.dtype.newbyteorder("=")).reshape((record.rows, record.cols), order="F")
    raw = bytes(payload)
    lines = [raw[k * record.cols : (k + 1) * record.cols] for k in range(record.rows)]
    try:
        return [line.decode("utf-8").rstrip(" ") for line in lines]
    except UnicodeDecodeError:
        raise SbfError(f"{file} is damaged: the text {record.id} is not UTF-8") from None


def build(kind: str, header: Mapping[str, Value], step_variables: Mapping[str, tuple[int, int]]) -> bytes:
    """Preamble and directory with no steps and state "being written"; all step variables are real.

    Raises ValueError for a kind, an identifier or a value that the container cannot hold.
    """
    if kind not in KINDS:
        raise ValueError(f"unknown kind of file '{kind}': one of {', '.join(KINDS)}")
    parts: list[bytes] = []
    seen: set[str] = set()
    at = PREAMBLE.size

    def unique(name: str) -> str:
        ident = check_id(name)
        if ident in seen or ident in ("TDEF", "TDAT"):
            raise ValueError(f"the identifier {ident} is used twice")
        seen.add(ident)
        return ident

    for name, value in header.items():
        kind_of, rows, cols, payload = encode(value)
        record = Record(unique(name), kind_of, HEADER, rows, cols, at + RECORD.size)
        parts += [record.pack(), payload, bytes(padded(len(payload)) - len(payload))]
        at += RECORD.size + padded(len(payload))
    tdef_offset, offset = at, 0
    parts.append(Record("TDEF", INTEGER, TDEF, 0, len(step_variables), 0).pack())
    for name, (rows, cols) in step_variables.items():
        record = Record(unique(name), REAL, STEP, int(rows), int(cols), offset)
        parts.append(record.pack())
        offset += padded(record.length)
    stride = offset + TRAILER.size
    parts.append(Record("TDAT", INTEGER, TDAT, 0, 0, stride).pack())
    body = b"".join(parts)
    return preamble(kind, WRITING, tdef_offset, stride, body) + body


def preamble(kind: str, state: int, tdef_offset: int, stride: int, body: bytes) -> bytes:
    """The first 64 bytes; `body` are the bytes from 64 up to the data offset, for their checksum."""
    data_offset = PREAMBLE.size + len(body)
    count = (data_offset - tdef_offset) // RECORD.size - 2  # without TDEF and TDAT
    fields = (MAGIC, *VERSION, KINDS[kind], 0, 0, PREAMBLE.size, tdef_offset, data_offset, stride, count)
    first = PREAMBLE.pack(*fields, directory_crc(body, tdef_offset), 0)[:60]
    ready = bytearray(first + struct.pack("<I", zlib.crc32(first)))
    ready[STATE_AT] = state  # counted as zero in the checksum, so that finishing a file is the change of one byte
    return bytes(ready)


def directory_crc(body: bytes | bytearray, tdef_offset: int) -> int:
    """CRC-32 of the directory with the number of steps taken as zero, because that number changes while writing."""
    at = tdef_offset - PREAMBLE.size + COUNT_IN_RECORD
    crc = zlib.crc32(body[:at])
    return zlib.crc32(body[at + COUNT.size :], zlib.crc32(bytes(COUNT.size), crc))


def parse(head: bytes, file: str) -> Directory:
    """Check and read what is in front of the step blocks.

    `head` are the first bytes of the file, up to the data offset (see `data_offset_of`). Raises SbfError.
    """
    (_, _, _, kind, state, _, first, tdef, data, stride, count, crc, _) = PREAMBLE.unpack_from(head)
    known = kind in KIND_NAMES and state in (WRITING, COMPLETE, STOPPED)
    require(known, file, f"kind {kind} and state {state} in the preamble are not known")
    ordered = first == PREAMBLE.size and first <= tdef <= data - 2 * RECORD.size and not tdef % 8
    require(ordered, file, "the offsets in the preamble contradict each other")
    require(directory_crc(head[PREAMBLE.size :], tdef) == crc, file, "wrong checksum of the directory")
    room = data == tdef + (2 + count) * RECORD.size
    require(room, file, f"the directory has no room for {count} step variables")
    header, at = [], first
    while at < tdef:
        record = _record(head, at, HEADER, file)
        at += RECORD.size
        inside = record.offset == at and at + padded(record.length) <= tdef
        require(inside, file, f"the value of {record.id} lies outside its place")
        header.append(record)
        at += padded(record.length)
    require(at == tdef, file, "the header variables do not end where TDEF begins")
    counter = _record(head, tdef, TDEF, file)
    require(counter.cols == count, file, f"TDEF announces {counter.cols} step variables, the preamble {count}")
    steps, offset = [], 0
    for k in range(count):
        record = _record(head, tdef + (k + 1) * RECORD.size, STEP, file)
        require(record.offset == offset, file, f"the step variable {record.id} is not at its place in the step block")
        steps.append(record)
        offset += padded(record.length)
    last, length = _record(head, data - RECORD.size, TDAT, file), offset + TRAILER.size
    require(stride == length == last.offset, file, f"the length of a step block is {length} bytes, not {stride}")
    names = [r.id for r in (*header, counter, *steps, last)]
    require(len(set(names)) == len(names), file, "an identifier occurs twice")
    return Directory(KIND_NAMES[kind], state, counter.rows, tuple(header), tuple(steps), tdef, data, stride)


def data_offset_of(head: bytes, file_size: int, file: str) -> int:
    """Data offset from the first 64 bytes, after the checks that need no more than these. Raises SbfError."""
    whole = len(head) >= PREAMBLE.size
    require(whole, file, f"it has {file_size} bytes, the preamble of an SBF file alone has {PREAMBLE.size}")
    if head[:8] != MAGIC:
        raise SbfError(f"{file} is not a SPACAR binary file: its first bytes are {head[:8].hex(' ')}", "files.not-sbf")
    (_, major, _, _, _, _, _, _, offset, _, _, _, crc) = PREAMBLE.unpack(head)
    if major != VERSION[0]:
        raise SbfError(f"{file} has version {major} of the format; this program reads version 1", "files.version")
    covered = bytearray(head[:60])
    covered[STATE_AT] = 0
    require(zlib.crc32(covered) == crc, file, "wrong checksum of the preamble")
    right = PREAMBLE.size + 2 * RECORD.size <= offset <= file_size and not offset % 8
    require(right, file, f"it has {file_size} bytes, but its steps should begin at byte {offset}")
    return offset


def _record(head: bytes, at: int, role: int, file: str) -> Record:
    require(at + RECORD.size <= len(head), file, f"the record at byte {at} is cut off")
    padded_name, kind, found, rows, cols, offset = RECORD.unpack_from(head, at)
    ident = padded_name.rstrip(b"\0")
    require(bool(_ID.fullmatch(ident)), file, f"the record at byte {at} has no valid identifier")
    name = ident.decode()
    right = kind in TYPE_NAMES and found == role
    require(right, file, f"the record {name} has type {kind} and role {found}, expected role {role}")
    named = {TDEF: "TDEF", TDAT: "TDAT"}.get(role, name)
    require(name == named, file, f"the record at byte {at} must be {named}, it is {name}")
    if role in (HEADER, STEP):
        possible = rows < LARGEST and cols < LARGEST and (kind != TEXT or cols or rows <= len(head))
        require(bool(possible), file, f"the size {rows} x {cols} of {name} is not possible")
    return Record(name, kind, role, rows, cols, offset)


def require(right: bool, file: object, what: str) -> None:
    """Raises SbfError, which names the file and the damage, where something is not right."""
    if not right:
        raise SbfError(f"{file} is damaged: {what}")


MATLAB_NAMES = {"T": "time", "FXT": "fxtot", "RQ": "rxyzq", "KDEF": "kdform", "STIF": "estiff"}
_OTHER = {ident: name.upper() for ident, name in MATLAB_NAMES.items()}
_OTHER |= {name: ident for ident, name in _OTHER.items()}
_TRANSFER = {"DX", "DE", "D2X", "D2E", "DXC", "DEC"}


def matlab_name(ident: str, kind: str = "sbd") -> str:
    """Name of the variable in MATLAB: the table, otherwise small letters; an `.ltv` file uses capitals."""
    name = ident if kind == "ltv" else MATLAB_NAMES.get(ident, ident.lower())
    return name if name[0].isalpha() else "v" + name


def identifier(name: str) -> str:
    """Identifier in the file of a MATLAB name."""
    return next((ident for ident, full in MATLAB_NAMES.items() if full == name), name.upper())


def find(name: str, ids: Container[str]) -> str | None:
    """The identifier in the file that `name` stands for (any case, either of its names), None when absent."""
    ident = name.strip().upper()
    return next((known for known in (ident, _OTHER.get(ident, ident)) if known in ids), None)


def not_found(name: str, ids: Iterable[str], file: str) -> UsageError:
    """The error for a variable that the file does not have, with the nearest name and what would store it."""
    known = {ident.lower(): ident for ident in ids}
    known |= {full: ident for ident, full in MATLAB_NAMES.items() if ident in known.values()}
    text = f"ID not found: {name} in {file}"
    near = nearest(name.strip().lower(), known, 0.5)
    if name.strip().upper() in _TRANSFER:
        text += "; transfer functions are stored on request: OUTLEVEL 0 1 (dx, de), 0 2 (d2x, d2e) or 0 3 (all)"
    elif near:
        text += f"; nearest: {near}"
    return UsageError(text, "files.id-not-found")
