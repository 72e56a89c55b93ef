"""One deck for every situation of reference/input-language.md section 10: (name, text, mode, severity, fragments).

The list is used twice: through `parse_deck` (test_rows.py) and through the command line (acceptance tests).
The fragments must all occur in one message line of that severity; `<deck>` stands for the file name there.
Rows whose situation needs a file system, a user function or a numerical analysis are not here.
"""

from functools import partial
from typing import NamedTuple


class Row(NamedTuple):
    """One situation: `mode` None means `spacar check`."""

    name: str
    text: str
    mode: int | None
    severity: str
    fragments: tuple[str, ...]


PLANAR = "PLBEAM 1 1 2 3 4\nX 3 1. 0.\nFIX 1\nFIX 2\n"
"""A planar cantilever of one beam: position nodes 1 3, orientation nodes 2 4; lines 1-4."""
SPATIAL = "BEAM 1 1 2 3 4 0. 1. 0.\nX 3 1. 0. 0.\nFIX 1\nFIX 2\n"
"""The same in space; lines 1-4."""
ARM = "HINGE 1 1 2 0 0 1\nRBEAM 2 3 2 4\nX 4 1. 0. 0.\nFIX 1\nFIX 3\n"
"""A hinge and a rigid arm; lines 1-5."""
BAR = "PLTRUSS 1 1 2\nX 2 3. 4.\nFIX 1\n"
"""One planar truss; lines 1-3."""
TROLLEY = "PLWHEEL 1 1 2 3 0.3 0. 1.\nDYNX 3 1\nKINX 1 1 2\nKINX 2 1\n"
"""One wheel; lines 1-4."""
END, NEXT = "END END\n", "END HALT\n"


def _deck(start: str, kinematics: str = "", dynamics: str = "", third: str = "") -> str:
    text = start + _lines(kinematics)
    if dynamics or third:
        text += NEXT + _lines(dynamics)
    if third:
        text += NEXT + _lines(third)
    return text + END


def _lines(text: str) -> str:
    return "".join(f"{line.strip()}\n" for line in text.split("|") if line.strip())


planar, spatial, arm, bar = (partial(_deck, start) for start in (PLANAR, SPATIAL, ARM, BAR))
E, W, I = "error", "warning", "information"


def row(name: str, text: str, severity: str, *fragments: str, mode: int | None = None) -> Row:
    return Row(name, text, mode, severity, fragments)


WORDS = [
    row("unknown keyword, nearest", planar("FXI 3"), E, "<deck>:5:", "unknown keyword 'FXI'", "nearest: FIX"),
    row("unknown keyword in block 2", planar("", "EMM 1 1."), E, "<deck>:6:", "unknown keyword 'EMM'", "nearest: EM"),
    row("unknown keyword of another block", planar("TIMSTEP 1. 10"), E, "<deck>:5:", "TIMESTEP", "END HALT may be"),
    row("unknown word without neighbour", planar("QQQQQQQ 1"), E, "<deck>:5:", "unknown keyword 'QQQQQQQ'"),
    row(
        "missing END HALT", PLANAR + "XM 3 1.\nTIMESTEP 1. 10\n" + END, E, "<deck>:5:",
        "XM belongs to the dynamics block", "END HALT is missing before this line",
    ),
    row(
        "superfluous END HALT", "PLBEAM 1 1 2 3 4\n" + NEXT + "X 3 1. 0.\n" + END, E, "<deck>:3:",
        "X belongs to the kinematics block", "superfluous",
    ),
    row(
        "too few arguments", "PLBEAM 1 1 2 3\n" + END, E, "<deck>:1:", "too few arguments: 4 given, 5 needed",
        "q orientation node",
    ),
    row("too few for HINGE", "HINGE 1 1 2 0. 0.\n" + END, E, "too few arguments", "x' axis"),
    row("no argument at all", planar("", "TIMESTEP"), E, "<deck>:6:", "TIMESTEP: too few arguments: 0 given, 2 needed"),
    row(
        "count between the allowed ones", "BEAM 1 1 2 3 4 0. 1.\nX 3 1.\n" + END, E, "too few arguments",
        "5, 6, 8 or 9",
    ),
    row(
        "surplus argument", "PLBEAM 1 1 2 3 4 5\nX 3 1.\n" + END, E, "<deck>:1: PLBEAM 1: surplus argument '5'",
        "PLBEAM takes 5 arguments",
    ),
    row("surplus on the next line", "PLBEAM 1 1 2 3 4\n5\nX 3 1.\n" + END, E, "<deck>:2:", "surplus argument '5'"),
    row("surplus for this type", planar("", "EM 1 1. 0. 3."), E, "EM 1: surplus argument '3.'", "planar beam"),
    row(
        "letter O for zero", planar("", "ESTIFF 1 0. O.5"), E,
        "<deck>:6: ESTIFF 1: third argument 'O.5' is not a number; expected EI (N m^2) of a planar beam",
    ),
    row(
        "real where an integer is expected", "PLBEAM 1 1 2 3 4.5\n" + END, E, "fifth argument '4.5' is not an integer",
        "q orientation node",
    ),
    row("nan", planar("", "XM 3 nan"), E, "second argument 'nan' is not a number", "mass (kg)"),
    row("inf", planar("", "XM 3 -inf"), E, "'-inf' is not a number"),
    row("comma", planar("X 4, 1. 0."), E, "'4,' is not a number"),
    row("decimal comma", planar("", "XM 3 1,5"), E, "'1,5' is not a number"),
    row("hexadecimal", planar("", "XM 3 0x10"), E, "'0x10' is not a number"),
    row("too large", planar("", "XM 3 1e999"), E, "'1e999' is too large"),
    row("long line", planar("% " + "-" * 160), W, "<deck>:5:", "160"),
]  # fmt: skip
STRUCTURE = [
    row(
        "END followed by a keyword", PLANAR + "END\nXM 3 1.\n" + END, E, "<deck>:6:", "END must be followed by HALT",
        "kinematics block (open since line 1)",
    ),
    row("HALT alone", PLANAR + "HALT\nXM 3 1.\n" + END, E, "<deck>:5:", "HALT without END"),
    row("end of file", PLANAR, E, "end of file inside the kinematics block (open since line 1)", "END END is missing"),
    row("end of file in block 2", PLANAR + NEXT + "XM 3 1.\n", E, "inside the dynamics block (open since line 6)"),
    row("end of file after END", PLANAR + "END\n", E, "end of file after a single END"),
    row("visualization before END END", PLANAR + "VISUALIZATION\nLIGHT 1\n", E, "END END is missing"),
    row("a fourth block", planar("", "XM 3 1.", "OUTX 1 3 1").replace(END, NEXT), E, "no block follows"),
    row("number before any keyword", "1 2 3\n" + planar(), E, "<deck>:1:", "'1' stands before any keyword"),
    row("empty file", "", E, "end of file inside the kinematics block"),
    row("no element", END, E, "defines no element"),
]  # fmt: skip
ELEMENTS = [
    row(
        "duplicate element", PLANAR + "PLTRUSS 1 1 3\n" + END, E, "<deck>:5: PLTRUSS 1:",
        "element 1 is already defined at line 1",
    ),
    row("element number zero", "PLTRUSS 0 1 2\nX 2 1.\n" + END, E, "element number 0 must be positive"),
    row("node number negative", "PLTRUSS 1 1 -2\n" + END, E, "q position node -2 must be positive"),
    row(
        "node in two roles", PLANAR + "PLTRUSS 2 3 2\n" + END, E, "<deck>:5: PLTRUSS 2:",
        "position node 2 is used as orientation node by PLBEAM 1 (line 1)",
    ),
    row(
        "planar and spatial", PLANAR + "TRUSS 2 3 5\nX 5 2. 2.\n" + END, E, "<deck>:5: TRUSS 2:",
        "spatial element in a model with the planar element PLBEAM 1 (line 1)",
    ),
    row("p and q the same node", "PLTRUSS 1 1 1\n" + END, E, "p and q are the same position node 1"),
    row("hinge between one node", "PLTOR 1 1 1\n" + END, E, "p and q are the same orientation node 1"),
    row(
        "zero length", "PLTRUSS 1 1 2\nPLTRUSS 2 1 3\nX 2 1. 1.\n" + END, E, "<deck>:2: PLTRUSS 2: length 0",
        "no X for node 1 and 3",
    ),
    row(
        "direction parallel to the axis", SPATIAL.replace("0. 1. 0.", "1. 0. 0.") + END, E, "<deck>:1: BEAM 1:",
        "parallel", "angle 0 degrees", "length 1",
    ),
    row("zero direction", "HINGE 1 1 2 0. 0. 0.\n" + END, E, "the direction vector is zero"),
    row("PLBEAR", "PLBEAR 1 1 2 3 4\n" + END, E, "PLBEAR 1: a planar bearing is not supported", "original"),
    row("overlapping pulleys", "PLBELT 1 1 2 3 4 1. -1.\nX 3 1. 0.\n" + END, E, "PLBELT 1", "no free belt"),
    row("wheel in mode 2", TROLLEY + END, E, "non-holonomic element in mode 2", "0, 1, 4, 7", mode=2),
    row("wheel in mode 3", TROLLEY + END, E, "non-holonomic element in mode 3", mode=3),
    row("wheel in mode 8", TROLLEY + END, E, "non-holonomic element in mode 8", mode=8),
]  # fmt: skip
COORDINATES = [
    row(
        "X for an orientation node", planar("X 4 1. 0."), E, "node 4 is an orientation node",
        "initial orientations cannot be chosen",
    ),
    row("X for an unused node", planar("X 9 1. 0."), W, "<deck>:5: X 9:", "node 9 is not used by any element"),
    row("FIX for an unused node", planar("FIX 9"), W, "<deck>:5: FIX 9:", "node 9 is not used by any element"),
    row("X twice, different", planar("X 3 2. 0."), E, "<deck>:5: X 3:", "another position at line 2"),
    row("X twice, equal", planar("X 3 1. 0."), W, "<deck>:5: X 3:", "the same position was already given at line 2"),
    row("coordinate out of range", planar("FIX 3 3"), E, "coordinate 3 does not exist", "1 to 2"),
    row("coordinate zero", planar("FIX 3 0"), E, "coordinate 0 does not exist"),
    row("mode out of range", planar("RLSE 1 4"), E, "mode 4 does not exist", "element 1 (PLBEAM) has mode 1 to 3"),
    row(
        "two classes of a coordinate", planar("DYNX 1 1"), E, "<deck>:5: DYNX 1:", "coordinate 1 cannot be dynamic",
        "by FIX at line 3",
    ),
    row(
        "two classes of a deformation", planar("RLSE 1 2|DYNE 1 2"), E, "<deck>:6: DYNE 1:", "mode 2 cannot be dynamic",
        "released by RLSE at line 5",
    ),
    row("same class twice", planar("FIX 1 1"), W, "<deck>:5: FIX 1: coordinate 1 was already fixed at line 3"),
    row("all four Euler parameters", spatial("DYNX 4 1 2 3 4"), E, "all four Euler parameters of node 4"),
    row(
        "lambda0 with the others", spatial("INPUTX 4 1|INPUTX 4"), E, "<deck>:6:",
        "all four Euler parameters of node 4", "lines 5, 6",
    ),
    row("FIX of all four", spatial("FIX 4 1 2 3 4"), E, "all four Euler parameters of node 4"),
    row("KINX without wheel", planar("KINX 3 1"), E, "KINX 3:", "no non-holonomic element"),
    row("KINE without wheel", planar("KINE 1 1"), E, "KINE 1:", "no non-holonomic element"),
    row(
        "unknown node in INPUTX", planar("INPUTX 9 1"), E, "<deck>:5: INPUTX: node 9 is not used by any element",
        "nodes 1-4 exist",
    ),
    row("unknown node in DYNX", planar("DYNX 9 1"), E, "DYNX: node 9 is not used"),
    row("unknown node in KINX", planar("KINX 9 1"), E, "KINX: node 9 is not used"),
    row("unknown element in RLSE", planar("RLSE 7"), E, "RLSE: element 7 is not defined"),
    row(
        "unknown element in DYNE", planar("PLTRUSS 2 1 3|PLTRUSS 3 1 3|DYNE 7 1"), E,
        "<deck>:7: DYNE: element 7 is not defined; elements 1-3 exist",
    ),
    row("third component not zero", planar("PLTRUSS 2 1 5|X 5 1. 0. 3."), E, "surplus argument '3.'"),
    row("third component zero", planar("PLTRUSS 2 1 5|X 5 1. 0. 0."), W, "third component '0.'"),
]  # fmt: skip
WRONG_TYPES = [
    row("LDEFORM on a truss", bar("LDEFORM 1"), E, "element 1 is a PLTRUSS", "LDEFORM is for PLBEAM, BEAM"),
    row("ORPINBOD on a beam", planar("ORPINBOD 1 1. 0."), E, "element 1 is a PLBEAM", "ORPINBOD is for"),
    row("DRPINBOD on a beam", planar("DRPINBOD 1 1. 0."), E, "element 1 is a PLBEAM", "DRPINBOD is for"),
    row("ORTUBE on a beam", spatial("ORTUBE 1 1 0 0 1 0 0 0 1 0"), E, "element 1 is a BEAM", "ORTUBE is for TUBE"),
    row(
        "ORPINBOD with three numbers", "PLRBEAM 1 1 2 3\nX 3 1.\nORPINBOD 1 1. 0. 0.\n" + END, E, "ORPINBOD 1",
        "3 or 5 arguments",
    ),
    row("ORPINBOD with seven numbers", arm("ORPINBOD 2 1 0 0 0 1 0 0"), E, "ORPINBOD 2", "7 or 10 arguments"),
    row("ORPINBOD dependent", arm("ORPINBOD 2 1 0 0 -2 0 0"), E, "ORPINBOD 2", "linearly dependent"),
    row("ORPINBOD dependent, planar", "PLRBEAM 1 1 2 3\nX 3 1.\nORPINBOD 1 1 1 2 2\n" + END, E, "linearly dependent"),
    row("XM for an unknown node", planar("", "XM 99 1."), E, "<deck>:6: XM: node 99 is not used by any element"),
    row("XF for an unknown node", planar("", "XF 99 1."), E, "XF: node 99 is not used"),
    row("EM for an unknown element", planar("", "EM 7 1."), E, "EM: element 7 is not defined; element 1 exists"),
    row("EM too long for a truss", bar("", "EM 1 1. 2."), E, "EM 1: surplus argument '2.'", "planar truss"),
    row("ESTIFF too long", planar("", "ESTIFF 1 1. 1. 1. 1."), E, "ESTIFF 1: surplus argument", "2 to 4"),
    row("EDAMP too long", planar("", "EDAMP 1 1. 1. 1."), E, "EDAMP 1: surplus argument", "2 or 3"),
    row("EM on a hinge", arm("", "EM 1 1."), E, "element 1 is a HINGE (spatial hinge)", "EM is for"),
    row("XGYRO in a planar model", planar("", "XGYRO 4 0 0 1 1."), E, "XGYRO 4", "planar model"),
]  # fmt: skip
DYNAMICS = [
    row(
        "flow without fluid",
        "PLTUBE 1 1 2 3 4\nX 3 1. 0.\nFIX 1\nFIX 2\n" + NEXT + "EM 1 2.\nDELOMF 1 0.1\nITERSTEP 20 2 1e-9 1 2\n" + END,
        E, "<deck>:7: DELOMF 1", "no fluid that could flow; EM 1 gives", mode=7,
    ),
    row("negative mass", planar("", "XM 3 -1."), W, "XM 3: negative mass"),
    row("negative mass per length", planar("", "EM 1 -1."), W, "EM 1: negative mass"),
    row("negative stiffness", planar("", "ESTIFF 1 -1."), W, "ESTIFF 1: negative stiffness"),
    row("negative damping", planar("", "EDAMP 1 0. -1."), W, "EDAMP 1: negative damping"),
    row("inertia tensor", spatial("", "XM 4 1. 2. 0. 1. 0. 1."), W, "XM 4:", "not positive semi-definite"),
    row(
        "DYNE without stiffness", planar("DYNE 1 2 3", "EM 1 1."), I,
        "<deck>:5: DYNE 1: no stiffness for mode 2 (bending at p)", "moves freely", mode=1,
    ),
    row("XF twice", planar("", "XF 3 1.|XF 3 2."), E, "<deck>:7: XF 3: already given at line 6"),
    row("XM twice", planar("", "XM 3 1.|XM 3 1."), E, "XM 3: already given at line 6"),
    row("EM twice", planar("", "EM 1 1.|EM 1 2."), E, "EM 1: already given at line 6"),
    row("ESTIFF twice", planar("", "ESTIFF 1 1.|ESTIFF 1 2."), E, "ESTIFF 1: already given at line 6"),
    row("TIMESTEP twice", planar("", "TIMESTEP 1. 1|TIMESTEP 1. 2"), E, "already given at line 6"),
    row(
        "time function of a calculable coordinate", planar("", "INPUTX 3 1 0. 1."), E,
        "<deck>:6: INPUTX 3: coordinate 1 of node 3 is calculable", "prescribed",
    ),
    row("time function of a fixed deformation", planar("", "INPUTE 1 1 0. 1."), E, "mode 1 of element 1 is fixed"),
    row(
        "start value of a fixed coordinate", planar("", "STARTDX 1 1 0.1"), E, "coordinate 1 of node 1 is fixed",
        "FIX at line 3", "dynamic",
    ),
    row(
        "start value of a released deformation", planar("RLSE 1", "STARTDE 1 1 0. 1."), E,
        "mode 1 of element 1 is calculable",
    ),
    row(
        "zero start value and rate of a released deformation", planar("RLSE 1", "STARTDE 1 1 0. 0."), W,
        "mode 1 of element 1 is calculable", "no effect",
    ),
    row(
        "zero start value of a fixed coordinate", planar("", "STARTDX 1 1 0."), W, "coordinate 1 of node 1 is fixed",
        "FIX at line 3", "no effect",
    ),
    row(
        "preload on a fixed deformation", planar("DYNE 1 1", "ESTIFF 1 1.|ESIG 1 1. 2."), W,
        "ESIG 1: no effect: mode 2 is fixed",
    ),
    row("surplus stiffness that is not zero", bar("DYNE 1", "ESTIFF 1 8. 0. 1."), E, "surplus argument '1.'"),
    row("surplus stiffness that is zero", bar("DYNE 1", "ESTIFF 1 8. 0. 0."), I, "ESTIFF 1: 2 surplus zeros"),
    row(
        "a node too many for a rigid beam", "RBEAM 1 1 2 3 4\nX 3 1. 0. 0.\nEND END\n", E, "RBEAM 1: surplus node '4'",
        "takes 4 or 7 arguments",
    ),
    row(
        "a node too many for a rigid beam with a direction", "RBEAM 1 1 2 3 4 0. 0. 1.\nX 3 1. 0. 0.\nEND END\n", E,
        "RBEAM 1: surplus node '4'",
    ),
    row("increment of a coordinate that is not prescribed", planar("", "DELINPX 3 1 1."), E, "DELINPX 3", "prescribed"),
    row(
        "no time function, mode 1", bar("INPUTX 2 1"), I, "<deck>:4: INPUTX 2: coordinate 1",
        "constant at its initial value", mode=1,
    ),
    row("no time function, mode 4", bar("INPUTE 1 1"), I, "INPUTE 1: mode 1", "constant at its initial value", mode=4),
    row("TIMESTEP zero", planar("", "TIMESTEP 0. 10"), E, "length of the time interval 0 must be positive"),
    row("TIMESTEP without steps", planar("", "TIMESTEP 1. 0"), E, "number of time steps 0 must be at least 1"),
    row("INTEGRAT", planar("", "INTEGRAT 7"), E, "integrator type 7 does not exist", "0, 130, 135, 140, 155", "430"),
    row("INTEGRAT 255", planar("", "INTEGRAT 255"), W, "255 is read as 225"),
    row("ITERSTEP 2 without DEL", planar("", "ITERSTEP 10 5 1e-6 1 2"), W, "type of analysis 2", "no DEL... statement"),
    row("DEL with ITERSTEP 0", planar("", "ITERSTEP 10 5|DELXF 3 1."), W, "DELXF 3: additional loading has no effect"),
    row("DEL without ITERSTEP", planar("", "DELXF 3 1."), W, "additional loading has no effect"),
    row("two numbers of XF on lambda", spatial("", "XF 4 1. 2."), W, "read as dual to lambda0"),
    row("three numbers of XF on lambda", spatial("", "XF 4 1. 2. 3."), I, "moment about the global axes"),
    row("four numbers of XF on lambda", spatial("", "XF 4 0. 2. 3. 4."), I, "dual to lambda0"),
    row("not a function name", planar("", "USERSIG 3x"), E, "'3x' is not a name of a function"),
]  # fmt: skip
PORTS = [
    row(
        "gap in the inputs", planar("RLSE 1", "", "INPUTF 1 3 1|INPUTF 3 3 2"), E, "input numbers must be 1 to n",
        "2 is missing", mode=9,
    ),
    row(
        "output used twice", planar("RLSE 1", "", "OUTX 1 3 1|OUTX 1 3 2"), E,
        "output number 1 is already used by OUTX at line 8", mode=9,
    ),
    row("output number zero", planar("RLSE 1", "", "OUTX 0 3 1"), E, "output number 0 must be positive", mode=9),
    row(
        "INPUTS of a fixed deformation", planar("", "", "INPUTS 1 1 1"), E,
        "<deck>:7: INPUTS 1: mode 1 of element 1 is fixed", "dynamic or kinematic or calculable", mode=9,
    ),
    row(
        "INPUTF on a fixed coordinate", planar("", "", "INPUTF 1 1 1"), E,
        "coordinate 1 of node 1 is fixed (FIX at line 3)", mode=4,
    ),
    row(
        "INX of a calculable coordinate", planar("", "", "INX 1 3 1"), E, "coordinate 1 of node 3 is calculable",
        "prescribed", mode=9,
    ),
    row(
        "OUTF of a calculable coordinate", planar("", "", "OUTF 1 3 1"), E, "calculable", "fixed or prescribed", mode=9,
    ),
    row("OUTX of a fixed coordinate", planar("", "", "OUTX 1 1 1"), E, "coordinate 1 of node 1 is fixed", mode=9),
    row("OUTE of a fixed deformation", planar("", "", "OUTE 1 1 1"), E, "mode 1 of element 1 is fixed", mode=9),
    row("INE of a slip", TROLLEY + "INPUTE 1 1\n" + NEXT + NEXT + "INE 1 1 1\n" + END, E, "is a slip", mode=9),
    row("output of an unknown node", planar("", "", "OUTX 1 9 1"), E, "node 9 is not used", mode=9),
    row(
        "nominal input in mode 9", planar("", "", "NOMS 1 1 1"), E, "NOMS: belongs to the block of trajectories",
        mode=9,
    ),
    row("skipped third block", planar("", "", "OUTX 1 3 1"), I, "the third block is not used in mode 1", mode=1),
    row(
        "skipped third block with errors", planar("", "", "OUTX 2 3 1"), W, "the skipped third block has 1 error",
        mode=7,
    ),
    row("skipped dynamics block", planar("", "EM 1 1."), I, "the dynamics block is not used in mode 0", mode=0),
]  # fmt: skip
TRAVEL = "TRAJECT 1|TRANS 2 4. 4.|TRTIME 1. 10"
TRAJECTORIES = [
    row(
        "TRAJECT not ascending", bar("INPUTX 2", "", f"{TRAVEL}|{TRAVEL}"), E, "<deck>:10: TRAJECT 1", "must ascend",
        mode=2,
    ),
    row(
        "path and degrees of freedom", bar("INPUTX 2 1", "", TRAVEL), E, "coordinate 2 of node 2 is calculable",
        "INPUTX 2 1 2", mode=2,
    ),
    row(
        "TRE without INPUTE", bar("INPUTX 2", "", "TRAJECT 1|TRE 1 1.|TRTIME 1. 10"), E, "mode 1 of element 1 is fixed",
        "INPUTE 1 1", mode=2,
    ),
    row(
        "missing TRTIME", bar("INPUTX 2", "", "TRAJECT 1|TRANS 2 4. 4."), E, "<deck>:7: TRAJECT 1: TRTIME is missing",
        mode=2,
    ),
    row("missing path", bar("INPUTX 2", "", "TRAJECT 1|TRTIME 1. 10"), E, "a path is missing", mode=2),
    row(
        "statement before TRAJECT", bar("INPUTX 2", "", "TRTIME 1. 10|" + TRAVEL), E, "before the first TRAJECT",
        mode=2,
    ),
    row("no TRAJECT in mode 2", bar("INPUTX 2"), E, "at least one TRAJECT", mode=2),
    row("profile without path", bar("INPUTX 2", "", f"{TRAVEL}|TREPMAX 1 0.1 1."), E, "element 1 has no path", mode=2),
    row("TRFRONT without path", bar("INPUTX 2", "", f"{TRAVEL}|TRFRONT 7 1"), E, "neither node nor element 7", mode=2),
    row(
        "TRFRONT of two paths", bar("X 3 1. 1.|PLTRUSS 2 2 3|INPUTX 2|INPUTE 2", "", f"{TRAVEL}|TRE 2 0.1|TRFRONT 2 1"),
        W, "both node 2 and element 2 have a path", mode=2,
    ),
    row("TRFRONT type", bar("INPUTX 2", "", f"{TRAVEL}|TRFRONT 2 5"), E, "front type 5 does not exist", mode=2),
    row(
        "two paths of a node", bar("INPUTX 2", "", f"{TRAVEL}|TRCIRL 2 0. 0. 0. 5."), E,
        "already given in this trajectory by TRANS", mode=2,
    ),
    row("USERTRAJ with a path", bar("INPUTX 2", "", f"{TRAVEL}|USERTRAJ f"), E, "USERTRAJ replaces all paths", mode=2),
    row(
        "TRANS of an orientation node", arm("INPUTE 1 1", "", "TRAJECT 1|TRANS 2 1. 1. 1.|TRTIME 1. 10"), E, "TRANS 2",
        "orientation node", mode=2,
    ),
    row(
        "surplus argument of TROT", bar("INPUTX 2", "", "TRAJECT 1|TROT 2 0.3 0.2|TRTIME 1. 10"),
        E, "TROT takes 2 arguments for an orientation node", mode=2,
    ),
    row(
        "TRTIME zero", bar("INPUTX 2", "", "TRAJECT 1|TRANS 2 4. 4.|TRTIME 0. 10"), E, "total time 0 must be positive",
        mode=2,
    ),
    row(
        "degree of freedom without path", bar("INPUTX 2|PLTRUSS 2 1 3|X 3 1.|INPUTX 3", "", TRAVEL), I,
        "node 3 has no path in any trajectory", mode=2,
    ),
]  # fmt: skip
ROWS: list[Row] = [*WORDS, *STRUCTURE, *ELEMENTS, *COORDINATES, *WRONG_TYPES, *DYNAMICS, *PORTS, *TRAJECTORIES]
