"""The same deck in Exudyn: PART, BUSHING, SPRINGDAMPER, SFORCE (ACTIONONLY) and the joints of the two axles."""

import time

import exudyn as exu
import numpy as np
from exudyn.itemInterface import (
    LoadForceVector,
    LoadMassProportional,
    MarkerBodyMass,
    MarkerBodyPosition,
    MarkerBodyRigid,
    NodeRigidBodyEP,
    NodeRigidBodyRxyz,
    ObjectConnectorRigidBodySpringDamper,
    ObjectConnectorSpringDamper,
    ObjectGround,
    ObjectJointGeneric,
    ObjectJointSpherical,
    ObjectRigidBody,
)
from exudyn.rigidBodyUtilities import RotationMatrix2EulerParameters, RotationMatrix2RotXYZ, RotXYZ2RotationMatrix

import deck as decks


def adams_bushing(mbs, t, item, displacement, rotation, velocity, angular_velocity, stiffness, damping, R0, R1, offset):
    """The BUSHING law: projected angles AX AY AZ instead of Cardan angles."""
    return np.diag(np.array(stiffness)) * deflection(displacement, rotation)


def deflection(displacement, rotation):
    """Six components of a bushing: displacements and projected angles."""
    a = RotXYZ2RotationMatrix(rotation)
    angles = [np.arctan2(-a[1, 2], a[2, 2]), np.arctan2(a[0, 2], a[2, 2]), np.arctan2(a[1, 0], a[0, 0])]
    return np.concatenate([displacement, angles])


def with_more(more):
    """The BUSHING law and a force on single components besides: `more` by component, each a function of the displacement."""

    def law(mbs, t, item, displacement, rotation, velocity, angular_velocity, stiffness, damping, R0, R1, offset):
        u = deflection(displacement, rotation)
        force = np.diag(np.array(stiffness)) * u
        for axis, function in more.items():
            force[axis] += function(u[axis])
        return force

    return law


class Model:
    """A deck built in Exudyn.

    `adams_law` puts the BUSHING law into Exudyn's connector by a Python function. Without it the connector has its own law, which
    takes Cardan angles, and on J leaves out the torque -delta x F; with J on ground that torque meets nothing.

    Parts have Euler parameters where there are joints: the derivatives of joint reactions are not part of Exudyn's Jacobian, and
    with Cardan angles or rotation vectors its Newton iteration leaves the equilibria of the pseudo McPherson. Without joints
    parts have Cardan angles, the fewest unknowns. `more` gives bushings, by id, forces besides.
    """

    def __init__(self, path, adams_law=False, more=None):
        begin = time.perf_counter()
        deck = decks.read(path)
        self.system = exu.SystemContainer()
        self.mbs = mbs = self.system.AddSystem()
        ground = mbs.AddObject(ObjectGround())
        self.bodies, self.deck = {}, deck
        # Newton, kilogram, millimetre, second: a weight is m g / 1000.
        gravity = [deck["ACCGRAV"][0].number(g) / 1000 for g in ("IGRAV", "JGRAV", "KGRAV")] if "ACCGRAV" in deck else None
        for part in deck["PART"].values():
            if "GROUND" in part:
                self.bodies[part.id] = ground
                continue
            R = np.array(decks.rotation(*part.numbers("REULER", 3)))
            place = part.numbers("QG", 3)
            if "JOINT" in deck:
                node = NodeRigidBodyEP(referenceCoordinates=place + list(RotationMatrix2EulerParameters(R)))
            else:
                node = NodeRigidBodyRxyz(referenceCoordinates=place + list(RotationMatrix2RotXYZ(R)))
            node = mbs.AddNode(node)
            mass, cm = part.number("MASS"), deck["MARKER"][int(part["CM"][0])].numbers("QP", 3)
            ip = np.diag(part.numbers("IP", 3))
            c = np.array(cm)
            about_origin = ip + mass * (c @ c * np.eye(3) - np.outer(c, c))
            inertia = [about_origin[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))]
            body = mbs.AddObject(ObjectRigidBody(mass=mass, inertia=inertia, centerOfMass=cm, nodeNumber=node))
            self.bodies[part.id] = body
            if gravity:
                marker = mbs.AddMarker(MarkerBodyMass(bodyNumber=body))
                mbs.AddLoad(LoadMassProportional(markerNumber=marker, loadVector=gravity))
        for bushing in deck.get("BUSHING", {}).values():
            stiffness = bushing.numbers("K", 3)
            equal = len(set(stiffness)) == 1 or sum(k != 0 for k in stiffness) == 1
            assert not adams_law or equal or self.part(bushing, "J") == ground, "the laws differ by -delta x F on J"
            own = (more or {}).get(bushing.id)
            law = with_more(own) if own else adams_bushing if adams_law else 0
            mbs.AddObject(
                ObjectConnectorRigidBodySpringDamper(
                    markerNumbers=[self.rigid(bushing, "J"), self.rigid(bushing, "I")],
                    stiffness=np.diag(bushing.numbers("K", 3) + bushing.numbers("KT", 3)),
                    springForceTorqueUserFunction=law,
                )
            )
        for spring in deck.get("SPRINGDAMPER", {}).values():
            assert "TRANSLATION" in spring
            mbs.AddObject(
                ObjectConnectorSpringDamper(
                    markerNumbers=[self.point(spring, "J"), self.point(spring, "I")],
                    referenceLength=spring.number("LENGTH"),
                    stiffness=spring.number("K"),
                    force=-spring.number("FORCE"),
                )
            )
        for joint in deck.get("JOINT", {}).values():
            self.joint(joint)
        self.loads = {}
        for force in deck.get("SFORCE", {}).values():
            assert "ACTIONONLY" in force
            marker = deck["MARKER"][int(force["J"][0])]
            direction = np.array(decks.rotation(*marker.numbers("REULER", 3)))[:, 2]
            load = mbs.AddLoad(LoadForceVector(markerNumber=self.point(force, "I"), loadVector=list(direction * force.number("FUNCTION"))))
            self.loads[f"SFORCE/{force.id}"] = (load, direction)
        mbs.Assemble()
        self.settings = exu.SimulationSettings()
        self.settings.solutionSettings.writeSolutionToFile = False
        self.settings.solutionSettings.solutionInformation = ""
        self.settings.staticSolver.verboseMode = 0
        self.settings.displayStatistics = False
        self.settings.linearSolverType = exu.LinearSolverType.EigenSparse
        self.settings.staticSolver.adaptiveStep = False
        newton = self.settings.staticSolver.newton
        newton.useModifiedNewton = False
        newton.relativeTolerance = 1e-14
        self.setup_s = time.perf_counter() - begin

    def part(self, statement, which):
        return self.bodies[int(self.deck["MARKER"][int(statement[which][0])]["PART"][0])]

    def axes(self, statement, which):
        return np.array(decks.rotation(*self.deck["MARKER"][int(statement[which][0])].numbers("REULER", 3)))

    def rigid(self, statement, which, order=(0, 1, 2)):
        """A marker with its axes, in another order if wanted."""
        marker = self.deck["MARKER"][int(statement[which][0])]
        frame = exu.HT(rotation=self.axes(statement, which)[:, order], translation=marker.numbers("QP", 3))
        return self.mbs.AddMarker(MarkerBodyRigid(bodyNumber=self.part(statement, which), localHT=frame))

    def point(self, statement, which):
        marker = self.deck["MARKER"][int(statement[which][0])]
        place = marker.numbers("QP", 3)
        return self.mbs.AddMarker(MarkerBodyPosition(bodyNumber=self.part(statement, which), localPosition=place))

    def joint(self, joint):
        kinds = {
            "SPHERICAL": None,
            "CYLINDRICAL": [1, 1, 0, 1, 1, 0],
            "REVOLUTE": [1, 1, 1, 1, 1, 0],
            "TRANSLATIONAL": [1, 1, 0, 1, 1, 1],
            "FIXED": [1, 1, 1, 1, 1, 1],
            "UNIVERSAL": [1, 1, 1, 0, 0, 1],
        }
        kind = next(kind for kind in kinds if kind in joint)
        if kind == "SPHERICAL":
            markers = [self.point(joint, "J"), self.point(joint, "I")]
            self.mbs.AddObject(ObjectJointSpherical(markerNumbers=markers))
            return
        axes, order_j, order_i = kinds[kind], (0, 1, 2), (0, 1, 2)
        if kind == "UNIVERSAL":
            # zi.zj = 0 alone: Exudyn's third rotation constraint is x0.y1 = 0, so z_j becomes x0 and z_i becomes y1.
            order_j, order_i = (2, 0, 1), (1, 2, 0)
        markers = [self.rigid(joint, "J", order_j), self.rigid(joint, "I", order_i)]
        self.mbs.AddObject(ObjectJointGeneric(markerNumbers=markers, constrainedAxes=axes))

    def sweep(self, loads, cases, absolute_tolerance, keep=False, after=None):
        """Seconds in the solver, Newton iterations and part poses per case; starts at the design position. `after` is told the poses of
        each case."""
        mbs = self.mbs
        self.settings.staticSolver.newton.absoluteTolerance = absolute_tolerance
        mbs.systemData.SetSystemState(self.design(), exu.ConfigurationType.Initial)
        seconds, iterations, parts = 0.0, [], []
        for case in cases:
            for name, value in zip(loads, case):
                load, direction = self.loads[name]
                mbs.SetLoadParameter(load, "loadVector", list(direction * value))
            begin = time.perf_counter()
            mbs.SolveStatic(self.settings, updateInitialValues=True)
            seconds += time.perf_counter() - begin
            iterations.append(mbs.sys["staticSolver"].it.newtonStepsCount)
            if keep:
                parts.append(self.poses())
            if after:
                after(self.poses())
        return seconds, iterations, parts

    def design(self):
        if not hasattr(self, "start"):
            self.start = self.mbs.systemData.GetSystemState(exu.ConfigurationType.Initial)
        return self.start

    def poses(self):
        """Position and rotation matrix, row by row, of every part frame, by the number of the part."""
        found = {}
        for id_, body in self.bodies.items():
            if self.mbs.GetObject(body)["objectType"] == "Ground":
                continue
            place = self.mbs.GetObjectOutputBody(body, exu.OutputVariableType.Position, [0, 0, 0])
            R = self.mbs.GetObjectOutputBody(body, exu.OutputVariableType.RotationMatrix, [0, 0, 0])
            found[str(id_)] = list(place) + list(R)
        return found
