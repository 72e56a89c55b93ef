"""Two-link flexible planar manipulator: the example of the paper as a script for `spacar symbolic`.

The paper: A. A. Barhorst, "Symbolic equation processing utilizing vector/dyad notation" (docs/reference/bibliography.md).

The same model as manipulator.toml. Run, for instance:  spacar symbolic simulate manipulator.py --plot all
"""

from spacar.symbolic import MultibodySystem, beam_shapes

system = MultibodySystem(gravity=("0", "-g", "0"), title="two-link flexible planar manipulator")
L, rho, EI, gam = system.parameters("L rho EI gam")
q1, s1 = system.coordinate("q1", speed="s1")
q4, s4 = system.coordinate("q4", speed="s4")
Ta1 = system.input("Ta1", "-D1*s1 - K1*(q1 - Q1)")
Ta2 = system.input("Ta2", "-D2*s4 - K2*(q4 - Q4)")
beam = {"length": L, "mass": rho, "EI": EI, "field": beam_shapes.monomial(2, 3, 4), "damping": gam}

B1 = system.frame("B1", parent=system.N, axis=3, angle=q1)
link1 = system.beam("link1", frame=B1, root=system.O, **beam)
B2 = system.frame("B2", parent=link1.tip, axis=3, angle=q4)
link2 = system.beam("link2", frame=B2, root=link1.tip, **beam)
system.torque(B1, Ta1 * B1[3], reaction=system.N)
system.torque(B2, Ta2 * B2[3], reaction=link1.tip)

values = {
    "g": 9.80665, "rho": 2.612898, "L": 0.9144, "EI": 2048.639047875, "gam": 0.44482216152605,
    "K1": 54.232717933256, "K2": 40.674538449942, "D1": 20.337269224971, "D2": 13.558179483314, "Q1": 0.5, "Q4": 0.0,
}  # fmt: skip
start = {"q1": -0.5, "q4": 0.5}
settings = {"time": 40.0, "steps": 4000}
outputs = {"tip1": link1.tip.u, "tip2": link2.tip.u}
