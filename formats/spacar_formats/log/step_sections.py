"""Log sections 4 and 5 for motions: states, transfer functions, integration settings, list of time steps."""

from spacar.arrays import Array
from spacar.deck.keyword_table import KEYWORDS
from spacar.deck.length_unit import shown_in
from spacar.frame import Frame
from spacar.integrators import AUTOMATIC, METHODS
from spacar.mechanism.mechanism import WITH_ADDITIONAL, Mechanism
from spacar.mechanism.numbering import Numbering
from spacar.stream import Run
from spacar_formats.log.model_sections import class_letters, coordinates, statements, variant_of
from spacar_formats.log.text_layout import ShownUnits, cell, matrix, real, shown_values, table

# Words for the counters of a frame; another name is printed as it is.
COUNTERS = {"steps": "internal steps", "rhs": "evaluations", "jacobians": "Jacobians", "rejected": "rejected"}
FIRST_ORDER, SECOND_ORDER, THIRD_ORDER, GLOBAL_DEFORMATION = 1, 2, 4, 8  # flags of OUTLEVEL position 1
PORTS = (
    "NOMS", "NOMF", "REFE", "REFEP", "REFEDP", "REFX", "REFXP", "REFXDP", "REFES", "REFXS", "INPUTS", "INPUTF", "INE",
    "INEP", "INEDP", "INX", "INXP", "INXDP", "OUTS", "OUTE", "OUTEP", "OUTEDP", "OUTF", "OUTX", "OUTXP", "OUTXDP",
)  # fmt: skip


def state(n: Numbering, frame: Frame, motion: bool = True, metre: float = 1.0) -> list[str]:
    """Transfer functions of order 0: coordinates and deformations, with their rates, forces and stresses if
    `motion`, in the unit of length of the input."""
    x_names, e_names = coordinates(n, metre)
    shown = ShownUnits.of(n, metre)
    x_class, e_class = class_letters(n)
    x_columns = [
        ("x", shown.coordinates * frame.x), ("dx/dt", shown.coordinates * frame.xd),
        ("d2x/dt2", shown.coordinates * frame.xdd), ("applied force", shown.forces * frame.fx),
        ("total force", shown.forces * frame.fxtot),
    ]  # fmt: skip
    e_columns = [
        ("e", shown.deformations * frame.e), ("de/dt", shown.deformations * frame.ed),
        ("d2e/dt2", shown.deformations * frame.edd), ("stress resultant", shown.stresses * frame.sig),
    ]  # fmt: skip
    title = "Coordinates" + f" in {shown_in('m', metre)[1]}" * (metre != 1.0)
    title += "; total force: applied force, gravity and force of supports and drives" if motion else ""
    lines = [title, "", *_columns("node", "coordinate", x_names, x_class, x_columns[: None if motion else 1]), ""]
    if n.ne:
        lines += ["Deformations (a normalization is listed with the number of its node)", ""]
        lines += _columns("element", "deformation", e_names, e_class, e_columns[: None if motion else 1])
    return [*lines, ""] if n.ne else lines


def _columns(
    owner: str, what: str, names: list[tuple[int, str]], classes: list[str], columns: list[tuple[str, Array]]
) -> list[str]:
    """One row for every component, one column for every vector."""
    values = [vector.tolist() for _, vector in columns]
    rows = [[*name, letter, *row] for name, letter, *row in zip(names, classes, *values, strict=True)]
    return table([owner, what, "class", *(head for head, _ in columns)], rows)


def transfer_functions(run: Run, frame: Frame) -> list[str]:
    """Transfer functions as far as OUTLEVEL asks for them and the analysis has them."""
    n, level = run.mechanism.numbering, run.mechanism.settings.log_level
    if not level:
        return []
    level = 15 if level < 0 else level
    x_names = [n.x_name(i) for i in range(n.nx)]
    e_names = [n.e_name(i) for i in range(n.ne)]
    columns = [f"q{i + 1}" for i in range(n.nkdof)]
    higher = level & (SECOND_ORDER | THIRD_ORDER)  # names by the square and the cube of the number: only when asked
    pairs = [f"q{i + 1} q{j + 1}" for j in range(n.nkdof) for i in range(n.nkdof)] if higher else []
    triples = [f"{pair} q{k + 1}" for k in range(n.nkdof) for pair in pairs] if level & THIRD_ORDER else []
    wanted = (
        (FIRST_ORDER, "first order transfer function of the coordinates, dx/dq", "dx", x_names, columns),
        (FIRST_ORDER, "first order transfer function of the deformations, de/dq", "de", e_names, columns),
        (SECOND_ORDER, "second order transfer function of the coordinates", "d2x", x_names, pairs),
        (SECOND_ORDER, "second order transfer function of the deformations", "d2e", e_names, pairs),
        (THIRD_ORDER, "third order transfer function of the coordinates", "d3x", x_names, triples),
        (THIRD_ORDER, "third order transfer function of the deformations", "d3e", e_names, triples),
        (GLOBAL_DEFORMATION, "derivatives of the deformation function, de/dx", "bigd", e_names, x_names),
    )
    lines = []
    for flag, title, key, names, heads in wanted:
        if level & flag:
            values = frame.log.get(key, frame.bigd if key == "bigd" else None)
            missing = values is None or not values.size
            lines.append(f"At t = {real(frame.t)}: {title}" + (": not computed in this mode" if missing else ""))
            lines += [""] if values is None or missing else ["", *matrix(values, names, heads)]
    return lines


def integration(mechanism: Mechanism, evaluated_by: tuple[str, str] | None) -> list[str]:
    s = mechanism.settings
    method = METHODS.get(s.integrator)
    lines = [f"Integrator: INTEGRAT {s.integrator}, {method.name if method else 'unknown'}"]
    if s.integrator == AUTOMATIC:
        lines.append("It starts with INTEGRAT 0; the end of this log says when it changed, if it did")
    lines.append(f"Error tolerances: absolute {real(s.atol)}, relative {real(s.rtol)}")
    if s.step is not None:
        lines.append(f"Step size (fixed, or the first one): {real(s.step)} s")
    if s.duration is None:
        lines.append("No TIMESTEP: only the initial state is analysed")
    else:
        lines.append(f"Duration {real(s.duration)} s in {s.n_steps} output steps")
    return [*lines, *engine(evaluated_by), ""]


def engine(found: tuple[str, str] | None) -> list[str]:
    """Which engine evaluates, on what level or why."""
    return [] if found is None else [f"Engine: {found[0]} ({found[1]})"]


def iteration(mechanism: Mechanism) -> list[str]:
    s = mechanism.settings
    initial = s.initial_steps or (1 if s.stationary_type in WITH_ADDITIONAL else s.load_steps)
    rows: list[list[object]] = [
        ["maximum number of iterations", s.max_iterations], ["number of load steps", s.load_steps],
        ["error tolerance", float(s.tolerance)], ["load steps between stored steps", s.store_every],
        ["type of analysis", s.stationary_type], ["load steps of the initial solution", initial],
        ["beyond limit points", "yes" if s.follow_path else "no"],
    ]  # fmt: skip
    return [*table(["stationary solution (ITERSTEP)", "value"], rows), ""]


def definitions(mechanism: Mechanism) -> list[str]:
    """Trajectories in their order, then inputs and outputs of the third block."""
    kind = mechanism.deck.third
    if kind is None:
        return []
    n, rows = mechanism.numbering, []
    for s in mechanism.deck.statements:
        if s.block == 3 and s.keyword not in PORTS:
            keyword = KEYWORDS[s.keyword, kind]
            given = shown_values(s, keyword.variants[variant_of(n, keyword, s)], n, mechanism.deck.metre)
            rows.append([s.keyword, " ".join(map(cell, given)), keyword.help])
    lines = [*table(["trajectory", "values", "meaning"], rows), ""] if rows else []
    for name in PORTS:
        lines += statements(mechanism, name, kind)
    return lines


class StepList:
    """The list of stored steps, one line each; a heading is printed again when the counters change."""

    def __init__(self) -> None:
        self._counters: tuple[str, ...] | None = None
        self._form = ""
        self._step = 0

    def line(self, frame: Frame) -> str:
        """The text for one step, with a heading in front where one is due."""
        self._step += 1
        counters = tuple(frame.statistics)
        head = ""
        if counters != self._counters:
            self._counters = counters
            heads = [COUNTERS.get(name, name.replace("_", " ")) for name in counters]
            widths = [max(len(head), 10) for head in heads]
            columns = "".join(f"  {h:>{w}}" for h, w in zip(heads, widths, strict=True))
            head = f"{'step':>8}  {'time [s]':>17}{columns}\n"
            self._form = "%8d  %17.10g" + "".join(f"  %{w}.7g" for w in widths)
        return head + self._form % (self._step, frame.t, *frame.statistics.values())
