"""`python -m peers.from_python HAND.json HAND.thenar`: Thenar and MuJoCo, both called from Python, press the same hand.

Both run in this process in turns, one thread, a call for each step; that call alone is timed, in the thread's processor
time. Of repeats of one step, which do the same work, the quickest counts. Both files are written by
`cargo run --release --bin export -- 600 HAND.json HAND.thenar`.
"""

import argparse
import os
import time
from importlib.metadata import version

for _threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ[_threads] = "1"

import mujoco
import numpy as np
import thenar

from . import jobs, scene
from .engines import mujoco_settings
from .hand import Hand
from .mujoco_engine import Run


class Thenar:
    """One world of Thenar's package."""

    name = f"Thenar {version('thenar')}"

    def __init__(self, job, model):
        self.job = job
        self.world = thenar.Scene.from_text(scene.press(job, model)).world()
        self.hand = self.world.hands[0]
        self.poses = np.array(self.hand.bone_poses)
        self.velocities = np.zeros((len(self.poses), 6))

    def lead(self, i):
        """To the job's target; only the palm has a drive."""
        after = np.array(self.job["targets"][i][0])
        self.velocities[0, :3] = (after[:3] - self.poses[0, :3]) / self.job["time_step"]
        self.poses[0] = after
        self.hand.lead(self.poses, self.velocities)

    def step(self):
        self.world.step()

    def nodes(self):
        return np.array(self.hand.nodes)

    def pressed(self):
        """Force on the hand by the table, upward [N]."""
        return float(np.array(self.hand.vertex_force)[:, 1].sum())


class MuJoCo:
    """One model of MuJoCo's."""

    name = f"MuJoCo {version('mujoco')}"

    def __init__(self, job, _model):
        self.run = Run(dict(job, settings=mujoco_settings(job["time_step"])))
        mujoco.mj_kinematics(self.run.model, self.run.data)

    def lead(self, i):
        self.run.lead(i)

    def step(self):
        mujoco.mj_step(self.run.model, self.run.data)

    def nodes(self):
        mujoco.mj_kinematics(self.run.model, self.run.data)
        return self.run.data.xpos[self.run.vertex_bodies].copy()

    def pressed(self):
        return -float(self.run.table_force()[1])


def press(engine, job):
    """Times of all steps [s]; force of the table, and places of the nodes, when the hand has been held."""
    held = round(jobs.PRESS_HELD / job["time_step"])
    times = []
    for i in range(job["steps"]):
        engine.lead(i)
        start = time.thread_time()
        engine.step()
        times.append(time.thread_time() - start)
        if i + 1 == held:
            seen = (engine.pressed(), engine.nodes())
    return np.array(times), *seen


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("hand")
    parser.add_argument("model")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--steps-ms", type=float, nargs="+", default=[1.0, 5.0, 1000.0 / 60.0])
    options = parser.parse_args()
    hand, model = Hand(options.hand), os.path.abspath(options.model)
    print(f"{len(hand.tets)} tetrahedra, {len(hand.ties)} ties, least of {options.repeats} repeats in turns\n")
    print("| step | engine | steps per core and second | median | p99 | table's force, held | nodes apart, held |")
    print("|---:|---|---:|---:|---:|---:|---:|")
    for step_ms in options.steps_ms:
        # Without weight, which a hand that is led in Thenar has not either.
        job = dict(jobs.press(hand, step_ms * 1e-3), gravity=[0.0, 0.0, 0.0])
        kinds = (Thenar, MuJoCo)
        times, force, nodes = {}, {}, {}
        for _ in range(options.repeats):
            for kind in kinds:
                took, force[kind], nodes[kind] = press(kind(job, model), job)
                times[kind] = np.minimum(times.get(kind, np.inf), took)
        apart = np.linalg.norm(nodes[Thenar] - nodes[MuJoCo], axis=1)
        for kind in kinds:
            took = times[kind]
            row = [f"{step_ms:.3g} ms", kind.name, f"{1.0 / took.mean():.0f}"]
            row += [f"{np.median(took) * 1e3:.2f} ms", f"{np.percentile(took, 99) * 1e3:.2f} ms"]
            row += [f"{force[kind]:.2f} N", f"{np.sqrt(np.mean(apart**2)) * 1e3:.2f} mm rms"]
            print("| " + " | ".join(row) + " |", flush=True)


if __name__ == "__main__":
    main()
