"""Models as front-ends write them: node k has position 3k-2 and orientation 3k-1, load in steps, transfer functions.

And robotinv.dat with a few steps only.
"""

from tests.examples import DATA

SHORT_ROBOT = (DATA / "robotinv.dat").read_text().replace("TRTIME 0.2 20", "TRTIME 0.2 2").replace("1.0 100", "1.0 7")

BENT = """\
BEAM 1  1 2  7 8   0 1 0
BEAM 2  7 8  4 5   0 1 0
X 1  0     0     0
X 4  0.1   0     0.02
X 7  0.05  0.01  0
FIX 1
FIX 2
DYNE 1 1 2 3 4 5 6
DYNE 2 1 2 3 4 5 6
OUTLEVEL 0 1
END
HALT
ESTIFF 1 2100000 0.0093 0.007 437.5 1.17e-08 0.00073
ESTIFF 2 2100000 0.0093 0.007 437.5 1.17e-08 0.00073
EM 1 0.078 1.625e-05 2.6e-10 1.625e-05
EM 2 0.078 1.625e-05 2.6e-10 1.625e-05
XM 4 0.1
GRAVITY 0 0 -0.981
ITERSTEP 10 3 0.0000005 1 3 3
DELXF 4 0.2 0.3 0.01
DELXF 5 0.004 0.002 0.005
END
END
"""

TRANSFER = BENT.replace("ITERSTEP 10 3 0.0000005 1 3 3\n", "").replace("DELXF", "XF").removesuffix("END\nEND\n") + """\
END
HALT
INPUTF 1 4 2
INPUTF 2 4 3
OUTX 1 4 2
OUTX 2 4 3
OUTXP 3 4 2
END
END
"""

MASSLESS = """\
PLTRUSS 1 1 2
X 1 0 0
X 2 1 0
FIX 1
FIX 2 2
DYNE 1
END
HALT
ESTIFF 1 1000
END
END
"""

WARPED = """\
BEAMW 1  1 2 3  4 5 6   0 1 0
BEAMW 2  4 5 6  7 8 9   0 1 0
X 1  0     0  0
X 4  0.05  0  0
X 7  0.1   0  0
FIX 1
FIX 2
FIX 3
DYNE 1 1 2 3 4 5 6
DYNE 2 1 2 3 4 5 6
END
HALT
ESTIFF 1 2100000 0.0093098 0.007 437.5 1.17e-08 0.00073 1.458333e-06
ESTIFF 2 2100000 0.0093098 0.007 437.5 1.17e-08 0.00073 1.458333e-06
EM 1 0.078 1.625e-05 2.6e-10 1.625e-05 0 5.4e-14
EM 2 0.078 1.625e-05 2.6e-10 1.625e-05 0 5.4e-14
XF 8 0.001 0 0
END
END
"""
