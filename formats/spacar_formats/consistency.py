"""Whether the tables of a result file fit together, before anything is looked up in them.

Checksums find bytes that were changed by accident; a file that was made or changed on purpose has right ones. Every
number that serves as an index is compared with the size of what it points into, every size with the counts (files.md
sections 4 to 6). Variables that are not there are not asked for.
"""

from collections.abc import Iterable, Mapping

import numpy as np

from spacar.modes import MODES
from spacar_formats.sbf import Record, SbfFile
from spacar_formats.sbf.record_layout import INTEGER, TEXT, require

COORDINATES = ("X", "XD", "XDD", "FX", "FXGRAV", "FXT")
DEFORMATIONS = ("E", "ED", "EDD", "SIG")
X_ROWS, E_ROWS = ("DX", "DXC", "XCOMPL", "XERR"), ("DE", "DEC")
TEXTS = ("ETYPE", "ACCWAY", "SOURCE", "SHA256", "VERSION")
COUNTS = ("NX", "NE", "NDOF", "NDDOF", "NKDOF", "NKDDOF", "NNOM", "NU", "NY", "NRBM", "NYS", "MODE", "DFT")
ROWS = ("LE", "LN", "RXYZ", "RQ", "DR0", "STIF", "EDAMP", "RL0", "KDEF")  # a row, or a number, for every element
COLUMNS = {"LNP": (4,), "LE": (6, 8), "LN": (4, 6), "RXYZ": (9,), "RQ": (9,), "NXP": (5,), "NEP": (5,)}
FINITE, LARGEST = ("RXYZ", "RQ", "RL0", "DR0"), 1e100
BY_POSITION = {"K0", "N0", "G0"}
TRIPLES = ("KTAN", "MTAN", "ASP", "BSP", "CSP")  # of large models: row, column, value
SQUARE = ("M0", "C0", "D0", "K0", "N0", "G0")


def check_tables(file: SbfFile) -> None:
    """Raises SbfError with the first contradiction."""
    tables = _Tables(file)
    tables.kinds()
    if file.kind == "sbd":
        tables.mechanism()
    elif file.kind == "sbm":
        tables.matrices()
    else:
        tables.state_space()


def _among(names: Iterable[str], records: Mapping[str, Record]) -> list[tuple[str, Record]]:
    return [(ident, records[ident]) for ident in names if ident in records]


class _Tables:
    def __init__(self, file: SbfFile) -> None:
        self.file, self.header, self.steps = file, file.header_records, file.step_records

    def require(self, right: bool, text: str) -> None:
        require(right, self.file.path, text)

    def whole(self, ident: str) -> np.ndarray | None:
        """A table of whole numbers, None when it is not there."""
        if ident not in self.header:
            return None
        self.require(self.header[ident].type != TEXT, f"{ident} is text")
        value = np.asarray(self.file.header_value(ident))
        if self.header[ident].type != INTEGER:
            self.require(bool(np.all(value == np.round(value))), f"{ident} has numbers that are not whole")
        self.require(bool(np.all(np.abs(value) <= 2**53)), f"{ident} has numbers that are too large")
        return value.astype(np.int64)

    def count(self, ident: str) -> int | None:
        value = self.whole(ident)
        return None if value is None or value.size != 1 else int(value.item())

    def kinds(self) -> None:
        for ident, record in _among(TEXTS, self.header):
            self.require(record.type == TEXT, f"{ident} is no text")
        for ident in COUNTS:
            value = self.whole(ident)
            self.require(value is None or (value.size == 1 and value.ravel()[0] >= 0), f"{ident} is no count")
        mode = self.count("MODE")
        self.require(mode is None or mode in MODES, f"there is no mode {mode}")
        for ident, record in _among((*COLUMNS, *ROWS), self.header):
            self.require(record.type != TEXT, f"{ident} is text")
        for ident, record in self.steps.items():
            self.require(record.type != TEXT, f"the step variable {ident} is text")
        if "T" in self.steps:
            self.require(self.steps["T"].size == 1, "T is not one number a step")
        for ident, record in _among(TRIPLES, self.steps):
            self.require(record.cols == 3, f"{ident} does not have three columns")

    def mechanism(self) -> None:
        nx, ne = self.count("NX"), self.count("NE")
        for ident, record in _among(COLUMNS, self.header):
            size, cols, columns = record.size, record.cols, COLUMNS[ident]
            fits = size in columns if ident in ("NXP", "NEP") else cols in columns or not size
            self.require(fits, f"{ident} has {cols} columns, {' or '.join(map(str, columns))} are needed")
        lnp, ln = self.whole("LNP"), self.whole("LN")
        self.index("LNP", lnp, nx, "coordinate")
        self.index("LE", self.whole("LE"), ne, "deformation")
        self.index("LN", ln, None if lnp is None else len(lnp), "node")
        for ident, total, of in (("NXP", nx, "NX"), ("NEP", ne, "NE")):
            parts = self.whole(ident)
            if parts is not None and total is not None:
                right = bool(np.all(parts >= 0)) and int(parts.sum()) == total
                self.require(right, f"the classes {ident} do not add up to {of} = {total}")
        elements = None if ln is None else len(ln)
        if "ETYPE" in self.header:
            lines = len(self.file.header_value("ETYPE"))
            self.require(elements in (None, lines), f"ETYPE has {lines} elements, LN {elements}")
        for ident, record in _among(ROWS, self.header):
            rows = record.size if ident in ("RL0", "KDEF") else record.rows
            self.require(elements in (None, rows), f"{ident} has {rows} rows for {elements} elements")
        for ident, _ in _among(FINITE, self.header):
            value = np.asarray(self.file.header_value(ident), float)
            self.require(bool(np.all(np.abs(value) <= LARGEST)), f"{ident} has numbers that are not finite")
        for of_steps, of_rows, total in ((COORDINATES, X_ROWS, nx), (DEFORMATIONS, E_ROWS, ne)):
            for ident, record in _among(of_steps, self.steps):
                size = record.size
                self.require(total in (None, size), f"{ident} has {size} numbers a step, {total} are needed")
            for ident, record in _among(of_rows, self.steps):
                right = total in (None, record.rows) or not record.size
                self.require(right, f"{ident} has {record.rows} rows, {total} are needed")

    def matrices(self) -> None:
        sizes = {ident: (record.rows, record.cols) for ident, record in _among(SQUARE, self.steps)}
        for ident, size in sizes.items():
            self.require(size[0] <= size[1] or not size[0] * size[1], f"{ident} is {size[0]} x {size[1]}")
            # non-holonomic: K0, N0, G0 have columns for more positions than there are velocities (M0, C0)
            beside = {s for other, s in sizes.items() if (other in BY_POSITION) == (ident in BY_POSITION)}
            rows = {s[0] for s in sizes.values()}
            self.require(len(beside) == len(rows) == 1, f"{ident} has another size than the matrices beside it")
        if "EIGVAL" in self.steps:
            self.require(self.steps["EIGVAL"].cols == 2, "EIGVAL does not have two columns")
            n = self.steps["EIGVAL"].rows
            for ident, missing in (("EIGVRE", -1), ("EIGVIM", -1), ("EIGXRE", n), ("EIGXIM", n)):
                cols = self.steps[ident].cols if ident in self.steps else missing
                self.require(cols == n, f"{ident} does not have a column for each of {n} eigenvalues")

    def state_space(self) -> None:
        steps = {ident: (record.rows, record.cols) for ident, record in self.steps.items()}
        if {"A", "B", "C"} <= set(steps):
            (n, columns), (rows, nu), (ny, width) = steps["A"], steps["B"], steps["C"]
            self.require(n == columns == rows == width, "the sizes of A, B and C do not fit together")
            self.require(steps.get("D", (ny, nu)) == (ny, nu), "the size of D does not fit to B and C")
            if "X0" in self.header:
                self.require(self.header["X0"].size == n, f"X0 has {self.header['X0'].size} numbers for {n} states")
            if "G" in steps:
                right = n % 2 == 0 and steps["G"][1] == (n // 2) ** 2
                self.require(right, "the size of G does not fit to the number of states")
            self.require(self.count("NX") in (None, n), f"NX is not the number of states, {n}")
            self.index("NYSI", self.whole("NYSI"), ny, "output")

    def index(self, ident: str, value: np.ndarray | None, last: int | None, what: str) -> None:
        if value is None or last is None or not value.size:
            return
        low, high = int(value.min()), int(value.max())
        wrong = low if low < 0 else high
        self.require(low >= 0 and high <= last, f"{ident} names {what} {wrong} of {last}")
