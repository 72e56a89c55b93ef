"""The numbers of the scenarios, as the other programs need them; ours are in the .dat files (`scenarios/`)."""

from __future__ import annotations

from types import SimpleNamespace as Numbers

CRANK = Numbers(  # S1a, S1b
    crank=0.15, rod=0.3, crank_density=0.2225, rod_density=0.2225, slider=0.033375,
    speed=150.0, time=0.1, gravity=9.81, torque=0.01, start=30.0, free_time=10.0,
)  # fmt: skip
PENDULUM = Numbers(mass=1.0, length=1.0, gravity=9.81, time=10.0)  # S3a
ARM = Numbers(  # S4, S4c: two rods with masses at their ends, on a joint about z and two about -y
    first=[0.268, 0.0, 0.6467], second=[0.268, 0.0, -0.6467], density_1=4.0, density_2=2.0, mass_1=10.0, mass_2=30.0,
    gravity=10.0, time=1.4, torques=[15.0, 197.0, 82.5],
)  # fmt: skip
TORQUES = {"mean": [0.0, 196.98, 82.276], "swing": [40.0, 25.0, 30.0], "omega": 4.487989505128276}  # S4
BEAM = Numbers(length=10.0, EI=102.0, density=1.0, force=14.0)  # S5, S8
