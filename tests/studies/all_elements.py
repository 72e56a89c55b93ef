"""A small model with every element type, or with what else a lane has to do; X.3 can be moved in all of them."""

from spacar import Deck

FIXED = [("FIX", 1), ("FIX", 2)]
EULER = ("XM", 4, 0.2, 0.01, 0.0, 0.3, 0.02, 0.25)
PIPE = (0.3, 0.2, 0.5, 1.1)  # mass of the wall, of the fluid, mass flow, shape factor
BEAM = ("BEAM", 1, 1, 2, 3, 4, 0.0, 1.0, 0.1)
SPATIAL_LAW = [("ESTIFF", 1, 90.0, 5.0, 6.0, 7.0), ("EDAMP", 1, 0.1, 0.2, 0.3, 0.4), ("EM", 1, 0.3, 0.02, 0.01, 0.03)]
SPATIAL_LAW += [("GRAVITY", 0.0, 1.0, -9.81), EULER]
SPATIAL = [("X", 3, 1.0, 0.2, 0.1), *FIXED, ("DYNE", 1, 1, 2, 3, 4, 5, 6)]
PLBEAM = [("PLBEAM", 1, 1, 2, 3, 4), ("X", 3, 1.0, 0.2), *FIXED, ("DYNE", 1, 1, 2, 3)]
PLANAR_LAW = [("EM", 1, 0.3, 0.01), ("ESTIFF", 1, 50.0, 5.0), ("EDAMP", 1, 0.1, 0.2), ("GRAVITY", 1.0, -9.81)]
WARPED = [("BEAMW", 1, 1, 2, 5, 3, 4, 6, 0.0, 1.0, 0.2, 0.01), ("X", 3, 1.0, 0.1, 0.2), ("DYNE", 1), *FIXED, ("FIX", 5)]
WARPED_LAW = [
    ("ESTIFF", 1, 1e2, 20.0, 30.0, 40.0, 0.01, 0.02, 5.0), ("EM", 1, 1.0, 0.02, 0.01, 0.01, 0.0, 0.03),
    ("XM", 6, 0.1), ("XM", 3, 0.5), ("GRAVITY", 0.0, 1.0, -9.81),
]  # fmt: skip
ROLLING = [("X", 1, 0.0, 0.0, 0.5), ("X", 3, 0.0, 0.0, 0.0), ("DYNX", 1, 2), ("DYNX", 2, 2, 3, 4), ("KINX", 1, 1)]
WHEEL_LAW = [("XM", 1, 2.0), ("XM", 2, 0.1, 0.0, 0.0, 0.2, 0.0, 0.1), ("GRAVITY", 0.5, 0.2, -9.81)]
TUBE_LAW = [("ESTIFF", 1, 60.0, 5.0, 4.0, 3.0), ("EM", 1, *PIPE, 1, 0.02, 0.01, 0.03)]
ORTUBE = ("ORTUBE", 1, 0.9, 0.1, 0.3, 0.9, 0.1, -0.1, 0.1, 1.0, 0.2)  # less than 22 degrees from its chord
CART = [
    ("PLRBEAM", 1, 1, 2, 3), ("PLWHEEL", 2, 3, 2, 4, 0.3, 0.0, 1.0), ("X", 3, 0.4, 0.1), ("DYNX", 4), ("DYNX", 2, 1),
    ("KINX", 1, 1, 2),
]  # fmt: skip
CART_LAW = [("XM", 1, 2.0), ("XM", 2, 0.3), ("XM", 4, 0.1), ("STARTDX", 4, 1, 0.0, 3.0)]

MODELS: dict[str, tuple[list[tuple], list[tuple]]] = {
    "PLBEAM": (PLBEAM, [*PLANAR_LAW, ("XM", 4, 0.1)]),
    "PLBEAM shear": (PLBEAM, [("EM", 1, 0.3, 0.01), ("ESTIFF", 1, 50.0, 5.0, 0.3), *PLANAR_LAW[3:], ("XM", 4, 0.1)]),
    "PLBEAM angle": ([*PLBEAM, ("ADEFORM",)], [*PLANAR_LAW, ("XM", 4, 0.1)]),
    "PLTUBE": (
        [("PLTUBE", 1, 1, 2, 3, 4, 0.2, -0.1), *PLBEAM[1:]],
        [("ESTIFF", 1, 60.0, 5.0), ("EM", 1, *PIPE, 1, 0.02), ("XM", 4, 0.1)],
    ),
    "PLTUBE angle": (
        [("PLTUBE", 1, 1, 2, 3, 4, 0.2, -0.1), *PLBEAM[1:], ("ADEFORM",)],
        [("ESTIFF", 1, 60.0, 5.0), ("EM", 1, *PIPE, 1, 0.02), ("XM", 4, 0.1)],
    ),
    "PLTRUSS": (
        [("PLTRUSS", 1, 1, 3), ("PLTRUSS", 2, 2, 3), ("X", 2, 0.0, 1.0), ("X", 3, 0.8, 0.3), ("FIX", 1), ("FIX", 2),
         ("DYNE", 1, 1), ("DYNE", 2, 1)],
        [("EM", 1, 0.3), ("EM", 2, 0.2), ("ESTIFF", 1, 70.0), ("ESTIFF", 2, 40.0), ("EDAMP", 1, 0.3), ("XM", 3, 0.5)],
    ),
    "PLTOR PLPINBOD": (
        [("PLTOR", 1, 1, 2), ("PLPINBOD", 2, 4, 2, 3), ("X", 3, 0.7, 0.2), ("FIX", 1), ("FIX", 4), ("DYNE", 1, 1)],
        [("XM", 3, 1.5), ("ESTIFF", 1, 2.0), ("EDAMP", 1, 0.1), ("XM", 2, 0.1), ("GRAVITY", 0.0, -9.81)],
    ),
    "PLRBEAM PLWHEEL": (CART, CART_LAW),
    "PLBELT": (
        [("PLBELT", 1, 1, 2, 3, 4, 0.3, -0.1), ("PLRBEAM", 2, 1, 5, 3), ("X", 3, 0.5, 0.1), *FIXED, ("DYNX", 5, 1),
         ("DYNE", 1, 1)],
        [("XM", 3, 1.0), ("XM", 4, 0.1), ("ESTIFF", 1, 30.0), ("EM", 1, 0.2, 0.5, 0.4), ("STARTDX", 5, 1, 0.0, 1.0)],
    ),
    "BEAM": ([BEAM, *SPATIAL], SPATIAL_LAW),
    "BEAM angle": ([BEAM, *SPATIAL, ("ADEFORM",)], [*SPATIAL_LAW[1:], ("ESTIFF", 1, 90.0, 5.0, 6.0, 7.0, 0.3, 0.2)]),
    "BEAM without direction": ([BEAM[:6], *SPATIAL], SPATIAL_LAW),
    "TUBE": ([("TUBE", *BEAM[1:]), *SPATIAL], [*TUBE_LAW, EULER]),
    "TUBE angle": ([("TUBE", *BEAM[1:]), *SPATIAL, ("ADEFORM",)], [*TUBE_LAW, EULER]),
    "ORTUBE": ([("TUBE", *BEAM[1:]), ORTUBE, *SPATIAL], [*TUBE_LAW, EULER]),
    "BEAMW": (WARPED, WARPED_LAW),
    "BEAMW angle": ([*WARPED, ("ADEFORM",)], WARPED_LAW),
    "TRUSS": (
        [("TRUSS", 1, 1, 3), ("TRUSS", 2, 2, 3), ("TRUSS", 4, 5, 3), ("X", 2, 0.0, 1.0, 0.0), ("X", 5, 0.0, 0.0, 1.0),
         ("X", 3, 0.8, 0.3, 0.2), ("FIX", 1), ("FIX", 2), ("FIX", 5), ("DYNE", 1, 1), ("DYNE", 2, 1), ("DYNE", 4, 1)],
        [("EM", 1, 0.3), ("ESTIFF", 1, 70.0), ("ESTIFF", 2, 40.0), ("ESTIFF", 4, 50.0), ("XM", 3, 0.5)],
    ),
    "HINGE RBEAM": (
        [("HINGE", 1, 1, 2, 0.0, 1.0, 0.2), ("RBEAM", 2, 4, 2, 3, 0.0, 1.0, 0.0), ("X", 3, 0.7, 0.2, 0.1), ("FIX", 1),
         ("FIX", 4), ("DYNE", 1, 1)],
        [("XM", 3, 1.5), ("EM", 2, 0.4, 0.02, 0.01, 0.01), ("ESTIFF", 1, 2.0), ("GRAVITY", 0.0, 0.0, -9.81)],
    ),
    "PINBODY": (
        [("HINGE", 1, 1, 2, 0.0, 1.0, 0.2), ("PINBODY", 2, 4, 2, 3), ("X", 3, 0.7, 0.2, 0.1), ("FIX", 1), ("FIX", 4),
         ("DYNE", 1, 1)],
        [("XM", 3, 1.5), ("XM", 2, 0.1, 0.0, 0.0, 0.2, 0.0, 0.1), ("ESTIFF", 1, 2.0), ("EDAMP", 1, 0.1)],
    ),
    "SCREW": (
        [("SCREW", 1, 1, 2, 3, 4, 1.0, 0.0, 0.0, 0.05), ("X", 3, 0.3, 0.0, 0.0), *FIXED, ("DYNE", 1, 1)],
        [("XM", 3, 1.0), ("XM", 4, 0.1, 0.0, 0.0, 0.1, 0.0, 0.1), ("STARTDE", 1, 1, 0.0, 2.0)],
    ),
    "WHEEL": ([("WHEEL", 1, 1, 2, 3, 0.0, 1.0, 0.0), *ROLLING, ("RLSE", 1, 6)], WHEEL_LAW),
    "TWHEEL": (
        [("TWHEEL", 1, 1, 2, 3, 0.5, 0.1, 0.0, 1.0, 0.0), *ROLLING, ("RLSE", 1, 6)],
        [*WHEEL_LAW, ("EDAMP", 1, 0, 0, 0, 0, 0, 0.3)],
    ),
    "at rest": ([*PLBEAM], [*PLANAR_LAW[:3], ("XM", 4, 0.1)]),
    "moments": (
        [BEAM, *SPATIAL],
        [*SPATIAL_LAW[:3], EULER, ("XF", 4, 0.03, -0.02, 0.05), ("XF", 3, 0.1, 0.2, 0.3)],
    ),
    "MEE": ([*PLBEAM], [*PLANAR_LAW, ("XM", 4, 0.1), ("MEE", 1, 2, 0.2), ("MEE", 1, 2, 1, 3, 0.05)]),
    "prescribed motions": (
        [("PLBEAM", 1, 1, 2, 3, 4), ("X", 3, 1.0, 0.2), ("FIX", 1), ("INPUTX", 2, 1), ("DYNE", 1, 2, 3),
         ("INPUTE", 1, 1)],
        [*PLANAR_LAW, ("XM", 4, 0.1), ("INPUTX", 2, 1, 0.0, 1.0, 2.0), ("INPUTE", 1, 1, 0.0, 0.1, 0.0)],
    ),
}  # fmt: skip


def deck_of(name: str) -> Deck:
    """The model, in mode 1."""
    kinematics, dynamics = MODELS[name]
    return Deck.build(kinematics, [*dynamics, ("TIMESTEP", 0.1, 2)], mode=1)
