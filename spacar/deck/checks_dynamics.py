"""Checks of the dynamics block: masses and stiffnesses, prescribed motion, solver settings, additional loading."""

from spacar.deck.check_material import CheckMaterial, check_ranges, one_of
from spacar.deck.statement import Statement, StatementGroup
from spacar.deck.table_solvers import INTEGRATOR_ALIASES, INTEGRATORS, alias_note

_SIGNS = {"XM": "mass or inertia", "EM": "mass", "ESTIFF": "stiffness", "EDAMP": "damping", "MEE": "mass"}
READ_AS = {
    3: "three {} are read as a moment about the global axes",
    4: "four {} are read as forces dual to lambda0 ... lambda3",
}
_SETTINGS = ("TIMESTEP", "INTEGRAT", "ERROR", "ITERSTEP", "MODES", "XGYRO")
_ADDITIONAL = ("DELXF", "DELGRAV", "DELOMF", "DELESIG", "DELINPX", "DELINPE")


def check_dynamics(scene: CheckMaterial) -> None:
    """Everything that concerns the dynamics block beyond single statements; only what it has is looked at."""
    given, classed, traits = scene.index.keywords(2), scene.index.keywords(1), scene.outline.traits
    for group in scene.index.groups_of(*_SIGNS, block=2):
        if _may_have_signs(group):
            for s in group:
                _check_signs(scene, s)
    for s in scene.index.of(*((*_SETTINGS, "EM") if "carries flow" in traits else _SETTINGS), block=2):
        _check_settings(scene, s)
    if "axial" in traits and "DYNE" in classed:
        _check_stiffness(scene)
    if "warping" in traits:
        _check_warping(scene)
    if not given.isdisjoint(("ESIG", "DELESIG")):
        _check_preload(scene)
    if not given.isdisjoint(("XF", "DELXF")):
        _check_moments(scene)
    if not given.isdisjoint(("ITERSTEP", *_ADDITIONAL)):
        _check_additional(scene)
    if not classed.isdisjoint(("INPUTX", "INPUTE")) and scene.analysis is not None and scene.analysis.integrated:
        _check_motion(scene)


def _may_have_signs(group: StatementGroup) -> bool:
    """Whether some number is negative, or an inertia tensor may be none without that (all values are numbers)."""
    return (group.keyword == "XM" and group.width > 2) or min(group.values) < 0


def _check_signs(scene: CheckMaterial, s: Statement) -> None:
    """Negative masses, stiffnesses, dampings; inertia tensors that no body can have."""
    findings, last = scene.findings, len(s.values)
    if s.keyword == "XM" and (
        last > 2 or (scene.outline.space == "spatial" and scene.outline.roles[s.integer(0)] == "orientation")
    ):
        check_tensor(scene, s)
        return
    first = 1
    rest: tuple[int, ...] = ()
    if s.keyword == "MEE":
        first = 2 if last == 3 else last
    elif s.keyword == "EM" and scene.outline.types[s.integer(0)].carries_flow:
        last = min(last, 3)  # behind them stand flow rate, shape factor and end condition
    elif s.keyword == "EM" and last > 5:  # a product of inertia may be negative
        last, rest = 5, (6,) if last == 7 else ()
    for i in (*range(first, last), *rest):
        if s.real(i) < 0.0:
            findings.warning(s, i, f"negative {_SIGNS[s.keyword]} {s.real(i):g}", "negative")


def check_tensor(scene: CheckMaterial, s: Statement) -> None:
    """Warn when the inertia tensor of XM or TRM is not positive semi-definite (all principal minors not negative)."""
    xx, xy, xz, yy, yz, zz = s.reals(1, 6)
    scale = max(abs(v) for v in (xx, xy, xz, yy, yz, zz))
    if scale == 0.0:
        return
    xx, xy, xz, yy, yz, zz = (v / scale for v in (xx, xy, xz, yy, yz, zz))
    minors = (xx, yy, zz, xx * yy - xy * xy, xx * zz - xz * xz, yy * zz - yz * yz)
    whole = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz)
    # 1e-9: the given digits of a tensor of a thin body may miss zero by their rounding
    if min(*minors, whole) < -1e-9:
        text = "the inertia tensor (Jxx Jxy Jxz Jyy Jyz Jzz) is not positive semi-definite"
        scene.findings.warning(s, 1, text, "tensor")


def _check_settings(scene: CheckMaterial, s: Statement) -> None:
    findings = scene.findings
    check_ranges(findings, s)
    if s.keyword == "INTEGRAT":
        if s.integer(0) in INTEGRATOR_ALIASES:
            findings.warning(s, 0, alias_note(s.integer(0)), "choice")
        else:
            one_of(findings, s, 0, tuple(sorted((*INTEGRATORS, *INTEGRATOR_ALIASES))), "integrator type")
        if s.real(1) < 0.0:
            findings.error(s, 1, f"step size {s.real(1):g} must not be negative", "range")
    elif s.keyword == "EM" and scene.outline.types[s.integer(0)].carries_flow:
        one_of(findings, s, 5, (0, 1, 2, 3), "end condition")


def _check_stiffness(scene: CheckMaterial) -> None:
    """Dynamic deformations of beams and trusses without stiffness move freely: meant for measuring elements."""
    outline = scene.outline
    moving = [key for key, given in scene.deformations.items() if given[0] == "dynamic" and outline.types[key[0]].axial]
    stiff = {row[0]: row for row in scene.index.rows("ESTIFF", 2)} if moving else {}
    free: dict[int, list[int]] = {}
    for element, mode in moving:
        kind = outline.types[element]
        if ("ESTIFF", element) in outline.broken:
            continue
        place = kind.stiffness[mode - 1]
        if not any(stiff.get(element, ())[place - 1 : place]):
            free.setdefault(element, []).append(mode)
    for element, modes in free.items():
        by = scene.giver("element", element, modes[0])
        assert by is not None
        kind = scene.outline.types[element]
        names = ", ".join(f"{m} ({kind.modes[m - 1][0]})" for m in modes)
        text = f"no stiffness for mode {names} of the {kind.keyword}: it moves freely"
        scene.findings.information(by, None, text, "no-stiffness")


def _check_warping(scene: CheckMaterial) -> None:
    """A warping node that neither a stiffness nor a class holds makes the stiffness matrix singular."""
    given = {s.integer(0): s for s in scene.index.of("ESTIFF", block=2)}
    held: dict[int, bool] = {}
    for number, kind in scene.outline.types.items():
        for place in kind.warping:
            node = scene.outline.elements[number].integer(1 + place)
            torsion = (kind.stiffness[kind.released[0] - 1], kind.stiffness[1])
            stiff = number in given and any(given[number].real(p - 1) for p in torsion)
            held[node] = held.get(node, False) or stiff
    for node, is_held in held.items():
        if not is_held and scene.class_of("node", node, 1) == "dynamic" and not scene.doubtful("node", node):
            by = scene.outline.user(node)
            text = f"nothing holds the twist rate of warping node {node}: FIX {node}, or give ESTIFF a GIt or ECw"
            scene.findings.warning(by, None, text, "free-warping")


def _check_preload(scene: CheckMaterial) -> None:
    """The stress of a fixed deformation is whatever keeps it fixed: a preload on it changes nothing. The same holds
    for a prescribed one, except in mode 3, where prescribed deformations are the degrees of freedom."""
    acts = scene.analysis is None or scene.analysis.takes_setpoints
    lost = ("fixed",) if acts else ("fixed", "prescribed")
    for group, k, (element, *stresses) in scene.index.each("ESIG", "DELESIG", block=2):
        found = []
        for place, stress in enumerate(stresses, 1):
            if stress != 0.0 and (name := scene.class_of("element", element, place)) in lost:
                found.append((place, name))
        if not found or scene.doubtful("element", element):
            continue
        for name in lost:
            modes = [place for place, given in found if given == name]
            if modes:
                which = f"mode {modes[0]} is" if len(modes) == 1 else f"modes {', '.join(map(str, modes))} are"
                text = f"no effect: {which} {name}, so that the stress follows from equilibrium alone; a preload"
                text += " needs a deformation with DYNE or RLSE"
                scene.findings.warning(group[k], modes[0], text, "preload-lost")


def _check_moments(scene: CheckMaterial) -> None:
    """Which reading of the numbers of XF on Euler parameters was used."""
    for s in scene.index.of("XF", "DELXF", block=2):
        node = s.integer(0)
        if scene.outline.roles[node] != "orientation" or scene.outline.coordinates(node) != 4:
            continue
        count, where = len(s.values) - 1, "numbers on a spatial orientation node"
        if count in READ_AS:
            scene.findings.information(s, 1, READ_AS[count].format(where), "moment")
        else:
            text = f"{count} of four {where}: read as dual to lambda0 ...; is a moment meant?"
            scene.findings.warning(s, 1, text, "moment")


def _check_additional(scene: CheckMaterial) -> None:
    """ITERSTEP types 2 and 3 apply the additional loading, types 0 and 1 do not."""
    step = next(iter(scene.index.of("ITERSTEP")), None)
    kind = int(step.real(4)) if step is not None else 0
    loads = scene.index.of(*_ADDITIONAL, block=2)
    fluid = {row[0] for row in scene.index.rows("EM", 2) if any(row[2:3])}
    for s in scene.index.of("DELOMF", block=2):
        if s.real(1) and s.integer(0) not in fluid and not scene.doubtful("element", s.integer(0)):
            text = f"the tube has no fluid that could flow; EM {s.integer(0)} gives its mass per length in third place"
            scene.findings.error(s, 1, text, "flow")
    if kind in (2, 3) and not loads and step is not None:
        text = f"type of analysis {kind} needs additional loading, but there is no DEL... statement"
        scene.findings.warning(step, 4, text, "additional-loading")
    elif kind in (0, 1) and loads:
        given = f"ITERSTEP type {kind} (line {step.line})" if step is not None else "no ITERSTEP: type 0"
        text = f"additional loading has no effect with {given}; types 2 and 3 apply it"
        scene.findings.warning(loads[0], None, text, "additional-loading")


def _check_motion(scene: CheckMaterial) -> None:
    if scene.index.of("USERINP"):
        return
    moved = {(name, *row[:2]) for name in ("INPUTX", "INPUTE") for row in scene.index.rows(name, 2)}
    for keyword, classes, noun in (("INPUTX", scene.coordinates, "coordinate"), ("INPUTE", scene.deformations, "mode")):
        for (number, index), (name, by, k) in classes.items():
            if name == "prescribed" and (keyword, number, index) not in moved:
                text = f"{noun} {index} has no time function ({keyword} in the dynamics block): constant"
                text += " at its initial value"
                scene.findings.information(by[k], None, text, "constant")
