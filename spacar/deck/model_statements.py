"""A method for every keyword of the input language: the base of `Model`.

This file is made from the keyword table by `python -m spacar.deck.model_writer`; do not edit it.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence

from spacar.arrays import Array
from spacar.deck.statement import Value

Vector = Sequence[float] | Array


class ModelStatements(ABC):
    """One method a keyword; `statement` and `of_section` are those of the model that collects them."""

    @abstractmethod
    def statement(
        self, keyword: str, block: int, *values: Value | None, named: Mapping[str, Value | None] | None = None
    ) -> None:
        """Take in one statement of a block (1, 2 or 3)."""

    @abstractmethod
    def of_section(self, number: int, section: str | None, material: str | None, parts: int) -> None:
        """The BEAMSEC of an element, when it has one."""

    def plbeam(
        self, number: int, p: tuple[int, int], q: tuple[int, int], *, section: str | None = None,
        material: str | None = None, parts: int = 1,
    ) -> int:
        """PLBEAM: planar beam element.

        number  element number
        p       p position node, p orientation node
        q       q position node, q orientation node

        section, material and parts: its BEAMSEC, names of `section` and `material`.

        Deformation modes: 1 elongation [m]; 2 bending at p [m]; 3 bending at q [m].
        """
        self.statement("PLBEAM", 1, number, *p, *q)
        self.of_section(number, section, material, parts)
        return number

    def pltruss(self, number: int, p: int, q: int) -> int:
        """PLTRUSS: planar truss element.

        number  element number
        p       p position node
        q       q position node

        Deformation modes: 1 elongation [m].
        """
        self.statement("PLTRUSS", 1, number, p, q)
        return number

    def pltor(self, number: int, p: int, q: int) -> int:
        """PLTOR: planar hinge element.

        number  element number
        p       p orientation node
        q       q orientation node

        Deformation modes: 1 relative rotation [rad].
        """
        self.statement("PLTOR", 1, number, p, q)
        return number

    def plbear(self, number: int, p: tuple[int, int], q: tuple[int, int]) -> int:
        """PLBEAR: planar bearing element.

        number  element number
        p       p position node, p orientation node
        q       q position node, q orientation node

        Deformation modes: 1 displacement along direction 1 [m]; 2 displacement along direction 2 [m]; 3 relative
        rotation [rad].

        Not supported, as in the original program.
        """
        self.statement("PLBEAR", 1, number, *p, *q)
        return number

    def plpinbod(self, number: int, p: tuple[int, int], q: int) -> int:
        """PLPINBOD: planar pinbody element.

        number  element number
        p       p position node, p orientation node
        q       q position node

        Deformation modes: 1 displacement along direction 1 [m]; 2 displacement along direction 2 [m].
        """
        self.statement("PLPINBOD", 1, number, *p, q)
        return number

    def plrbeam(self, number: int, p: tuple[int, int], q: int) -> int:
        """PLRBEAM: planar rigid beam element.

        number  element number
        p       p position node, p orientation node
        q       q position node

        Deformation modes: 1 displacement along direction 1 [m]; 2 displacement along direction 2 [m].
        """
        self.statement("PLRBEAM", 1, number, *p, q)
        return number

    def plwheel(self, number: int, centre: int, yaw: int, spin: int, radius: float, spin_axis: Vector) -> int:
        """PLWHEEL: planar wheel element.

        number     element number
        centre     position node (wheel centre)
        yaw        orientation node (yaw angle)
        spin       orientation node (spin angle)
        radius     wheel radius [m]
        spin_axis  initial direction of the spin axis

        Deformation modes: 1 longitudinal slip [m]; 2 lateral slip [m].
        """
        self.statement("PLWHEEL", 1, number, centre, yaw, spin, radius, *spin_axis)
        return number

    def plbelt(self, number: int, p: tuple[int, int], q: tuple[int, int], radius_p: float, radius_q: float) -> int:
        """PLBELT: planar belt element.

        number    element number
        p         p position node, p orientation node
        q         q position node, q orientation node
        radius_p  base circle radius of the first pulley [m]
        radius_q  base circle radius of the second pulley [m]

        Deformation modes: 1 elongation of the belt [m].

        Positive radius: the belt runs on the left of that pulley when looking from p to q; opposite signs: crossed belt
        or gears.
        """
        self.statement("PLBELT", 1, number, *p, *q, radius_p, radius_q)
        return number

    def pltube(
        self, number: int, p: tuple[int, int], q: tuple[int, int], tangent_p: float | None = None,
        tangent_q: float | None = None,
    ) -> int:
        """PLTUBE: planar tube element.

        number     element number
        p          p position node, p orientation node
        q          q position node, q orientation node
        tangent_p  initial rotation of the tangent at p from the line pq [rad] (default 0)
        tangent_q  initial rotation of the tangent at q from the line pq [rad] (default 0)

        Deformation modes: 1 elongation [m]; 2 bending at p [m]; 3 bending at q [m].
        """
        self.statement("PLTUBE", 1, number, *p, *q, tangent_p, tangent_q)
        return number

    def beam(
        self, number: int, p: tuple[int, int], q: tuple[int, int], y_axis: Vector | None = None,
        coupling: float | None = None, *, section: str | None = None, material: str | None = None, parts: int = 1,
    ) -> int:
        """BEAM: spatial beam element.

        number    element number
        p         p position node, p orientation node
        q         q position node, q orientation node
        y_axis    initial direction of the principal y' axis
        coupling  torsion-elongation coupling f [m^2] (default 0)

        section, material and parts: its BEAMSEC, names of `section` and `material`.

        Deformation modes: 1 elongation [m]; 2 torsion [m]; 3 bending at p in the x'z' plane [m]; 4 bending at q in the
        x'z' plane [m]; 5 bending at p in the x'y' plane [m]; 6 bending at q in the x'y' plane [m].

        The direction lies in the local x'y' plane; default: the standard basis vector that makes the largest angle with
        the axis pq, of equals the one with the highest index. Local x' runs from p to q, z' = x' times y'.

        An axially unloaded beam with specific twist a shortens by f a^2/2 per length; thin-walled open section: (Iy +
        Iz)/A.

        With six arguments the sixth is the coupling f and the direction is the default one.
        """
        self.statement("BEAM", 1, number, *p, *q, *(() if y_axis is None else y_axis), coupling)
        self.of_section(number, section, material, parts)
        return number

    def beamw(
        self, number: int, p: tuple[int, int, int], q: tuple[int, int, int], y_axis: Vector,
        coupling: float | None = None, *, section: str | None = None, material: str | None = None, parts: int = 1,
    ) -> int:
        """BEAMW: spatial beam with warping element.

        number    element number
        p         p position node, p orientation node, p warping node
        q         q position node, q orientation node, q warping node
        y_axis    initial direction of the principal y' axis
        coupling  torsion-elongation coupling f [m^2] (default 0)

        section, material and parts: its BEAMSEC, names of `section` and `material`.

        Deformation modes: 1 elongation [m]; 2 torsion [m]; 3 bending at p in the x'z' plane [m]; 4 bending at q in the
        x'z' plane [m]; 5 bending at p in the x'y' plane [m]; 6 bending at q in the x'y' plane [m]; 7 warping at p [m];
        8 warping at q [m].

        The direction lies in the local x'y' plane; default: the standard basis vector that makes the largest angle with
        the axis pq, of equals the one with the highest index. Local x' runs from p to q, z' = x' times y'.

        An axially unloaded beam with specific twist a shortens by f a^2/2 per length; thin-walled open section: (Iy +
        Iz)/A.

        A warping node has one coordinate, the twist rate of the section in rad/m, zero at the start. It is a dynamic
        degree of freedom unless FIX (clamped section), INPUTX or KINX says otherwise; modes 7 and 8 are always
        calculable. Fix both warping nodes of a rigid one.
        """
        self.statement("BEAMW", 1, number, *p, *q, *y_axis, coupling)
        self.of_section(number, section, material, parts)
        return number

    def truss(self, number: int, p: int, q: int) -> int:
        """TRUSS: spatial truss element.

        number  element number
        p       p position node
        q       q position node

        Deformation modes: 1 elongation [m].
        """
        self.statement("TRUSS", 1, number, p, q)
        return number

    def hinge(self, number: int, p: int, q: int, axis: Vector) -> int:
        """HINGE: spatial hinge element.

        number  element number
        p       p orientation node
        q       q orientation node
        axis    initial direction of the x' axis (axis of rotation)

        Deformation modes: 1 relative rotation [rad]; 2 misalignment about y' [rad]; 3 misalignment about z' [rad].

        Local y' is the cross product of x' with the standard basis vector that makes the largest angle with x' (of
        equals the one with the highest index).
        """
        self.statement("HINGE", 1, number, p, q, *axis)
        return number

    def pinbody(self, number: int, p: tuple[int, int], q: int, y_axis: Vector | None = None) -> int:
        """PINBODY: spatial pinbody element.

        number  element number
        p       p position node, p orientation node
        q       q position node
        y_axis  initial direction of the principal y' axis

        Deformation modes: 1 displacement along direction 1 [m]; 2 displacement along direction 2 [m]; 3 displacement
        along direction 3 [m].

        Without direction the measuring directions start parallel to the global axes; with it x' is the line pq and the
        vector lies in the x'y' plane. ORPINBOD overrides.
        """
        self.statement("PINBODY", 1, number, *p, q, *(() if y_axis is None else y_axis))
        return number

    def rbeam(self, number: int, p: tuple[int, int], q: int, y_axis: Vector | None = None) -> int:
        """RBEAM: spatial rigid beam element.

        number  element number
        p       p position node, p orientation node
        q       q position node
        y_axis  initial direction of the principal y' axis

        Deformation modes: 1 displacement along direction 1 [m]; 2 displacement along direction 2 [m]; 3 displacement
        along direction 3 [m].

        The direction lies in the local x'y' plane; default: the standard basis vector that makes the largest angle with
        the axis pq, of equals the one with the highest index. Local x' runs from p to q, z' = x' times y'.
        """
        self.statement("RBEAM", 1, number, *p, q, *(() if y_axis is None else y_axis))
        return number

    def wheel(self, number: int, p: tuple[int, int], q: int, spin_axis: Vector) -> int:
        """WHEEL: disk wheel element.

        number     element number
        p          p position node (wheel centre), p orientation node (wheel)
        q          q position node (contact point)
        spin_axis  initial direction of the spin axis

        Deformation modes: 1 radial [m]; 2 axial [m]; 3 height of the contact point above the ground [m]; 4 position of
        the contact point along the ground [m]; 5 longitudinal slip [m^2]; 6 lateral slip [m^2].

        The radius is the initial distance between p and q.
        """
        self.statement("WHEEL", 1, number, *p, q, *spin_axis)
        return number

    def twheel(
        self, number: int, p: tuple[int, int], q: int, radius: float, tread_radius: float, spin_axis: Vector,
    ) -> int:
        """TWHEEL: torus wheel element.

        number        element number
        p             p position node (wheel centre), p orientation node (wheel)
        q             q position node (contact point)
        radius        radius in the equatorial plane [m]
        tread_radius  transverse (tread) radius [m]
        spin_axis     initial direction of the spin axis

        Deformation modes: 1 radial [m]; 2 axial [m]; 3 height of the contact point above the ground [m]; 4 position of
        the contact point along the ground [m]; 5 longitudinal slip [m^2]; 6 lateral slip [m^2].
        """
        self.statement("TWHEEL", 1, number, *p, q, radius, tread_radius, *spin_axis)
        return number

    def tube(
        self, number: int, p: tuple[int, int], q: tuple[int, int], y_axis: Vector | None = None,
        coupling: float | None = None,
    ) -> int:
        """TUBE: spatial tube element.

        number    element number
        p         p position node, p orientation node
        q         q position node, q orientation node
        y_axis    initial direction of the principal y' axis
        coupling  torsion-elongation coupling f [m^2] (default 0)

        Deformation modes: 1 elongation [m]; 2 torsion [m]; 3 bending at p in the x'z' plane [m]; 4 bending at q in the
        x'z' plane [m]; 5 bending at p in the x'y' plane [m]; 6 bending at q in the x'y' plane [m].

        The direction lies in the local x'y' plane; default: the standard basis vector that makes the largest angle with
        the axis pq, of equals the one with the highest index. Local x' runs from p to q, z' = x' times y'.

        An axially unloaded beam with specific twist a shortens by f a^2/2 per length; thin-walled open section: (Iy +
        Iz)/A.

        With six arguments the sixth is the coupling f and the direction is the default one.
        """
        self.statement("TUBE", 1, number, *p, *q, *(() if y_axis is None else y_axis), coupling)
        return number

    def screw(self, number: int, p: tuple[int, int], q: tuple[int, int], axis: Vector, pitch: float) -> int:
        """SCREW: screw element.

        number  element number
        p       p position node, p orientation node
        q       q position node, q orientation node
        axis    initial direction of the x' axis (axis of rotation)
        pitch   pitch, displacement per radian [m/rad]

        Deformation modes: 1 rotation about the screw axis [rad]; 2 displacement along the axis less pitch times
        rotation [m]; 3 displacement along y' [m]; 4 displacement along z' [m]; 5 misalignment about y' [rad]; 6
        misalignment about z' [rad].

        Local y' is the cross product of x' with the standard basis vector that makes the largest angle with x' (of
        equals the one with the highest index).
        """
        self.statement("SCREW", 1, number, *p, *q, *axis, pitch)
        return number

    def x(self, node: int, x1: float | None = None, x2: float | None = None, x3: float | None = None) -> None:
        """X: position of a node in the reference configuration.

        node  node number
        x1    coordinate x1 [m] (default 0)
        x2    coordinate x2 [m] (default 0)
        x3    coordinate x3 [m] (default 0)

        Nodes without X are at the origin. Initial orientations cannot be chosen.
        """
        self.statement("X", 1, node, x1, x2, x3)

    def fix(self, node: int, *coordinates: int) -> None:
        """FIX: support: coordinates that keep their reference value.

        node         node number
        coordinates  coordinate numbers; none: all

        Without coordinate numbers: all independent coordinates of the node (x1, x2, x3; the planar angle; lambda1,
        lambda2, lambda3). Coordinates are numbered 1 2 3 for positions, 1 for an angle, 1 2 3 4 for lambda0 ...
        lambda3, 1 for a warping node.

        A coordinate without FIX, INPUTX, DYNX or KINX is calculable.
        """
        self.statement("FIX", 1, node, *coordinates)

    def inputx(self, node: int, *coordinates: int) -> None:
        """INPUTX: coordinates that are prescribed functions of time.

        node         node number
        coordinates  coordinate numbers; none: all

        Without coordinate numbers: all independent coordinates of the node (x1, x2, x3; the planar angle; lambda1,
        lambda2, lambda3). Coordinates are numbered 1 2 3 for positions, 1 for an angle, 1 2 3 4 for lambda0 ...
        lambda3, 1 for a warping node.

        A coordinate without FIX, INPUTX, DYNX or KINX is calculable.
        """
        self.statement("INPUTX", 1, node, *coordinates)

    def dynx(self, node: int, *coordinates: int) -> None:
        """DYNX: coordinates that are dynamic degrees of freedom.

        node         node number
        coordinates  coordinate numbers; none: all

        Without coordinate numbers: all independent coordinates of the node (x1, x2, x3; the planar angle; lambda1,
        lambda2, lambda3). Coordinates are numbered 1 2 3 for positions, 1 for an angle, 1 2 3 4 for lambda0 ...
        lambda3, 1 for a warping node.

        A coordinate without FIX, INPUTX, DYNX or KINX is calculable.
        """
        self.statement("DYNX", 1, node, *coordinates)

    def kinx(self, node: int, *coordinates: int) -> None:
        """KINX: coordinates that are kinematic configuration coordinates.

        node         node number
        coordinates  coordinate numbers; none: all

        Without coordinate numbers: all independent coordinates of the node (x1, x2, x3; the planar angle; lambda1,
        lambda2, lambda3). Coordinates are numbered 1 2 3 for positions, 1 for an angle, 1 2 3 4 for lambda0 ...
        lambda3, 1 for a warping node.

        A coordinate without FIX, INPUTX, DYNX or KINX is calculable.

        Only for mechanisms with wheels: its rate is not an independent velocity.
        """
        self.statement("KINX", 1, node, *coordinates)

    def rlse(self, element: int, *modes: int) -> None:
        """RLSE: released (calculable) deformations.

        element  element number
        modes    mode numbers; none: all

        Without mode numbers: all modes of the element.

        A deformation without RLSE, INPUTE, DYNE or KINE is fixed.
        """
        self.statement("RLSE", 1, element, *modes)

    def inpute(self, element: int, *modes: int) -> None:
        """INPUTE: deformations that are prescribed functions of time.

        element  element number
        modes    mode numbers; none: all

        Without mode numbers: all modes of the element.

        A deformation without RLSE, INPUTE, DYNE or KINE is fixed.
        """
        self.statement("INPUTE", 1, element, *modes)

    def dyne(self, element: int, *modes: int) -> None:
        """DYNE: deformations that are dynamic degrees of freedom.

        element  element number
        modes    mode numbers; none: all

        Without mode numbers: all modes of the element.

        A deformation without RLSE, INPUTE, DYNE or KINE is fixed.
        """
        self.statement("DYNE", 1, element, *modes)

    def kine(self, element: int, *modes: int) -> None:
        """KINE: deformations that are kinematic configuration coordinates.

        element  element number
        modes    mode numbers; none: all

        Without mode numbers: all modes of the element.

        A deformation without RLSE, INPUTE, DYNE or KINE is fixed.

        Only for mechanisms with wheels: its rate is not an independent velocity.
        """
        self.statement("KINE", 1, element, *modes)

    def ldeform(self, element: int) -> None:
        """LDEFORM: leave out the non-linear terms in the strains of a beam.

        element  element number
        """
        self.statement("LDEFORM", 1, element)

    def adeform(self, element: int | None = None) -> None:
        """ADEFORM: measure the deformations of a beam or tube by angles: elements of fourth order.

        element  element number (default 0)

        Without element number: all beams and tubes of the file. --beams angle and --beams sine replace it.

        Recommended for new models: results converge with the fourth power of the element length, with the sine measure,
        the default, with the second (theory-beam-order4.md). Digits of the published examples belong to the sine
        measure.

        At most once for the same node or element.
        """
        self.statement("ADEFORM", 1, element)

    def orpinbod(self, element: int, *values: float) -> None:
        """ORPINBOD: measuring directions of a pinbody or rigid beam.

        element  element number

        In the order of the deck:
        - PLPINBOD, PLRBEAM: direction of x', x; direction of x', y
        - PLPINBOD, PLRBEAM: direction of x'x; direction of x'y; direction of y'x; direction of y'y
        - PINBODY, RBEAM: direction of x', x; direction of x', y; direction of x', z; vector in the x'y' plane, x;
          vector in the x'y' plane, y; vector in the x'y' plane, z
        - PINBODY, RBEAM: direction of x'x; direction of x'y; direction of x'z; direction of y'x; direction of y'y;
          direction of y'z; direction of z'x; direction of z'y; direction of z'z

        Planar, two numbers: x', normalized, y' turned 90 degrees to the left; four: both vectors as they are.

        Spatial, six numbers: made orthonormal and completed; nine: three vectors as they are.

        At most once for the same node or element.
        """
        self.statement("ORPINBOD", 1, element, *values)

    def drpinbod(
        self, element: int, projection_1: float | None = None, projection_2: float | None = None,
        projection_3: float | None = None,
    ) -> None:
        """DRPINBOD: undeformed projections of xq - xp on the directions of a pinbody or rigid beam.

        element       element number
        projection_1  undeformed projection on direction 1 [m] (default 0)
        projection_2  undeformed projection on direction 2 [m] (default 0)
        projection_3  undeformed projection on direction 3 [m] (default 0)

        Deformations are counted from these projections: STARTDE or INPUTE with 0.1 on mode 1 means the first projection
        plus 0.1, whatever X says. A free deformation without STARTDE, and a fixed one, starts at zero, so that the
        mechanism moves from X to these projections before the analysis begins.

        At most once for the same node or element.
        """
        self.statement("DRPINBOD", 1, element, projection_1, projection_2, projection_3)

    def ortube(self, element: int, tangent_p: Vector, tangent_q: Vector, y_axis_q: Vector) -> None:
        """ORTUBE: initial tangents and end direction of a curved spatial tube.

        element    element number
        tangent_p  tangent at p (local x')
        tangent_q  tangent at q
        y_axis_q   direction of the local y' axis at q

        At most once for the same node or element.
        """
        self.statement("ORTUBE", 1, element, *tangent_p, *tangent_q, *y_axis_q)

    def outlevel(self, log: int, sbd: int | None = None) -> None:
        """OUTLEVEL: amount of output in the log and in the .sbd file (sums of flags, -1: everything).

        log  level of the log
        sbd  level of the .sbd file (default 0)

        Log: 1 first order transfer functions, 2 second order, 4 third order, 8 derivatives of the global deformation
        function (2, 4, 8: modes 4, 7, 8, 9).

        .sbd: 1 adds de, dx; 2 adds d2e, d2x; 3 both. Without OUTLEVEL: 0, but 1 in modes 7, 8 and 9.

        At most once in a file.
        """
        self.statement("OUTLEVEL", 1, log, sbd)

    def units(self, unit: str) -> None:
        """UNITS: unit of length of the whole file.

        unit  unit: m or mm

        With mm every m in the units of this page is read as mm: lengths in mm, E in N/mm^2 (MPa), density in kg/mm^3,
        moments in N mm, gravity in mm/s^2. Newton, kilogram, second and radian stay, results are in SI.

        At most once in a file.
        """
        self.statement("UNITS", 1, unit)

    def section(self, name: str, shape: str, *dimensions: float) -> None:
        """SECTION: cross-section by its shape.

        name        name
        shape       shape
        dimensions  dimension 1, 2, ...

        A name starts with a letter; capitals and small letters are the same.

        RECT (rectangle): w along y', t along z'.

        CIRC (circle): diameter d.

        TUBE (tube): outer diameter d, wall t.

        RECTHOL (hollow rectangle): w along y', h along z', inner w, inner h.

        I (I section): flange b along y', height h along z', web tw, flange tf.

        CUSTOM (constants as given): A [m^2], Iy [m^4], Iz [m^4], It [m^4], ky, kz, Cw [m^6].

        y' is the direction of the element statement, the normal of the axis in a planar model. Zero ky or kz: no shear
        flexibility.

        At most once for the same node or element.
        """
        self.statement("SECTION", 1, name, shape, *dimensions)

    def material(self, name: str, E: float, G: float, rho: float | None = None) -> None:
        """MATERIAL: elastic material.

        name  name
        E     Young's modulus E [N/m^2]
        G     shear modulus G, or Poisson's ratio up to 0.5 [N/m^2]
        rho   density rho [kg/m^3] (default 0)

        A name starts with a letter; capitals and small letters are the same.

        Known without a statement: steel (210 GPa, nu 0.3, 7850 kg/m^3), stainless (193 GPa, nu 0.29, 8000 kg/m^3),
        aluminium (70 GPa, nu 0.33, 2700 kg/m^3), titanium (114 GPa, nu 0.34, 4430 kg/m^3), brass (100 GPa, nu 0.34,
        8500 kg/m^3), copper (120 GPa, nu 0.34, 8960 kg/m^3).

        At most once for the same node or element.
        """
        self.statement("MATERIAL", 1, name, E, G, rho)

    def beamsec(self, element: int, section: str, material: str, parts: int | None = None) -> None:
        """BEAMSEC: section and material of a beam, and of how many equal beams it consists.

        element   element number
        section   name of a section
        material  name of a material
        parts     number of beams in its place (default 1)

        Stands for ESTIFF and EM of the element (without a density for ESTIFF alone), which must not be given then.
        `spacar check --expand` prints the input without these keywords.

        With several beams the first one keeps the number of the element; further elements and nodes get numbers above
        all others. Statements about the element hold for all its beams.

        At most once for the same node or element.
        """
        self.statement("BEAMSEC", 1, element, section, material, parts)

    def xm(
        self, node: int, *values: float, mass: float | None = None, J: float | None = None, Jxx: float | None = None,
        Jxy: float | None = None, Jxz: float | None = None, Jyy: float | None = None, Jyz: float | None = None,
        Jzz: float | None = None,
    ) -> None:
        """XM: lumped mass or inertia of a node.

        node  node number

        In the order of the deck, or by name (what has no name is zero, or its default):
        - position node: mass [kg]
        - planar orientation node: moment of inertia J [kg m^2]
        - spatial orientation node: Jxx [kg m^2] = 0; Jxy [kg m^2] = 0; Jxz [kg m^2] = 0; Jyy [kg m^2] = 0; Jyz [kg m^2]
          = 0; Jzz [kg m^2] = 0
        - warping node: warping inertia J [kg m^4]

        Components of the tensor about the global axes in the initial configuration; Jxy etc. carry a minus sign against
        the products of inertia.

        At most once for the same node or element.
        """
        self.statement(
            "XM", 2, node, *values, named={"mass": mass, "J": J, "Jxx": Jxx, "Jxy": Jxy, "Jxz": Jxz, "Jyy": Jyy,
            "Jyz": Jyz, "Jzz": Jzz},
        )

    def em(
        self, element: int, *values: float, mass: float | None = None, J: float | None = None,
        Jxx: float | None = None, Jyy: float | None = None, Jzz: float | None = None, Jyz: float | None = None,
        Jw: float | None = None, wound_p: float | None = None, wound_q: float | None = None,
        fluid_mass: float | None = None, flow: float | None = None, shape_factor: float | None = None,
        end_condition: int | None = None,
    ) -> None:
        """EM: distributed mass of an element.

        element  element number

        In the order of the deck, or by name (what has no name is zero, or its default):
        - PLTRUSS, TRUSS: mass per length [kg/m]
        - PLBEAM, PLRBEAM: mass per length [kg/m]; J per length [kg m] = 0
        - BEAM, RBEAM: mass per length [kg/m]; Jxx (Jx'x') [kg m] = 0; Jyy (Jy'y') [kg m] = 0; Jzz (Jz'z') [kg m] = 0;
          Jyz (Jy'z') [kg m] = 0
        - BEAMW: mass per length [kg/m]; Jxx (Jx'x') [kg m] = 0; Jyy (Jy'y') [kg m] = 0; Jzz (Jz'z') [kg m] = 0; Jyz
          (Jy'z') [kg m] = 0; warping inertia Jw per length [kg m^3] = 0
        - PLBELT: mass per length [kg/m]; wound_p (angle wound over the first pulley) [rad] = 0; wound_q (angle wound
          over the second pulley) [rad] = 0
        - PLTUBE: tube mass per length [kg/m]; fluid_mass (fluid mass per length) [kg/m] = 0; mass flow rate [kg/s] = 0;
          shape_factor (flow shape factor) = 1; end_condition (end condition 0-3) = 0; J per length [kg m] = 0
        - TUBE: tube mass per length [kg/m]; fluid_mass (fluid mass per length) [kg/m] = 0; mass flow rate [kg/s] = 0;
          shape_factor (flow shape factor) = 1; end_condition (end condition 0-3) = 0; Jxx (Jx'x') [kg m] = 0; Jyy
          (Jy'y') [kg m] = 0; Jzz (Jz'z') [kg m] = 0; Jyz (Jy'z') [kg m] = 0

        End condition of a tube: 0 spherical flow at p and q, 1 jet at p, 2 jet at q, 3 jets at both.

        At most once for the same node or element.
        """
        self.statement(
            "EM", 2, element, *values, named={"mass": mass, "J": J, "Jxx": Jxx, "Jyy": Jyy, "Jzz": Jzz, "Jyz": Jyz,
            "Jw": Jw, "wound_p": wound_p, "wound_q": wound_q, "fluid_mass": fluid_mass, "flow": flow,
            "shape_factor": shape_factor, "end_condition": end_condition},
        )

    def xgyro(
        self, node: int, Omega1: float, Omega2: float, Omega3: float, J: float, prescribed: int | None = None,
    ) -> None:
        """XGYRO: gyrostat: a rotor carried by an orientation node.

        node        orientation node
        Omega1      angular velocity Omega1 [rad/s]
        Omega2      angular velocity Omega2 [rad/s]
        Omega3      angular velocity Omega3 [rad/s]
        J           rotor inertia J [kg m^2]
        prescribed  type: 0 free, 1 prescribed (default 0)

        Free rotor: components of its absolute angular velocity; prescribed: of the constant one relative to the
        carrier.

        At most once for the same node or element.
        """
        self.statement("XGYRO", 2, node, Omega1, Omega2, Omega3, J, prescribed)

    def mee(self, element: int, mode: int, *values: float) -> None:
        """MEE: fixed entry of the mass matrix for deformations.

        element  element number
        mode     mode number

        In the order of the deck:
        - 3 arguments: value on the diagonal [kg]
        - 5 arguments: element number; mode number; coupling value [kg]

        At most once for the same node or element, coordinate or mode.
        """
        self.statement("MEE", 2, element, mode, *values)

    def estiff(
        self, element: int, *values: float, EA: float | None = None, EI: float | None = None,
        shear: float | None = None, GIt: float | None = None, EIy: float | None = None, EIz: float | None = None,
        shear_z: float | None = None, shear_y: float | None = None, ECw: float | None = None, S1: float | None = None,
        S2: float | None = None, S3: float | None = None, S4: float | None = None, S5: float | None = None,
        S6: float | None = None,
    ) -> None:
        """ESTIFF: stiffness of an element.

        element  element number

        In the order of the deck, or by name (what has no name is zero, or its default):
        - PLTRUSS, PLBELT, TRUSS: EA [N]
        - PLBEAM, PLTUBE: EA [N]; EI [N m^2] = 0; shear parameter EI/(GAk) [m^2] = 0
        - BEAM, TUBE: EA [N]; GIt [N m^2] = 0; EIy [N m^2] = 0; EIz [N m^2] = 0; shear_z (shear parameter EIy/(GAkz))
          [m^2] = 0; shear_y (shear parameter EIz/(GAky)) [m^2] = 0
        - BEAMW: EA [N]; GIt [N m^2] = 0; EIy [N m^2] = 0; EIz [N m^2] = 0; shear_z (shear parameter EIy/(GAkz)) [m^2] =
          0; shear_y (shear parameter EIz/(GAky)) [m^2] = 0; ECw [N m^4] = 0
        - PLTOR: S1 [coefficient of mode 1]
        - PLPINBOD, PLRBEAM: S1 [coefficient of mode 1]; S2 [coefficient of mode 2] = 0
        - HINGE, PINBODY, RBEAM: S1 [coefficient of mode 1]; S2 [coefficient of mode 2] = 0; S3 [coefficient of mode 3]
          = 0
        - WHEEL, TWHEEL, SCREW: S1 [coefficient of mode 1]; S2 [coefficient of mode 2] = 0; S3 [coefficient of mode 3] =
          0; S4 [coefficient of mode 4] = 0; S5 [coefficient of mode 5] = 0; S6 [coefficient of mode 6] = 0

        Unspecified values are zero; a zero shear parameter means no shear flexibility.

        Surplus zeros are ignored; a surplus value that is not zero is an error.

        At most once for the same node or element.
        """
        self.statement(
            "ESTIFF", 2, element, *values, named={"EA": EA, "EI": EI, "shear": shear, "GIt": GIt, "EIy": EIy,
            "EIz": EIz, "shear_z": shear_z, "shear_y": shear_y, "ECw": ECw, "S1": S1, "S2": S2, "S3": S3, "S4": S4,
            "S5": S5, "S6": S6},
        )

    def edamp(
        self, element: int, *values: float, EdA: float | None = None, EdI: float | None = None,
        GdIt: float | None = None, EdIy: float | None = None, EdIz: float | None = None, EdCw: float | None = None,
        Sd1: float | None = None, Sd2: float | None = None, Sd3: float | None = None, Sd4: float | None = None,
        Sd5: float | None = None, Sd6: float | None = None,
    ) -> None:
        """EDAMP: damping of an element (Kelvin-Voigt).

        element  element number

        In the order of the deck, or by name (what has no name is zero, or its default):
        - PLTRUSS, PLBELT, TRUSS: EdA [N s]
        - PLBEAM, PLTUBE: EdA [N s]; EdI [N m^2 s] = 0
        - BEAM, TUBE: EdA [N s]; GdIt [N m^2 s] = 0; EdIy [N m^2 s] = 0; EdIz [N m^2 s] = 0
        - BEAMW: EdA [N s]; GdIt [N m^2 s] = 0; EdIy [N m^2 s] = 0; EdIz [N m^2 s] = 0; not used = 0; not used = 0; EdCw
          [N m^4 s] = 0
        - PLTOR: Sd1 [coefficient of mode 1]
        - PLPINBOD, PLRBEAM, PLWHEEL: Sd1 [coefficient of mode 1]; Sd2 [coefficient of mode 2] = 0
        - HINGE, PINBODY, RBEAM: Sd1 [coefficient of mode 1]; Sd2 [coefficient of mode 2] = 0; Sd3 [coefficient of mode
          3] = 0
        - WHEEL, TWHEEL, SCREW: Sd1 [coefficient of mode 1]; Sd2 [coefficient of mode 2] = 0; Sd3 [coefficient of mode
          3] = 0; Sd4 [coefficient of mode 4] = 0; Sd5 [coefficient of mode 5] = 0; Sd6 [coefficient of mode 6] = 0

        Surplus zeros are ignored; a surplus value that is not zero is an error.

        At most once for the same node or element.
        """
        self.statement(
            "EDAMP", 2, element, *values, named={"EdA": EdA, "EdI": EdI, "GdIt": GdIt, "EdIy": EdIy, "EdIz": EdIz,
            "EdCw": EdCw, "Sd1": Sd1, "Sd2": Sd2, "Sd3": Sd3, "Sd4": Sd4, "Sd5": Sd5, "Sd6": Sd6},
        )

    def timestep(self, duration: float, steps: int) -> None:
        """TIMESTEP: length of the time interval and number of time steps.

        duration  length of the time interval [s]
        steps     number of time steps

        At most once in a file.
        """
        self.statement("TIMESTEP", 2, duration, steps)

    def inputx_motion(
        self, node: int, coordinate: int, start: float | None = None, rate: float | None = None,
        acceleration: float | None = None,
    ) -> None:
        """INPUTX: time function of a prescribed coordinate.

        node          node number
        coordinate    coordinate number
        start         start value (when left out: the value given with X, for lambda0 1)
        rate          start rate [1/s] (default 0)
        acceleration  constant acceleration [1/s^2] (default 0)

        Only for a prescribed coordinate or deformation.

        At most once for the same node or element, coordinate or mode.
        """
        self.statement("INPUTX", 2, node, coordinate, start, rate, acceleration)

    def inpute_motion(
        self, element: int, mode: int, start: float | None = None, rate: float | None = None,
        acceleration: float | None = None,
    ) -> None:
        """INPUTE: time function of a prescribed deformation.

        element       element number
        mode          mode number
        start         start value (default 0)
        rate          start rate [1/s] (default 0)
        acceleration  constant acceleration [1/s^2] (default 0)

        A start value is the deformation with respect to the configuration given with X; with DRPINBOD it is counted
        from the projections given there.

        Only for a prescribed coordinate or deformation.

        At most once for the same node or element, coordinate or mode.
        """
        self.statement("INPUTE", 2, element, mode, start, rate, acceleration)

    def startdx(self, node: int, coordinate: int, start: float | None = None, rate: float | None = None) -> None:
        """STARTDX: start value of a dynamic coordinate.

        node        node number
        coordinate  coordinate number
        start       start value (when left out: the value given with X, for lambda0 1)
        rate        start rate [1/s] (default 0)

        A zero start value and rate of what is neither dynamic nor kinematic has no effect and gives a warning.

        Only for a dynamic or kinematic coordinate or deformation.

        At most once for the same node or element, coordinate or mode.
        """
        self.statement("STARTDX", 2, node, coordinate, start, rate)

    def startde(self, element: int, mode: int, start: float | None = None, rate: float | None = None) -> None:
        """STARTDE: start value of a dynamic deformation.

        element  element number
        mode     mode number
        start    start value (default 0)
        rate     start rate [1/s] (default 0)

        A start value is the deformation with respect to the configuration given with X; with DRPINBOD it is counted
        from the projections given there.

        A zero start value and rate of what is neither dynamic nor kinematic has no effect and gives a warning.

        Only for a dynamic or kinematic coordinate or deformation.

        At most once for the same node or element, coordinate or mode.
        """
        self.statement("STARTDE", 2, element, mode, start, rate)

    def userinp(self, function: str) -> None:
        """USERINP: user function with prescribed motion.

        function  name of the function

        t, e, x = name(t, is), in name.py beside the input file; each row of e and x is number, mode or coordinate
        number, value, rate, acceleration.

        At most once in a file.
        """
        self.statement("USERINP", 2, function)

    def xf(
        self, node: int, *values: float, Fx: float | None = None, Fy: float | None = None, Fz: float | None = None,
        moment: float | None = None, lambda0: float | None = None, lambda1: float | None = None,
        lambda2: float | None = None, lambda3: float | None = None, Mx: float | None = None, My: float | None = None,
        Mz: float | None = None, bimoment: float | None = None,
    ) -> None:
        """XF: external force on a node, constant in time.

        node  node number

        In the order of the deck, or by name (what has no name is zero, or its default):
        - planar position node: force Fx [N]; force Fy [N] = 0
        - spatial position node: force Fx [N]; force Fy [N] = 0; force Fz [N] = 0
        - planar orientation node: moment [N m]
        - spatial orientation node: force dual to lambda0 [N m]; force dual to lambda1 [N m] = 0; force dual to lambda2
          [N m] = 0; force dual to lambda3 [N m] = 0
        - spatial orientation node: moment Mx [N m]; moment My [N m]; moment Mz [N m]
        - warping node: bimoment [N m^2]

        Four numbers on a spatial orientation node are dual to lambda0 ... lambda3 (a moment M in the reference
        orientation is 0 2Mx 2My 2Mz); exactly three are a moment about the global axes; one or two are dual to lambda.

        At most once for the same node or element.
        """
        self.statement(
            "XF", 2, node, *values, named={"Fx": Fx, "Fy": Fy, "Fz": Fz, "moment": moment, "lambda0": lambda0,
            "lambda1": lambda1, "lambda2": lambda2, "lambda3": lambda3, "Mx": Mx, "My": My, "Mz": Mz,
            "bimoment": bimoment},
        )

    def usersig(self, function: str) -> None:
        """USERSIG: user function with forces and stresses.

        function  name of the function

        time, sig, f = name(t, ne, le, e, ep, nx, lnp, x, xp), in name.py beside the input file.

        Each row of sig is element number, mode number, stress [, k, d], each row of f node number, coordinate number,
        force [, k, d], in the numbers of the input file (from 1); sig and f may be empty. k and d are optional:
        dsigma/de and dsigma/d(ep), or -df/dx and -df/d(xp), for the linearized equations.

        e, ep (length ne) and x, xp (length nx) are all deformations and coordinates with their rates. le[i - 1, m - 1]
        is the place of mode m of element i in e and ep, lnp[n - 1, c - 1] that of coordinate c of node n in x and xp:
        places from 0 (the tables in result files count from 1), -1 for what does not exist. A negative place in e, ep,
        x or xp is an error, it does not read the last value.

        A stress on a fixed or prescribed mode has no effect, because its stress follows from equilibrium: the run gives
        a warning.

        At most once in a file.
        """
        self.statement("USERSIG", 2, function)

    def gravity(self, gx: float | None = None, gy: float | None = None, gz: float | None = None) -> None:
        """GRAVITY: acceleration of gravity.

        gx  component gx [m/s^2] (default 0)
        gy  component gy [m/s^2] (default 0)
        gz  component gz [m/s^2] (default 0)

        Acts on lumped and distributed mass.

        At most once in a file.
        """
        self.statement("GRAVITY", 2, gx, gy, gz)

    def esig(self, element: int, *stresses: float) -> None:
        """ESIG: preload of an element.

        element   element number
        stresses  preload stress of mode 1, 2, ...

        Surplus zeros are ignored; a surplus value that is not zero is an error.

        A preload on a fixed mode, or on a prescribed one except in mode 3, has no effect, because its stress follows
        from equilibrium: a warning.

        At most once for the same node or element.
        """
        self.statement("ESIG", 2, element, *stresses)

    def delxf(
        self, node: int, *values: float, Fx: float | None = None, Fy: float | None = None, Fz: float | None = None,
        moment: float | None = None, lambda0: float | None = None, lambda1: float | None = None,
        lambda2: float | None = None, lambda3: float | None = None, Mx: float | None = None, My: float | None = None,
        Mz: float | None = None, bimoment: float | None = None,
    ) -> None:
        """DELXF: increment of the force on a node.

        node  node number

        In the order of the deck, or by name (what has no name is zero, or its default):
        - planar position node: increment of the force Fx [N]; increment of the force Fy [N] = 0
        - spatial position node: increment of the force Fx [N]; increment of the force Fy [N] = 0; increment of the
          force Fz [N] = 0
        - planar orientation node: increment of the moment [N m]
        - spatial orientation node: increment of the force dual to lambda0 [N m]; increment of the force dual to lambda1
          [N m] = 0; increment of the force dual to lambda2 [N m] = 0; increment of the force dual to lambda3 [N m] = 0
        - spatial orientation node: increment of the moment Mx [N m]; increment of the moment My [N m]; increment of the
          moment Mz [N m]
        - warping node: increment of the bimoment [N m^2]

        Four numbers on a spatial orientation node are dual to lambda0 ... lambda3 (a moment M in the reference
        orientation is 0 2Mx 2My 2Mz); exactly three are a moment about the global axes; one or two are dual to lambda.

        At most once for the same node or element.
        """
        self.statement(
            "DELXF", 2, node, *values, named={"Fx": Fx, "Fy": Fy, "Fz": Fz, "moment": moment, "lambda0": lambda0,
            "lambda1": lambda1, "lambda2": lambda2, "lambda3": lambda3, "Mx": Mx, "My": My, "Mz": Mz,
            "bimoment": bimoment},
        )

    def delgrav(self, gx: float | None = None, gy: float | None = None, gz: float | None = None) -> None:
        """DELGRAV: increment of the acceleration of gravity.

        gx  increment gx [m/s^2] (default 0)
        gy  increment gy [m/s^2] (default 0)
        gz  increment gz [m/s^2] (default 0)

        At most once in a file.
        """
        self.statement("DELGRAV", 2, gx, gy, gz)

    def delomf(self, element: int, increment: float) -> None:
        """DELOMF: increment of the mass flow rate of a tube.

        element    element number
        increment  increment of the mass flow rate [kg/s]

        At most once for the same node or element.
        """
        self.statement("DELOMF", 2, element, increment)

    def delesig(self, element: int, *increments: float) -> None:
        """DELESIG: increment of the preload of an element.

        element     element number
        increments  increment of the stress of mode 1, 2, ...

        At most once for the same node or element.
        """
        self.statement("DELESIG", 2, element, *increments)

    def delinpx(self, node: int, coordinate: int, increment: float) -> None:
        """DELINPX: increment of a prescribed coordinate.

        node        node number
        coordinate  coordinate number
        increment   increment of the start value

        Only for a prescribed coordinate or deformation.

        At most once for the same node or element, coordinate or mode.
        """
        self.statement("DELINPX", 2, node, coordinate, increment)

    def delinpe(self, element: int, mode: int, increment: float) -> None:
        """DELINPE: increment of a prescribed deformation.

        element    element number
        mode       mode number
        increment  increment of the start value

        Only for a prescribed coordinate or deformation.

        At most once for the same node or element, coordinate or mode.
        """
        self.statement("DELINPE", 2, element, mode, increment)

    def integrat(self, method: int, step: float | None = None) -> None:
        """INTEGRAT: integration method.

        method  type of integrator
        step    step size or initial step size [s] (default 0)

        Without INTEGRAT the method chooses itself, type -1: 0, and 595 from where a vibration faster than the motion
        limits the steps; the log says when.

        Types: 0 Shampine-Gordon (what the original program takes without INTEGRAT); 130, 140 explicit Runge-Kutta of
        order 3, 4 with fixed step, 135, 155 of order 3, 5 with variable step; 220, 225 for second order systems, fixed
        and variable; 310, 320, 330 Rosenbrock; 410 implicit Euler; 420, 430 diagonally implicit Runge-Kutta. Ours: 553,
        595 Radau IIA of order 5, 9 with variable step, for stiff models; 853 explicit Runge-Kutta of order 8 with
        variable step; -1 the default.

        At most once in a file.
        """
        self.statement("INTEGRAT", 2, method, step)

    def error(self, absolute: float | None = None, relative: float | None = None) -> None:
        """ERROR: error tolerances of the integration.

        absolute  absolute error (default 1e-05)
        relative  relative error (default 0.0001)

        Used by types 0, 135, 155, 225, 553, 595, 853; for 410, 420, 430 the absolute error is the tolerance of the
        Newton iteration.

        At most once in a file.
        """
        self.statement("ERROR", 2, absolute, relative)

    def iterstep(
        self, iterations: int | None = None, load_steps: int | None = None, tolerance: float | None = None,
        store_every: int | None = None, analysis: int | None = None, initial_steps: int | None = None,
        follow_path: int | None = None,
    ) -> None:
        """ITERSTEP: settings of the stationary solution.

        iterations     maximum number of iterations (default 10)
        load_steps     number of load steps (default 4)
        tolerance      error tolerance (default 5e-07)
        store_every    number of steps between output steps (default 1)
        analysis       type of analysis 0-3 (default 0)
        initial_steps  number of load steps for the initial solution (default 0)
        follow_path    follow the equilibrium path beyond limit points: 0 no, 1 yes (default 0)

        Type 0: initial loading; 1: the same with N0 zero; 2: initial and additional loading; 3: the same with N0 zero.

        At a limit point of the loading (snap-through) the analysis stops and says which part of the loading was
        reached; position 7 = 1 follows the equilibrium path beyond it to where it reaches the load again.

        At most once in a file.
        """
        self.statement(
            "ITERSTEP", 2, iterations, load_steps, tolerance, store_every, analysis, initial_steps, follow_path,
        )

    def modes(self, lowest_modes: int) -> None:
        """MODES: number of modes of vibration and buckling (modes 7, 8, 10; of large models also 4 and 9).

        lowest_modes  number of lowest modes; 0: all

        Ours. Without it all modes of a model with up to 200 dynamic degrees of freedom are computed, and the 20 lowest
        of a larger one at rest. A larger model has sparse matrices instead of the reduced ones then; 0 asks for
        everything.

        Modes 4 and 9 store sparse equations of models with more than 200 dynamic degrees of freedom, and their n lowest
        modes only with MODES n; 0 asks for the reduced matrices and A, B, C, D. So does mode 3 with more than 200
        degrees of freedom, prescribed ones counted, without modes.

        At most once in a file.
        """
        self.statement("MODES", 2, lowest_modes)

    def traject(self, trajectory: int) -> None:
        """TRAJECT: starts a trajectory; holds until the next TRAJECT.

        trajectory  trajectory number
        """
        self.statement("TRAJECT", 3, trajectory)

    def trot(
        self, node: int, angle: float, h1: float | None = None, h2: float | None = None, h3: float | None = None,
    ) -> None:
        """TROT: path: rotation of an orientation node.

        node   orientation node
        angle  total angle [rad]
        h1     fixed axis h1
        h2     fixed axis h2
        h3     fixed axis h3
        """
        self.statement("TROT", 3, node, angle, h1, h2, h3)

    def trans(self, node: int, x1: float, x2: float, x3: float | None = None) -> None:
        """TRANS: path: straight line of a position node.

        node  position node
        x1    end position x1 [m]
        x2    end position x2 [m]
        x3    end position x3 [m]
        """
        self.statement("TRANS", 3, node, x1, x2, x3)

    def trcirl(
        self, node: int, c1: float, c2: float, *values: float, x1: float | None = None, x2: float | None = None,
        c3: float | None = None, x3: float | None = None,
    ) -> None:
        """TRCIRL: path: circular arc of a position node.

        node  position node
        c1    centre c1 [m]
        c2    centre c2 [m]

        In the order of the deck, or by name (what has no name is zero, or its default):
        - planar: end point x1 [m]; end point x2 [m]
        - spatial: centre c3 [m]; end point x1 [m]; end point x2 [m]; end point x3 [m]

        Only the direction from the centre to the end point counts: the arc ends on that line.
        """
        self.statement("TRCIRL", 3, node, c1, c2, *values, named={"x1": x1, "x2": x2, "c3": c3, "x3": x3})

    def tre(self, element: int, displacement: float) -> None:
        """TRE: path: first deformation mode of an element.

        element       element number
        displacement  total displacement (angle or elongation)
        """
        self.statement("TRE", 3, element, displacement)

    def usertraj(self, function: str) -> None:
        """USERTRAJ: path: user function, called as USERINP.

        function  name of the function
        """
        self.statement("USERTRAJ", 3, function)

    def trtime(
        self, duration: float, *values: float, steps: int | None = None, intermediate_steps: int | None = None,
    ) -> None:
        """TRTIME: time of the trajectory.

        duration  total time of this trajectory [s]

        In the order of the deck, or by name (what has no name is zero, or its default):
        - 2 arguments: number of time steps
        - 3 arguments: number of steps with an extended analysis; intermediate_steps (number of intermediate steps
          within each)
        """
        self.statement("TRTIME", 3, duration, *values, named={"steps": steps, "intermediate_steps": intermediate_steps})

    def trepmax(self, element: int, rise_time: float | None = None, extreme_velocity: float | None = None) -> None:
        """TREPMAX: velocity profile of an element.

        element           element number
        rise_time         rise time [s] (default 0)
        extreme_velocity  extreme velocity [1/s] (default 0)

        No or zero rise time: symmetric; no extreme velocity: no period of constant velocity.
        """
        self.statement("TREPMAX", 3, element, rise_time, extreme_velocity)

    def trvmax(self, node: int, rise_time: float | None = None, extreme_velocity: float | None = None) -> None:
        """TRVMAX: velocity profile of a node.

        node              node number
        rise_time         rise time [s] (default 0)
        extreme_velocity  extreme velocity [1/s] (default 0)

        No or zero rise time: symmetric; no extreme velocity: no period of constant velocity.
        """
        self.statement("TRVMAX", 3, node, rise_time, extreme_velocity)

    def trfront(self, number: int, front: int | None = None) -> None:
        """TRFRONT: shape of the fronts of the velocity profile.

        number  node or element number
        front   front type: 0 constant acceleration, 1 sine, 2 squared sine (default 0)
        """
        self.statement("TRFRONT", 3, number, front)

    def trm(
        self, node: int, *values: float, mass: float | None = None, J: float | None = None, Jxx: float | None = None,
        Jxy: float | None = None, Jxz: float | None = None, Jyy: float | None = None, Jyz: float | None = None,
        Jzz: float | None = None,
    ) -> None:
        """TRM: extra mass of a node during a trajectory.

        node  node number

        In the order of the deck, or by name (what has no name is zero, or its default):
        - position node: extra mass [kg]
        - planar orientation node: extra J [kg m^2]
        - spatial orientation node: extra Jxx [kg m^2] = 0; extra Jxy [kg m^2] = 0; extra Jxz [kg m^2] = 0; extra Jyy
          [kg m^2] = 0; extra Jyz [kg m^2] = 0; extra Jzz [kg m^2] = 0
        """
        self.statement(
            "TRM", 3, node, *values, named={"mass": mass, "J": J, "Jxx": Jxx, "Jxy": Jxy, "Jxz": Jxz, "Jyy": Jyy,
            "Jyz": Jyz, "Jzz": Jzz},
        )

    def trf(self, node: int, Fx: float, Fy: float, Fz: float | None = None) -> None:
        """TRF: extra force on a position node during a trajectory.

        node  position node
        Fx    extra force Fx [N]
        Fy    extra force Fy [N]
        Fz    extra force Fz [N]
        """
        self.statement("TRF", 3, node, Fx, Fy, Fz)

    def noms(self, input: int, element: int, mode: int) -> None:
        """NOMS: nominal input: generalized stress of an actuator element.

        input    input number
        element  element number
        mode     mode number
        """
        self.statement("NOMS", 3, input, element, mode)

    def nomf(self, input: int, node: int, coordinate: int) -> None:
        """NOMF: nominal input: nodal force.

        input       input number
        node        node number
        coordinate  coordinate number
        """
        self.statement("NOMF", 3, input, node, coordinate)

    def refe(self, output: int, element: int, mode: int) -> None:
        """REFE: reference output: deformation.

        output   output number
        element  element number
        mode     mode number
        """
        self.statement("REFE", 3, output, element, mode)

    def refep(self, output: int, element: int, mode: int) -> None:
        """REFEP: reference output: first time derivative of a deformation.

        output   output number
        element  element number
        mode     mode number
        """
        self.statement("REFEP", 3, output, element, mode)

    def refedp(self, output: int, element: int, mode: int) -> None:
        """REFEDP: reference output: second time derivative of a deformation.

        output   output number
        element  element number
        mode     mode number
        """
        self.statement("REFEDP", 3, output, element, mode)

    def refx(self, output: int, node: int, coordinate: int) -> None:
        """REFX: reference output: coordinate.

        output      output number
        node        node number
        coordinate  coordinate number
        """
        self.statement("REFX", 3, output, node, coordinate)

    def refxp(self, output: int, node: int, coordinate: int) -> None:
        """REFXP: reference output: first time derivative of a coordinate.

        output      output number
        node        node number
        coordinate  coordinate number
        """
        self.statement("REFXP", 3, output, node, coordinate)

    def refxdp(self, output: int, node: int, coordinate: int) -> None:
        """REFXDP: reference output: second time derivative of a coordinate.

        output      output number
        node        node number
        coordinate  coordinate number
        """
        self.statement("REFXDP", 3, output, node, coordinate)

    def refes(self, output: int, element: int, mode: int) -> None:
        """REFES: reference output: deformation, with second order expression.

        output   output number
        element  element number
        mode     mode number
        """
        self.statement("REFES", 3, output, element, mode)

    def refxs(self, output: int, node: int, coordinate: int) -> None:
        """REFXS: reference output: coordinate, with second order expression.

        output      output number
        node        node number
        coordinate  coordinate number
        """
        self.statement("REFXS", 3, output, node, coordinate)

    def inputs(self, input: int, element: int, mode: int) -> None:
        """INPUTS: input: stress of a deformation.

        input    input number
        element  element number
        mode     mode number

        Only for a dynamic or kinematic or calculable coordinate or deformation.
        """
        self.statement("INPUTS", 3, input, element, mode)

    def inputf(self, input: int, node: int, coordinate: int) -> None:
        """INPUTF: input: force on a coordinate.

        input       input number
        node        node number
        coordinate  coordinate number

        Only for a dynamic or kinematic or calculable coordinate or deformation.
        """
        self.statement("INPUTF", 3, input, node, coordinate)

    def ine(self, input: int, element: int, mode: int) -> None:
        """INE: input: prescribed deformation.

        input    input number
        element  element number
        mode     mode number

        Only for a prescribed coordinate or deformation.
        """
        self.statement("INE", 3, input, element, mode)

    def inep(self, input: int, element: int, mode: int) -> None:
        """INEP: input: first time derivative of a prescribed deformation.

        input    input number
        element  element number
        mode     mode number

        Only for a prescribed coordinate or deformation.
        """
        self.statement("INEP", 3, input, element, mode)

    def inedp(self, input: int, element: int, mode: int) -> None:
        """INEDP: input: second time derivative of a prescribed deformation.

        input    input number
        element  element number
        mode     mode number

        Only for a prescribed coordinate or deformation.
        """
        self.statement("INEDP", 3, input, element, mode)

    def inx(self, input: int, node: int, coordinate: int) -> None:
        """INX: input: prescribed coordinate.

        input       input number
        node        node number
        coordinate  coordinate number

        Only for a prescribed coordinate or deformation.
        """
        self.statement("INX", 3, input, node, coordinate)

    def inxp(self, input: int, node: int, coordinate: int) -> None:
        """INXP: input: first time derivative of a prescribed coordinate.

        input       input number
        node        node number
        coordinate  coordinate number

        Only for a prescribed coordinate or deformation.
        """
        self.statement("INXP", 3, input, node, coordinate)

    def inxdp(self, input: int, node: int, coordinate: int) -> None:
        """INXDP: input: second time derivative of a prescribed coordinate.

        input       input number
        node        node number
        coordinate  coordinate number

        Only for a prescribed coordinate or deformation.
        """
        self.statement("INXDP", 3, input, node, coordinate)

    def outs(self, output: int, element: int, mode: int) -> None:
        """OUTS: output: stress of a deformation.

        output   output number
        element  element number
        mode     mode number
        """
        self.statement("OUTS", 3, output, element, mode)

    def oute(self, output: int, element: int, mode: int) -> None:
        """OUTE: output: deformation.

        output   output number
        element  element number
        mode     mode number

        Only for a dynamic or kinematic or calculable or prescribed coordinate or deformation.
        """
        self.statement("OUTE", 3, output, element, mode)

    def outep(self, output: int, element: int, mode: int) -> None:
        """OUTEP: output: first time derivative of a deformation.

        output   output number
        element  element number
        mode     mode number

        Only for a dynamic or kinematic or calculable or prescribed coordinate or deformation.
        """
        self.statement("OUTEP", 3, output, element, mode)

    def outedp(self, output: int, element: int, mode: int) -> None:
        """OUTEDP: output: second time derivative of a deformation.

        output   output number
        element  element number
        mode     mode number

        Only for a dynamic or kinematic or calculable or prescribed coordinate or deformation.
        """
        self.statement("OUTEDP", 3, output, element, mode)

    def outf(self, output: int, node: int, coordinate: int) -> None:
        """OUTF: output: reaction force of a coordinate.

        output      output number
        node        node number
        coordinate  coordinate number

        Only for a fixed or prescribed coordinate or deformation.
        """
        self.statement("OUTF", 3, output, node, coordinate)

    def outx(self, output: int, node: int, coordinate: int) -> None:
        """OUTX: output: coordinate.

        output      output number
        node        node number
        coordinate  coordinate number

        Only for a dynamic or kinematic or calculable or prescribed coordinate or deformation.
        """
        self.statement("OUTX", 3, output, node, coordinate)

    def outxp(self, output: int, node: int, coordinate: int) -> None:
        """OUTXP: output: first time derivative of a coordinate.

        output      output number
        node        node number
        coordinate  coordinate number

        Only for a dynamic or kinematic or calculable or prescribed coordinate or deformation.
        """
        self.statement("OUTXP", 3, output, node, coordinate)

    def outxdp(self, output: int, node: int, coordinate: int) -> None:
        """OUTXDP: output: second time derivative of a coordinate.

        output      output number
        node        node number
        coordinate  coordinate number

        Only for a dynamic or kinematic or calculable or prescribed coordinate or deformation.
        """
        self.statement("OUTXDP", 3, output, node, coordinate)
