"""Checks of the trajectories of mode 2: order, completeness, paths that match the degrees of freedom."""

from dataclasses import dataclass, field
from itertools import pairwise

from spacar.deck.check_material import CheckMaterial, check_ranges
from spacar.deck.checks_dynamics import check_tensor
from spacar.deck.statement import Statement, again
from spacar.deck.table_io import NO_TRAJECTORY, PATHS, TRAJECTORIES

MOST_PATHS = 6
_NAMES = {k.name for k in TRAJECTORIES}


@dataclass(slots=True, eq=False)
class _Trajectory:
    start: Statement
    statements: list[Statement] = field(default_factory=list)

    def of(self, *keywords: str) -> list[Statement]:
        return [s for s in self.statements if s.keyword in keywords]


def check_trajectories(scene: CheckMaterial) -> None:
    trajectories = _collect(scene)
    whole = 3 not in scene.outline.broken_blocks
    needed = scene.analysis is not None and scene.analysis.gives_setpoints
    if needed and not trajectories and whole:
        scene.findings.add("error", None, "", NO_TRAJECTORY, "no-trajectory")
    for before, after in pairwise(trajectories):
        if after.start.integer(0) <= before.start.integer(0):
            last = f"{before.start.values[0]} (line {before.start.line})"
            text = f"trajectory numbers must ascend; the one before is {last}"
            scene.findings.error(after.start, 0, text, "trajectory-order")
    for trajectory in trajectories:
        _check_one(scene, trajectory, whole)
    by_user = [s for t in trajectories for s in t.of("USERTRAJ")]
    if by_user and len(trajectories) > 1:
        text = f"USERTRAJ is for a single TRAJECT; there are {len(trajectories)}"
        scene.findings.error(by_user[0], None, text, "user-trajectory")
    if needed and trajectories and not by_user:
        _check_rest(scene, trajectories)


def _collect(scene: CheckMaterial) -> list[_Trajectory]:
    trajectories: list[_Trajectory] = []
    lost = False
    for s in scene.index.of(*_NAMES, block=3):
        if s.keyword == "TRAJECT":
            trajectories.append(_Trajectory(s))
        elif trajectories:
            trajectories[-1].statements.append(s)
        elif not lost and ("TRAJECT", 0) not in scene.outline.broken:
            lost = True
            scene.findings.error(s, None, "stands before the first TRAJECT", "trajectory-order")
    return trajectories


def _check_one(scene: CheckMaterial, t: _Trajectory, whole: bool) -> None:
    findings = scene.findings
    paths, times, user = t.of(*PATHS), t.of("TRTIME"), t.of("USERTRAJ")
    if not times and whole:
        findings.error(t.start, None, "TRTIME is missing", "no-time")
    if not paths and not user and whole:
        findings.error(t.start, None, f"a path is missing: {', '.join(PATHS)} or USERTRAJ", "no-path")
    if paths and user:
        text = f"USERTRAJ replaces all paths, but {paths[0].subject} is given too"
        findings.error(user[0], None, text, "user-trajectory")
    if len(paths) > MOST_PATHS:
        text = f"{len(paths)} path statements in one trajectory; at most {MOST_PATHS}"
        findings.error(paths[MOST_PATHS], None, text, "too-many-paths")
    _check_repeated(scene, t)
    moved_nodes = {s.values[0] for s in t.of("TROT", "TRANS", "TRCIRL")}
    moved_elements = {s.values[0] for s in t.of("TRE")}
    for s in t.statements:
        number = s.values[0]
        if s.keyword in PATHS:
            # Along set-points the trajectories of the mode 2 file are read along with other classes.
            if scene.analysis is None or not scene.analysis.takes_setpoints:
                _check_path(scene, s)
        elif not whole:
            pass
        elif s.keyword in ("TRVMAX", "TRM", "TRF") and number not in moved_nodes and not user:
            text = f"node {number} has no path (TROT, TRANS, TRCIRL) in trajectory {t.start.values[0]}"
            findings.error(s, 0, text, "no-path")
        elif s.keyword == "TREPMAX" and number not in moved_elements:
            text = f"element {number} has no path (TRE) in trajectory {t.start.values[0]}"
            findings.error(s, 0, text, "no-path")
        elif s.keyword == "TRFRONT" and number not in moved_nodes | moved_elements:
            text = f"neither node nor element {number} has a path in trajectory {t.start.values[0]}"
            findings.error(s, 0, text, "no-path")
        elif s.keyword == "TRFRONT" and number in moved_nodes & moved_elements:
            text = f"both node {number} and element {number} have a path: the front is that of both"
            findings.warning(s, 0, f"{text}; renumber one of them to tell them apart", "two-paths")
        _check_values(scene, s)


def _check_values(scene: CheckMaterial, s: Statement) -> None:
    findings = scene.findings
    check_ranges(findings, s)
    if s.keyword in ("TRVMAX", "TREPMAX") and len(s.values) == 3 and not s.real(2) > 0.0:
        text = f"extreme velocity {s.real(2):g} must be positive; the path gives the sense of the motion"
        findings.error(s, 2, text, "range")
    elif s.keyword == "TRM" and len(s.values) > 2:
        check_tensor(scene, s)
    elif s.keyword == "TRM" and s.real(1) < 0.0:
        findings.warning(s, 1, f"negative mass or inertia {s.real(1):g}", "negative")
    elif s.keyword == "TROT" and len(s.values) == 5 and not any(s.reals(2, 3)):
        findings.error(s, 2, "the axis of rotation is a zero vector", "direction")


def _check_repeated(scene: CheckMaterial, t: _Trajectory) -> None:
    for s, first in again((_states(s), s) for s in t.statements):
        text = f"already given in this trajectory by {first.keyword} at line {first.line}"
        scene.findings.error(s, None, text, "repeated")


def _states(s: Statement) -> tuple[object, ...]:
    """What may be stated once in a trajectory."""
    if s.keyword in ("TRTIME", "USERTRAJ"):
        return (s.keyword,)
    if s.keyword in PATHS:
        return "path of element" if s.keyword == "TRE" else "path of node", s.values[0]
    return s.keyword, s.values[0]


def _check_path(scene: CheckMaterial, s: Statement) -> None:
    """A path moves the first mode of an element, or all (independent) coordinates of a node."""
    number = s.integer(0)
    if scene.doubtful("element" if s.keyword == "TRE" else "node", number):
        return
    if s.keyword == "TRE":
        found = scene.class_of("element", number, 1)
        if found != "prescribed":
            text = f"mode 1 of element {number} is {found}; TRE needs INPUTE {number} 1 in the kinematics block"
            scene.findings.error(s, 0, text, "path-class")
        return
    needed = scene.outline.independent(number)
    enough = ("prescribed", "fixed") if s.keyword == "TRANS" else ("prescribed",)  # a slider in a guide
    lacking = [i for i in needed if scene.class_of("node", number, i) not in enough]
    if lacking:
        found = scene.class_of("node", number, lacking[0])
        text = f"coordinate {lacking[0]} of node {number} is {found}; {s.keyword} moves all its coordinates and needs"
        text += f" INPUTX {number} {' '.join(map(str, needed))} in the kinematics block"
        scene.findings.error(s, 0, text, "path-class")


def _check_rest(scene: CheckMaterial, trajectories: list[_Trajectory]) -> None:
    """Prescribed coordinates and deformations without any path rest at their initial value."""
    nodes = {s.values[0] for t in trajectories for s in t.of("TROT", "TRANS", "TRCIRL")}
    elements = {s.values[0] for t in trajectories for s in t.of("TRE")}
    for moved, classes, noun in ((nodes, scene.coordinates, "node"), (elements, scene.deformations, "element")):
        resting = {n: by[k] for (n, _), (name, by, k) in classes.items() if name == "prescribed" and n not in moved}
        for number, by in resting.items():
            text = f"{noun} {number} has no path in any trajectory: it stays at its initial value"
            scene.findings.information(by, None, text, "constant")
