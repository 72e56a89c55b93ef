"""The result files as consumers of a stream of frames (reference/files.md sections 4, 5, 6, 9).

A sink is started with the run, gets every frame, and is finished with the error that ended the run, or None.
Its file grows under the name `NAME.part`; only a run that came to its end gives it the final name. Header variables are
what a run knows with its first step (section 3).
"""

from collections.abc import Callable, Container, Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

import spacar
from spacar.frame import Frame
from spacar.mechanism.result_tables import counts, model_tables
from spacar.stream import Run
from spacar_formats.safety import Claim
from spacar_formats.sbf import SbfWriter
from spacar_formats.sbf.record_layout import identifier

Header = Callable[[Run, Container[str]], Mapping[str, Any]]  # of a run and the names of its step variables
STATE = ("x", "xd", "xdd", "fx", "fxgrav", "e", "ed", "edd", "sig")
OPTIONAL = ("dx", "de", "dxc", "dec", "d2x", "d2e", "bigd", "bigds", "xcompl", "xerr")


class ResultSink:
    """One result file. The first frame decides which variables are stored: every frame of a run has the same ones.

    Raises UsageError when the file cannot be written, AnalysisError when the disk refuses bytes during the run.
    """

    def __init__(self, claim: Claim, header: Header, values: Callable[[Frame], dict[str, Any]]) -> None:
        self.path = claim.final
        self.claim = claim
        self._header, self._values = header, values
        self._run: Run | None = None
        self._writer: SbfWriter | None = None

    @property
    def written_to(self) -> Path | None:
        """The file that holds the frames now; None when there was no frame."""
        if self._writer is None:
            return None
        return self.claim.part if self.claim.part.exists() else self.path

    def start(self, run: Run) -> None:
        self._run = run

    def frame(self, frame: Frame) -> None:
        values = self._values(frame)
        if self._writer is None:
            assert self._run is not None
            self._writer = _writer(self.claim, self._header(self._run, values), values)
        self._writer.append(values)

    def finish(self, error: BaseException | None) -> None:
        if self._writer is not None:
            self._writer.close(complete=error is None)
            if error is None:
                self.claim.publish()


@contextmanager
def result_sinks(stem: Path, kinds: tuple[str, ...], wait: bool = False) -> Iterator[list[ResultSink]]:
    """The sinks `stem.sbd`, `stem.sbm`, `stem.ltv` of a mode, claimed for this run; `begin` starts their files.

    Raises UsageError when another run is writing one of them (with `wait`: waits for it) or the folder cannot be used.
    """
    with ExitStack() as claims:
        yield [
            ResultSink(claims.enter_context(Claim(stem.with_name(f"{stem.name}.{kind}"), wait)), *KINDS[kind])
            for kind in kinds
        ]


def begin(sinks: Iterable[ResultSink]) -> None:
    """Move the results of an earlier run to `.bak` and start new files. Raises UsageError."""
    for sink in sinks:
        sink.claim.begin()


def write_steps(claim: Claim, header: Mapping[str, Any], steps: Iterator[Mapping[str, Any]]) -> Path:
    """A whole result file, the first of whose steps says the sizes of its variables; an earlier one becomes `.bak`.

    Raises UsageError when it cannot be written, AnalysisError when the disk refuses bytes.
    """
    claim.begin()
    first = next(steps)
    with _writer(claim, header, first) as writer:
        for values in chain([first], steps):
            writer.append(values)
    claim.publish()
    return claim.final


def _writer(claim: Claim, header: Mapping[str, Any], values: Mapping[str, Any]) -> SbfWriter:
    """The file of a claim, whose step variables have the sizes of these values."""
    shapes = {name: _shape(value) for name, value in values.items()}
    return SbfWriter(claim.part, claim.final.suffix[1:], header, shapes, claim.open())


def sbd_values(frame: Frame) -> dict[str, Any]:
    """Step variables of the `.sbd`; FXT is the MATLAB variable fxtot."""
    values: dict[str, Any] = {"T": frame.t}
    values |= {name.upper(): getattr(frame, name) for name in STATE}
    values["FXT"] = frame.fxtot
    for name in OPTIONAL:
        value = getattr(frame, name)
        if value is not None:
            values[name.upper()] = value
    return values


def sbm_values(frame: Frame) -> dict[str, Any]:
    """Time and the matrices of the linearized equations, as far as the mode computes them."""
    return {"T": frame.t} | {name.upper(): value for name, value in frame.matrices.items()}


def ltv_values(frame: Frame) -> dict[str, Any]:
    """Time and the state space; a matrix without rows or columns (no inputs, no outputs) is not produced."""
    return {"T": frame.t} | {n.upper(): v for n, v in frame.state_space.items() if np.size(v)}


def provenance(run: Run) -> dict[str, Any]:
    """Which program, from which input: the text variables of files.md section 9."""
    deck = run.mechanism.deck
    return {
        "VERSION": f"spacar {spacar.__version__}", "SOURCE": deck.source, "SHA256": deck.sha256,
        "MODE": run.mode.number,
    }  # fmt: skip


def sbd_header(run: Run, stored: Container[str] = ()) -> dict[str, Any]:
    """Everything of files.md section 4 that does not change with time."""
    n = run.mechanism.numbering
    keywords = [n.keyword.get(i, "") for i in range(1, len(n.le) + 1)]
    tables = {identifier(name): value for name, value in model_tables(run.mechanism).items()}
    header = provenance(run) | {"ETYPE": keywords}
    if (found := run.header.get("accuracy")) is not None:  # estimated error, error asked for (0: none), cost; in words
        header["ACCURACY"] = np.array([found.estimate, found.target or 0.0, found.cost])
        header["ACCWAY"] = [found.way]
    return header | tables


def sbm_header(run: Run, stored: Container[str] = ()) -> dict[str, Any]:
    """Sizes of the matrices (files.md section 5)."""
    sizes = {name.upper(): value for name, value in counts(run.mechanism.numbering).items()}
    return provenance(run) | sizes | {"NNOM": int(run.header.get("NNOM", 0))}


def ltv_header(run: Run, stored: Container[str]) -> dict[str, Any]:
    """Sizes, indices, initial state, names of the signals (files.md section 6); DFT: whether D is stored."""
    header = provenance(run) | {"NNOM": 0, "NU": 0, "NY": 0}
    if "A" in stored:
        header["DFT"] = int("D" in stored)
    header |= {ident: run.header[ident] for ident in LTV_COUNTS if ident in run.header}
    linear = "A" in stored or "ASP" in stored
    names = {"UNAMES": run.header.get("inputs"), "YNAMES": run.header.get("outputs")}
    if linear:
        names["XNAMES"] = run.header.get("states") or run.mechanism.numbering.state_names
    return header | {ident: list(lines) for ident, lines in names.items() if lines}


KINDS: dict[str, tuple[Header, Callable[[Frame], dict[str, Any]]]] = {
    "sbd": (sbd_header, sbd_values), "sbm": (sbm_header, sbm_values), "ltv": (ltv_header, ltv_values),
}  # fmt: skip


def _shape(value: Any) -> tuple[int, int]:
    """Rows and columns as stored: a number 1 x 1, a vector as a column."""
    rows, cols = (*np.shape(value), 1, 1)[:2]
    return rows, cols


LTV_COUNTS = ("NNOM", "NX", "NU", "NY", "NRBM", "NYS", "NYSI", "DFT", "X0")
