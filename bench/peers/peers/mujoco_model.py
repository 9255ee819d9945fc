"""A job as a MuJoCo model.

The tetrahedra are one 3D flex, each of whose vertices is a point mass on three slides. The bones are
a kinematic tree of hinges. The palm's six freedoms are slides with position servos and a ball with
a spring, which is the drive. There are two ways of tying a vertex to a free bone:

`slides`   the vertex hangs in the bone's frame; its slides' springs and dampers are the tie;
`connect`  the vertex stands in the world; a soft point-to-point constraint is the tie.
"""

import numpy as np

from . import rigid


def numbers(values):
    return " ".join(f"{x:.17g}" for x in np.ravel(values))


def wxyz(q):
    return np.array([q[3], q[0], q[1], q[2]])


def split(row):
    return np.array(row[:3]), np.array(row[3:])


class Writer:
    """Writes the MJCF of a job."""

    def __init__(self, job, settings):
        self.job = job
        self.settings = settings
        self.lines = []
        self.tie_of = {tie["node"]: tie for tie in job["ties"]}
        self.hang_on_bones = not job["kinematic"] and self.ties() == "slides"

    def ties(self):
        return self.settings.get("ties", "connect")

    def xml(self):
        job, settings = self.job, self.settings
        option = {
            "timestep": job["time_step"],
            "gravity": numbers(job["gravity"]),
            "integrator": "discrete",
            "solver": settings.get("solver", "Newton"),
            "iterations": int(settings.get("iterations", 100)),
            "tolerance": settings.get("tolerance", 1e-8),
            "cone": "elliptic",
            "impratio": settings.get("impratio", 1.0),
            "jacobian": "sparse",
        }
        attributes = " ".join(f'{key}="{value}"' for key, value in option.items())
        self.say("<mujoco>")
        self.say('<compiler angle="radian" inertiafromgeom="false" autolimits="true"/>')
        self.say(f"<option {attributes}/>")
        self.say('<size memory="200M"/>')
        self.say("<worldbody>")
        if job["table"]:
            height = job["table"]["height"]
            # Axes of a plane: z is the normal, here the world's y.
            self.say(
                f'<geom name="table" type="plane" size="1 1 .01" pos="0 {height:.17g} 0" '
                f'zaxis="0 1 0" {self.contact()}/>'
            )
        for node, position in enumerate(job["nodes"]):
            if not (self.hang_on_bones and node in self.tie_of):
                self.vertex(node, position)
        if job["bones"] and not job["kinematic"]:
            self.bone(0, None)
        self.say("</worldbody>")
        self.flex()
        if job["ties"] and not job["kinematic"] and not self.hang_on_bones:
            self.connections()
        if job["drive"]:
            self.servos()
        self.say("</mujoco>")
        return "\n".join(self.lines)

    def say(self, line):
        self.lines.append(line)

    def contact(self):
        friction = self.job["table"]["friction"] if self.job["table"] else 1.0
        solref = numbers(self.settings.get("solref", [1e-4, 1.0]))
        solimp = numbers(self.settings.get("solimp", [0.99, 0.9999, 1e-4, 0.5, 2]))
        return (
            f'friction="{friction:.17g} 0 0" condim="3" priority="1" '
            f'solref="{solref}" solimp="{solimp}" '
            f'margin="{self.settings.get("margin", 0.0)}" gap="{self.settings.get("gap", 0.0)}"'
        )

    def vertex(self, node, position):
        """A point mass; held nodes have no slides."""
        job = self.job
        mass = job["node_masses"][node]
        self.say(f'<body name="v{node}" pos="{numbers(position)}">')
        small = mass * 1e-10  # a point: its inertia plays no part, but must be positive
        self.say(f'<inertial pos="0 0 0" mass="{mass:.17g}" diaginertia="{numbers([small] * 3)}"/>')
        if node not in job["fixed"]:
            sprung = node in self.tie_of and (self.hang_on_bones or job["kinematic"])
            stiffness = self.tie_of[node]["stiffness"] if sprung else 0.0
            for axis in ("1 0 0", "0 1 0", "0 0 1"):
                self.say(f'<joint type="slide" axis="{axis}" stiffness="{stiffness:.17g}"/>')
        self.say("</body>")

    def bone(self, index, parent):
        job = self.job
        bone = job["bones"][index]
        position, rotation = split(bone["pose"])
        place = (position, rotation)
        if parent is not None:
            place = rigid.compose(rigid.inverse(split(job["bones"][parent]["pose"])), place)
        self.say(
            f'<body name="b{index}" pos="{numbers(place[0])}" quat="{numbers(wxyz(place[1]))}">'
        )
        m = np.array(bone["inertia"])
        full = [m[0, 0], m[1, 1], m[2, 2], m[0, 1], m[0, 2], m[1, 2]]
        self.say(
            f'<inertial pos="0 0 0" mass="{bone["mass"]:.17g}" fullinertia="{numbers(full)}"/>'
        )
        if parent is None:
            self.root(rotation)
        for joint in job["joints"]:
            if joint["child"] == index:
                self.hinges(joint, place)
        for node, tie in self.tie_of.items():
            if tie["bone"] == index and self.hang_on_bones:
                local = rigid.rotate(rigid.conjugate(rotation), job["nodes"][node] - position)
                self.vertex(node, local)
        for joint in job["joints"]:
            if joint["parent"] == index:
                self.bone(joint["child"], index)
        self.say("</body>")

    def root(self, rotation):
        drive = self.job["drive"]
        for k, name in enumerate("xyz"):
            axis = rigid.rotate(rigid.conjugate(rotation), np.eye(3)[k])
            self.say(f'<joint name="root-{name}" type="slide" axis="{numbers(axis)}"/>')
        self.say(
            f'<joint name="root-ball" type="ball" stiffness="{drive["angular_stiffness"]:.17g}" '
            f'damping="{drive["angular_damping"]:.17g}"/>'
        )

    def hinges(self, joint, place):
        """Ry(q0) of the parent's frame, then Rx(q1) of the child's; a hinge has the latter only."""
        at, child_frame = split(joint["pose_in_child"])
        _, parent_frame = split(joint["pose_in_parent"])
        x = rigid.rotate(child_frame, [1, 0, 0])
        y = rigid.rotate(rigid.conjugate(place[1]), rigid.rotate(parent_frame, [0, 1, 0]))
        axes = [x] if joint["kind"] == "hinge" else [y, x]
        # Every spring is relaxed in the pose in which the hand was built, which is qpos0.
        for axis, values in zip(axes, joint["axes"]):
            self.say(
                f'<joint type="hinge" pos="{numbers(at)}" axis="{numbers(axis)}" '
                f'stiffness="{values["stiffness"]:.17g}" damping="{values["damping"]:.17g}"/>'
            )

    def flex(self):
        job = self.job
        bodies = " ".join(f"v{node}" for node in range(len(job["nodes"])))
        elements = " ".join(str(i) for tet in job["tets"] for i in tet)
        self.say("<deformable>")
        self.say(f'<flex name="flesh" dim="3" radius="0" body="{bodies}" element="{elements}">')
        self.say(
            f'<elasticity young="{job["young"]:.17g}" poisson="{job["poisson"]:.17g}" '
            f'damping="{job["stiffness_damping"]:.17g}"/>'
        )
        if job["table"]:
            self.say(f'<contact selfcollide="none" {self.contact()}/>')
        else:
            self.say('<contact selfcollide="none" contype="0" conaffinity="0"/>')
        self.say("</flex>")
        self.say("</deformable>")

    def connections(self):
        """Their compliance needs the compiled masses and is set by the engine."""
        self.say("<equality>")
        for node, tie in self.tie_of.items():
            self.say(f'<connect body1="v{node}" body2="b{tie["bone"]}" anchor="0 0 0"/>')
        self.say("</equality>")

    def servos(self):
        drive = self.job["drive"]
        self.say("<actuator>")
        for name in "xyz":
            self.say(
                f'<position joint="root-{name}" kp="{drive["stiffness"]:.17g}" '
                f'kv="{drive["damping"]:.17g}"/>'
            )
        self.say("</actuator>")
