"""The cases: which job at which step, and what is measured of it."""

from dataclasses import dataclass

import numpy as np

from . import jobs, measure, mujoco_bar
from .engines import Engine, engines

STEPS = (1e-3, 5e-3, 1.0 / 60.0)
REFERENCE_STEP = 2.5e-4
FRAME_INTERVAL = 0.1  # s; all steps divide it
# A bar of 240 linear tetrahedra sinks by this, computed independently; refined, 1.0175 mm.
BAR_LINEAR, BAR_REFINED = 0.522496, 1.0175


@dataclass
class Case:
    name: str
    title: str
    make: callable
    seconds: float


CASES = [
    Case("flesh", "(a) flesh on kinematic bones, flexed 10° once a second", jobs.flesh_only, 1.0),
    Case("two-way", "(b) 16 free bones with flesh, palm led 1 Hz", jobs.two_way, 1.0),
    Case("press", "(c) pressed on a table and dragged", jobs.press, jobs.PRESS_DRAGGED),
]


def frames_every(step):
    return max(1, round(FRAME_INTERVAL / step))


def reference(case, hand):
    """The same mesh at a small step and a tight tolerance; and MuJoCo there, to check it."""
    job = case.make(hand, REFERENCE_STEP, case.seconds)
    every = frames_every(REFERENCE_STEP)
    monolithic = {"solver": "monolithic", "velocity_tolerance": 1e-8}
    ours = Engine("reference", "thenar", monolithic).run(job, every, case.name)
    mujoco = next(e for e in engines(REFERENCE_STEP) if e.kind == "mujoco")
    check = mujoco.run(job, every, f"{case.name}-check")
    notes = measure.stretch(job, ours)
    if not check.get("failure"):
        notes["mujoco_rms"] = measure.against(check, ours)["nodes_rms"]
    if job["table"]:
        notes.update(measure.contact(job, ours, hand))
    return ours, notes


def run(case, hand, step, repeats, settled):
    """All engines at one step, in turn, so that the machine's moods are shared."""
    job = case.make(hand, step, case.seconds)
    chosen = [engine for engine in engines(step) if case.name in engine.cases]
    outcomes = {engine.name: [] for engine in chosen}
    for _ in range(repeats):
        for engine in chosen:
            found = outcomes[engine.name]
            if not (found and found[0]["failure"]):
                found.append(engine.run(job, frames_every(step), case.name))
    rows = []
    for engine in chosen:
        row = {"engine": engine.name, "settings": engine.settings, "step": step}
        first = outcomes[engine.name][0]
        row["failure"] = first["failure"]
        if first.get("step_ms"):
            row.update(measure.step_times(outcomes[engine.name]))
        if not first["failure"]:
            row.update(measure.against(first, settled))
            row.update(measure.stretch(job, first))
            row.update(measure.joint_gap(job, first))
            if job["table"]:
                row.update(measure.contact(job, first, hand))
        rows.append(row)
    return rows


def bar(repeats):
    """(d) The cantilever, whose answer is known from elsewhere."""
    step = 5e-3
    job = jobs.cantilever(step, 2.0)
    rows = []
    for engine in engines(step):
        if "bar" in engine.cases:
            outcomes = [engine.run(job, label="bar") for _ in range(repeats)]
            row = {"engine": engine.name, "step": step, "failure": outcomes[0]["failure"]}
            if not row["failure"]:
                row.update(measure.step_times(outcomes))
                row["deflection"] = measure.end_deflection(job, outcomes[0])
                row["linear_error"] = row["deflection"] / BAR_LINEAR - 1.0
            rows.append(row)
    # What only MuJoCo has: interpolation by other elements, fewer and better than tetrahedra.
    for dof, cells in (("trilinear", (10, 2, 2)), ("quadratic", (5, 1, 1))):
        runs = [mujoco_bar.run(dof, cells, step, 2.0) for _ in range(repeats)]
        row = {"engine": f"MuJoCo, {dof}, {cells[0]} x {cells[1]} x {cells[2]} cells"}
        row.update(step=step, failure=None, deflection=runs[0]["deflection"])
        rows.append({**row, **measure.step_times(runs)})
    for row in rows:
        if not row["failure"]:
            row["refined_error"] = row["deflection"] / BAR_REFINED - 1.0
    return rows


FACTORS = (1.0, 1e2, 1e4, 1e6)
STABILITY_STEPS = (1e-3, 5e-3, 1.0 / 60.0, 1.0 / 30.0)


def stability(hand, seconds=0.3):
    """At each step the largest coupling, as a multiple of the shipped one, at which all holds."""
    rows = []
    for step in STABILITY_STEPS:
        for engine in engines(step):
            if "two-way" not in engine.cases or engine.name == "Rapier glued":
                continue  # glue has no stiffness to vary
            if engine.kind == "mujoco":
                # The way of tying that bears stiff ties better, at every step.
                engine.settings["ties"] = "slides"
            held = []
            for factor in FACTORS:
                job = jobs.sag(hand, step, seconds, factor)
                outcome = engine.run(job, label="stability")
                if not calm(job, outcome):
                    break
                held.append(factor)
            rows.append({"engine": engine.name, "step": step, "held": held[-1] if held else 0.0})
    return rows


def calm(job, outcome):
    """No failure, no growth of energy, and flesh that is still about its bones."""
    if outcome.get("failure") or not outcome.get("frames"):
        return False
    kinetic = np.array(outcome["kinetic"])
    fifth = max(1, len(kinetic) // 5)
    growing = kinetic[-fifth:].max() > kinetic[:-fifth].max()
    return not growing and measure.stretch(job, outcome)["stretch_max"] < 20.0
