"""The engines, each with the settings that served it best, and how to run them."""

import json
import os
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

HERE = Path(__file__).resolve().parent.parent
WORK = HERE / "work"
BINARIES = HERE / "target" / "release"
# Ten times the usual stiffness, and a surface without the usual skin.
RAPIER_CONTACT = {"contact_stiffening": 40.0, "radius": 2e-4}


@dataclass
class Engine:
    """One column of the table."""

    name: str
    kind: str  # thenar, rapier or mujoco
    settings: dict = field(default_factory=dict)
    cases: tuple = ("flesh", "two-way", "press", "bar")

    def command(self, job, outcome):
        if self.kind == "mujoco":
            return [sys.executable, "-m", "peers.mujoco_engine", job, outcome]
        return [str(BINARIES / self.kind), job, outcome]

    def run(self, job, record_every=None, label="run"):
        """Runs a job in a process of its own and returns the outcome."""
        stem = f"{self.name}-{label}".replace(" ", "-")
        paths = [str(WORK / f"{stem}.{part}.json") for part in ("job", "outcome")]
        whole = dict(job, settings=self.settings, record_every=record_every or job["steps"])
        with open(paths[0], "w", encoding="utf-8") as file:
            json.dump(whole, file)
        environment = dict(os.environ, PYTHONPATH=str(HERE))
        for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "RAYON_NUM_THREADS"):
            environment[threads] = "1"
        done = subprocess.run(
            self.command(*paths),
            cwd=WORK,
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )
        if done.returncode != 0:
            return {"failure": done.stderr.strip()[-300:] or f"exit {done.returncode}"}
        with open(paths[1], encoding="utf-8") as file:
            outcome = json.load(file)
        for path in paths:
            os.remove(path)
        return outcome


def engines(step):
    """What is compared at this time step; the README says how the settings were found."""
    return [
        Engine("Thenar monolithic", "thenar", {"solver": "monolithic"}),
        Engine("Thenar two-step", "thenar", {"solver": "two-step"}),
        Engine("MuJoCo", "mujoco", mujoco_settings(step)),
        Engine("Rapier", "rapier", {"ties": "springs", "dense": 0}, cases=("flesh", "bar")),
        Engine(
            "Rapier springs",
            "rapier",
            {"ties": "motors", "substeps": 4, "pgs": 32, "stabilization": 0},
            cases=("two-way",),
        ),
        Engine(
            "Rapier springs",
            "rapier",
            {"ties": "motors", "substeps": 4, "pgs": 32, **RAPIER_CONTACT},
            cases=("press",),
        ),
        Engine(
            "Rapier glued",
            "rapier",
            {"ties": "glue", "substeps": 1, "pgs": 16, **RAPIER_CONTACT},
            # Its steps are the dearest by far; long runs of them would tell nothing more.
            cases=("two-way", "press") if step > 2e-3 else (),
        ),
    ]


def mujoco_settings(step):
    """Ties and contact that hold best at this step."""
    contact = {
        "impratio": 100.0,
        "margin": 5e-4,
        "solref": [step, 1.0],
        "solimp": [0.99, 0.999, 1e-3, 0.5, 2],
    }
    if step < 2e-3:
        contact.update(solref=[step, 2.0], solimp=[0.95, 0.995, 1e-3, 0.5, 2])
    # At long steps Newton does not converge on soft constraints as stiff as the ties.
    return {"ties": "connect" if step < 0.01 else "slides", **contact}
