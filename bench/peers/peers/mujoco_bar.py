"""The cantilever as MuJoCo's interpolated flexes: few nodes, and no locking where quadratic."""

import time

import mujoco
import numpy as np

from . import measure

SIZE = np.array([0.1, 0.02, 0.02])  # m
MASS, FORCE = 0.04, 0.004  # kg, N
MASS_DAMPING = 40.0  # 1/s, as in jobs.cantilever


def run(dof, cells, step, seconds):
    """Deflection of the end [mm] and the times of the steps [ms]."""
    model, data = build(dof, cells, step)
    nodes = np.array(model.flex_nodebodyid)
    mujoco.mj_forward(model, data)
    rest = data.xpos[nodes].copy()
    moving = model.body_dofnum[nodes] > 0
    end = moving & (rest[:, 0] > rest[moving, 0].max() - 1e-9)
    load(data, nodes[end], rest[end], order=2 if dof == "quadratic" else 1)
    model.dof_damping[:] = MASS_DAMPING * model.body_mass[model.dof_bodyid]
    times = []
    for _ in range(round(seconds / step)):
        start = time.thread_time()
        mujoco.mj_step(model, data)
        times.append((time.thread_time() - start) * 1e3)
    mujoco.mj_kinematics(model, data)
    sunk = rest[end, 1] - data.xpos[nodes[end], 1]
    return {"step_ms": times, "deflection": float(sunk.mean()) * measure.MM}


def build(dof, cells, step):
    """A grid of 10 x 2 x 2 cubes, moved by the nodes of `cells`; those of one end are held."""
    order = 2 if dof == "quadratic" else 1
    held = f"0 0 0 0 {order * cells[1]} {order * cells[2]}"
    xml = f"""<mujoco>
      <option timestep="{step}" gravity="0 0 0" integrator="discrete" tolerance="1e-10"/>
      <worldbody><body name="wall">
        <flexcomp name="bar" type="grid" count="11 3 3" spacing=".01 .01 .01" dim="3" radius="0"
                  mass="{MASS}" dof="{dof}" cellcount="{cells[0]} {cells[1]} {cells[2]}">
          <elasticity young="1e5" poisson="0.3" damping="1e-3"/>
          <contact selfcollide="none" contype="0" conaffinity="0"/>
          <pin gridrange="{held}"/>
        </flexcomp>
      </body></worldbody>
    </mujoco>"""
    model = mujoco.MjModel.from_xml_string(xml)
    return model, mujoco.MjData(model)


def load(data, bodies, places, order):
    """Spreads the force as the interpolation does: by Simpson's rule, or the trapezium's."""
    share = np.ones(len(bodies))
    for axis in (1, 2):
        levels = np.unique(places[:, axis].round(9))
        weights = np.zeros(len(levels))
        rule = np.array([1.0, 4.0, 1.0] if order == 2 else [1.0, 1.0])
        for first in range(0, len(levels) - 1, order):
            weights[first : first + order + 1] += rule
        share *= weights[np.searchsorted(levels, places[:, axis].round(9))]
    data.xfrc_applied[bodies, 1] = -FORCE * share / share.sum()
