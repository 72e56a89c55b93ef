"""The scenarios in Exudyn: the same mechanisms, built as its examples build theirs; every function returns the answer.

Files, displays and threads are off, which is the fastest way to use it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import exudyn as exu
import exudyn.itemInterface as items
import numpy as np
from mechanisms import ARM, BEAM, CRANK, PENDULUM, TORQUES

Solver = exu.DynamicSolverType


def _settings(end: float = 1.0, steps: int = 1, outputs: int = 1) -> Any:
    s = exu.SimulationSettings()
    s.timeIntegration.endTime = end
    s.timeIntegration.numberOfSteps = steps
    s.timeIntegration.verboseMode = s.staticSolver.verboseMode = 0
    s.solution.file.write = False
    s.solution.sensors.writePeriod = end / outputs
    s.parallel.numberOfThreads = 1
    return s


def crank(steps: int, rho: float = 1.0) -> np.ndarray:
    """S1a: accelerations of the slider at the 101 times; generalized alpha with index 2 constraints."""
    c = CRANK
    mbs = exu.SystemContainer().AddSystem()
    ground = mbs.AddObject(items.ObjectGround())
    m = c.rod_density * c.rod
    nodes = [
        mbs.AddNode(items.NodeRigidBody2D(referenceCoordinates=[c.crank / 2, 0, 0],
                                          initialVelocities=[0, c.crank / 2 * c.speed, c.speed])),
        mbs.AddNode(items.NodeRigidBody2D(referenceCoordinates=[c.crank + c.rod / 2, 0, 0],
                                          initialVelocities=[0, c.crank / 2 * c.speed, -c.speed * c.crank / c.rod])),
        mbs.AddNode(items.NodePoint2D(referenceCoordinates=[c.crank + c.rod, 0])),
    ]  # fmt: skip
    arm = mbs.AddObject(items.ObjectRigidBody2D(mass=1e-6, inertia=1e-9, nodeNumber=nodes[0]))
    rod = mbs.AddObject(items.ObjectRigidBody2D(mass=m, inertia=m * c.rod**2 / 12, nodeNumber=nodes[1]))
    slider = mbs.AddObject(items.ObjectMassPoint2D(mass=c.slider, nodeNumber=nodes[2]))

    def marker(body: Any, x: float) -> Any:
        return mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=body, localPosition=[x, 0, 0]))

    for a, b in (
        (marker(ground, 0), marker(arm, -c.crank / 2)),
        (marker(arm, c.crank / 2), marker(rod, -c.rod / 2)),
        (marker(rod, c.rod / 2), marker(slider, 0)),
    ):
        mbs.AddObject(items.ObjectJointRevolute2D(markerNumbers=[a, b]))
    fixed = mbs.AddMarker(
        items.MarkerNodeCoordinate(nodeNumber=mbs.AddNode(items.NodePointGround()), coordinate=0)
    )
    for node, coordinate, more in ((nodes[2], 1, {}), (nodes[0], 2, {"velocityLevel": True, "offset": c.speed})):
        along = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))
        mbs.AddObject(items.ObjectConnectorCoordinate(markerNumbers=[fixed, along], **more))
    kind = exu.OutputVariableType.Acceleration
    sensor = mbs.AddSensor(items.SensorNode(nodeNumber=nodes[2], storeInternal=True, outputVariableType=kind))
    mbs.Assemble()
    s = _settings(c.time, steps, 100)
    s.timeIntegration.generalizedAlpha.useIndex2Constraints = True
    s.timeIntegration.generalizedAlpha.useNewmark = rho == 1.0
    s.timeIntegration.generalizedAlpha.spectralRadius = rho
    s.timeIntegration.newton.useModifiedNewton = True
    mbs.SolveDynamic(s)
    return np.asarray(mbs.GetSensorStoredData(sensor))[:, 1]


def _tree(
    links: list[tuple[Any, list[float], float, list[float], np.ndarray]], gravity: list[float], start: list[float],
    forces: list[float], user: Callable | None, end: float, outputs: int, at: list[float], solve: Callable[[Any], Any],
) -> np.ndarray:  # fmt: skip
    """Place of the point `at` of the last link; links: joint type, offset, mass, centre of mass, inertia about it."""
    n = len(links)
    mbs = exu.SystemContainer().AddSystem()
    node = mbs.AddNode(
        items.NodeGenericODE2(
            referenceCoordinates=start, initialCoordinates=[0.0] * n, initialCoordinates_t=[0.0] * n,
            numberOfODE2Coordinates=n,
        )
    )  # fmt: skip
    more = {} if user is None else {"forceUserFunction": user}
    tree = mbs.AddObject(
        items.ObjectKinematicTree(
            nodeNumber=node, jointTypes=[k[0] for k in links], linkParents=list(range(-1, n - 1)),
            jointTransformations=exu.Matrix3DList([np.eye(3)] * n),
            jointOffsets=exu.Vector3DList([k[1] for k in links]),
            linkMasses=[k[2] for k in links], linkCOMs=exu.Vector3DList([k[3] for k in links]),
            linkInertiasCOM=exu.Matrix3DList([k[4] for k in links]),
            gravity=gravity, baseOffset=[0.0, 0.0, 0.0], jointForceVector=forces, **more,
        )
    )  # fmt: skip
    sensor = mbs.AddSensor(
        items.SensorKinematicTree(
            objectNumber=tree, linkNumber=n - 1, localPosition=at, storeInternal=True,
            outputVariableType=exu.OutputVariableType.Position,
        )
    )
    mbs.Assemble()
    s = _settings(end, 1, outputs)
    kind = solve(s)
    mbs.SolveDynamic(s, solverType=kind)
    return np.asarray(mbs.GetSensorStoredData(sensor))[-1, 1:]


def fixed(steps: int, kind: Any = Solver.RK67) -> Callable[[Any], Any]:
    """A method `kind` with this number of equal steps."""

    def chosen(s: Any) -> Any:
        s.timeIntegration.numberOfSteps = steps
        s.timeIntegration.automaticStepSize = False
        return kind

    return chosen


def variable(tolerance: float, outputs: int) -> Callable[[Any], Any]:
    """Its explicit method with step control."""

    def chosen(s: Any) -> Any:
        s.timeIntegration.numberOfSteps = outputs
        s.timeIntegration.relativeTolerance = s.timeIntegration.absoluteTolerance = tolerance
        return Solver.DOPRI5

    return chosen


def pendulum(solve: Callable[[Any], Any]) -> np.ndarray:
    """S3a."""
    p, z = PENDULUM, exu.JointType.RevoluteZ
    I = p.mass * p.length**2 / 12 * np.diag([0.0, 1.0, 1.0])
    links = [(z, [x, 0, 0], p.mass, [p.length / 2, 0, 0], I) for x in (0.0, p.length)]
    at = _tree(links, [0, -p.gravity, 0], [-np.pi / 4, 0], [0, 0], None, p.time, 10, [p.length, 0, 0], solve)
    return at[:2]


def arm(solve: Callable[[Any], Any], constant: bool) -> np.ndarray:
    """S4, S4c: torques by a user function, or constant ones. The axes of joints 2 and 3 are -y."""
    a, joint = ARM, exu.JointType

    def rod(density: float, end: np.ndarray, tip: float) -> tuple[float, list[float], np.ndarray]:
        """Of a rod to `end` with a point mass there: mass, centre, inertia about it."""
        m = density * np.linalg.norm(end)
        centre = (0.5 * m + tip) / (m + tip) * end
        I = (m / 12 + m * (centre / np.linalg.norm(end) @ (end / np.linalg.norm(end)) - 0.5) ** 2) * _about(end)
        return m + tip, list(centre), I + tip * _about(end - centre)

    first, second = np.array(a.first), np.array(a.second)
    links = [
        (joint.RevoluteZ, [0, 0, 0], 0.0, [0, 0, 0], np.zeros((3, 3))),
        (joint.RevoluteY, [0, 0, 0], *rod(a.density_1, first, a.mass_1)),
        (joint.RevoluteY, a.first, *rod(a.density_2, second, a.mass_2)),
    ]
    sign = np.array([1.0, -1.0, -1.0])
    mean, swing = np.array(TORQUES["mean"]) * sign, np.array(TORQUES["swing"]) * sign

    def torque(mbs: Any, t: float, item: int, q: np.ndarray, qt: np.ndarray) -> np.ndarray:
        return mean + swing * np.sin(TORQUES["omega"] * t)

    forces, user = (list(np.array(a.torques) * sign), None) if constant else ([0.0] * 3, torque)
    return _tree(links, [0, 0, -a.gravity], [0.0] * 3, forces, user, a.time, 14, list(second), solve)


def _about(r: np.ndarray) -> np.ndarray:
    """Inertia of a unit mass at r."""
    return r @ r * np.eye(3) - np.outer(r, r)


def _cable(n: int, axial: float) -> tuple[Any, list[Any], Any]:
    b = BEAM
    mbs = exu.SystemContainer().AddSystem()
    h = b.length / n
    nodes = [mbs.AddNode(items.NodePoint2DSlope1(referenceCoordinates=[k * h, 0, 1, 0])) for k in range(n + 1)]
    for k in range(n):
        mbs.AddObject(
            items.ObjectANCFCable2D(
                length=h, massPerLength=b.density, bendingStiffness=b.EI, axialStiffness=axial,
                nodeNumbers=nodes[k : k + 2],
            )
        )  # fmt: skip
    ground = mbs.AddNode(items.NodePointGround())
    fixed = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=ground, coordinate=0))
    for coordinate in (0, 1, 3):
        clamp = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=nodes[0], coordinate=coordinate))
        mbs.AddObject(items.ObjectConnectorCoordinate(markerNumbers=[fixed, clamp]))
    s = _settings()
    s.linearSolver.solverType = exu.LinearSolverType.EigenSparse
    return mbs, nodes, s


def bent(n: int, load_steps: int, axial: float, tolerance: float) -> np.ndarray:
    """S5: place of the tip; `tolerance` of Newton's method."""
    mbs, nodes, s = _cable(n, axial)
    end = mbs.AddMarker(items.MarkerNodePosition(nodeNumber=nodes[-1]))
    mbs.AddLoad(items.LoadForceVector(markerNumber=end, loadVector=[0, BEAM.force, 0]))
    mbs.Assemble()
    s.staticSolver.numberOfLoadSteps = load_steps
    s.staticSolver.newton.relativeTolerance = tolerance
    s.staticSolver.newton.absoluteTolerance = 0.01 * tolerance
    mbs.SolveStatic(s)
    return np.asarray(mbs.GetNodeOutput(nodes[-1], exu.OutputVariableType.Position))[:2]


def frequencies(n: int, axial: float) -> np.ndarray:
    """S8: the three lowest angular frequencies, from the sparse eigenvalue solver."""
    mbs, _, s = _cable(n, axial)
    mbs.Assemble()
    values, _ = mbs.ComputeODE2Eigenvalues(
        simulationSettings=s, useSparseSolver=True, numberOfEigenvalues=3, constrainedCoordinates=[0, 1, 3],
        ignoreAlgebraicEquations=True,
    )  # fmt: skip
    return np.sqrt(np.sort(np.abs(values))[:3])
