"""Runs a job in MuJoCo: `python -m peers.mujoco_engine JOB.json OUTCOME.json`."""

import json
import sys
import time

import mujoco
import numpy as np

from . import rigid
from .mujoco_model import Writer, split


class Run:
    def __init__(self, job):
        self.job = job
        self.settings = job["settings"]
        self.model = mujoco.MjModel.from_xml_string(Writer(job, self.settings).xml())
        self.data = mujoco.MjData(self.model)
        count = len(job["nodes"])
        self.vertex_bodies = [self.model.body(f"v{node}").id for node in range(count)]
        self.masses = np.array(job["node_masses"])
        self.dampers()
        self.soften_connections()
        self.steady_forces()
        if job["kinematic"] and job["ties"]:
            self.prepare_moving_springs()

    def dampers(self):
        """The compiler refuses dampers on a flex's vertices; the solver takes them."""
        job = self.job
        damping = job["mass_damping"] * self.masses
        for tie in job["ties"] if self.model.neq == 0 else []:
            damping[tie["node"]] += job["tie_damping_time"] * tie["stiffness"]
        for body, value in zip(self.vertex_bodies, damping):
            first = self.model.body_dofadr[body]
            self.model.dof_damping[first : first + self.model.body_dofnum[body]] = value

    def soften_connections(self):
        """Makes each connection the tie's spring and damper.

        A row's force is (-b v - d k r - a) / R with R = (1 - d) / d * A, A its inverse mass; a
        small impedance d keeps the term of a, a mass that the tie does not have, small.
        """
        impedance = self.settings.get("impedance", 1e-3)
        model = self.model
        for row, tie in enumerate(self.job["ties"] if model.neq else []):
            bodies = [model.eq_obj1id[row], model.eq_obj2id[row]]
            inverse_mass = model.body_invweight0[bodies, 0].sum()
            yielding = (1.0 - impedance) / impedance * inverse_mass
            stiffness = tie["stiffness"] * yielding * impedance
            damping = self.job["tie_damping_time"] * tie["stiffness"] * yielding * impedance
            model.eq_solref[row] = [-stiffness, -damping]
            model.eq_solimp[row] = [impedance, impedance, 1.0, 0.5, 1.0]

    def steady_forces(self):
        for node, force in enumerate(self.job["node_forces"]):
            if np.any(force):
                self.data.xfrc_applied[self.vertex_bodies[node], :3] = force

    def prepare_moving_springs(self):
        """With kinematic bones the ties' springs rest where the bones take them."""
        self.tied = np.array([tie["node"] for tie in self.job["ties"]])
        self.tied_bone = np.array([tie["bone"] for tie in self.job["ties"]])
        stiffness = np.array([tie["stiffness"] for tie in self.job["ties"]])
        self.tie_damping = (self.job["tie_damping_time"] * stiffness)[:, None]
        first = [self.model.body(f"v{node}").jntadr[0] for node in self.tied]
        self.tied_dofs = self.model.jnt_dofadr[first][:, None] + np.arange(3)
        self.rest = np.array(self.job["nodes"])[self.tied]
        self.local = np.zeros_like(self.rest)
        for k, bone in enumerate(self.job["bones"]):
            position, rotation = split(bone["pose"])
            mine = self.tied_bone == k
            self.local[mine] = rigid.rotate(rigid.conjugate(rotation), self.rest[mine] - position)
        self.before = self.rest.copy()

    def lead(self, i):
        job = self.job
        if not job["targets"]:
            return
        if not job["kinematic"]:
            drive = job["drive"]
            after = np.array(job["targets"][i][0][:3])
            before = np.array((job["targets"][i - 1][0] if i else job["bones"][0]["pose"])[:3])
            velocity = (after - before) / job["time_step"]
            # kp (ctrl - q) - kv v = k (target - q) + c (target velocity - v)
            ahead = velocity * drive["damping"] / drive["stiffness"]
            self.data.ctrl[:3] = after + ahead - np.array(job["bones"][0]["pose"][:3])
            return
        anchors = np.empty_like(self.rest)
        for k, row in enumerate(job["targets"][i]):
            position, rotation = split(row)
            mine = self.tied_bone == k
            anchors[mine] = rigid.rotate(rotation, self.local[mine]) + position
        velocity = (anchors - self.before) / job["time_step"]
        self.before = anchors
        # Slides count from the rest position, so a spring's rest is the anchor's displacement.
        self.model.qpos_spring[self.tied_dofs] = anchors - self.rest
        self.data.qfrc_applied[self.tied_dofs] = self.tie_damping * velocity

    def table_force(self):
        force = np.zeros(3)
        wrench = np.zeros(6)
        for i, contact in enumerate(self.data.contact[: self.data.ncon]):
            mujoco.mj_contactForce(self.model, self.data, i, wrench)
            # The frame's rows are the normal, from the first to the second, and two tangents.
            on_second = contact.frame.reshape(3, 3).T @ wrench[:3]
            table_is_first = contact.geom[0] >= 0
            force += -on_second if table_is_first else on_second
        return force

    def frame(self, step):
        data = self.data
        bones = []
        if self.job["kinematic"]:
            bones = self.job["targets"][step - 1] if self.job["targets"] else []
        else:
            for k in range(len(self.job["bones"])):
                body = data.body(f"b{k}")
                w, x, y, z = body.xquat
                bones.append([*body.xpos, x, y, z, w])
        return {
            "step": step,
            "nodes": data.xpos[self.vertex_bodies].tolist(),
            "bones": [[float(x) for x in row] for row in bones],
        }

    def kinetic(self, before):
        velocity = (self.data.xpos[self.vertex_bodies] - before) / self.job["time_step"]
        return float(0.5 * np.sum(self.masses * np.sum(velocity**2, axis=1)))

    def outcome(self):
        job, model, data = self.job, self.model, self.data
        done = {key: [] for key in ("step_ms", "table_force", "contacts", "kinetic", "frames")}
        done.update(engine="mujoco", failure=None)
        mujoco.mj_kinematics(model, data)
        limit = 0.5 * self.masses.sum() * 400.0
        for i in range(job["steps"]):
            self.lead(i)
            before = data.xpos[self.vertex_bodies].copy()
            start = time.thread_time()
            mujoco.mj_step(model, data)
            done["step_ms"].append((time.thread_time() - start) * 1e3)
            done["table_force"].append(self.table_force().tolist())
            done["contacts"].append(int(data.ncon))
            mujoco.mj_kinematics(model, data)
            done["kinetic"].append(self.kinetic(before))
            if (i + 1) % job["record_every"] == 0 or i + 1 == job["steps"]:
                done["frames"].append(self.frame(i + 1))
            warned = data.warning[mujoco.mjtWarning.mjWARN_BADQACC].number
            if warned or not np.isfinite(done["kinetic"][-1]) or done["kinetic"][-1] > limit:
                done["failure"] = f"diverged at step {i + 1}"
                break
        return done


def main(job_path, outcome_path):
    with open(job_path, encoding="utf-8") as file:
        job = json.load(file)
    outcome = Run(job).outcome()
    with open(outcome_path, "w", encoding="utf-8") as file:
        json.dump(outcome, file)


if __name__ == "__main__":
    main(*sys.argv[1:])
