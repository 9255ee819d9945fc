"""The cases, written as jobs: one JSON document that every engine reads.

Poses are [x, y, z, qx, qy, qz, qw]; `targets[step][k]` is the pose at the end of that step, of
every bone when bones are kinematic, of the palm alone when it is driven.
"""

import numpy as np

from . import hand as hands

GRAVITY = [0.0, -9.81, 0.0]
# The coupling of the palm to its tracked pose, as in the shipped scenes.
DRIVE = {"stiffness": 1000.0, "damping": 10.0, "angular_stiffness": 10.0, "angular_damping": 0.1}


def flat(pose):
    return [float(x) for x in (*pose[0], *pose[1])]


def base(hand, step, seconds, kinematic):
    """The hand without motion, contact or weight."""
    steps = max(1, round(seconds / step))
    return {
        "time_step": step,
        "steps": steps,
        "gravity": [0.0, 0.0, 0.0],
        "young": hands.YOUNG,
        "poisson": hands.POISSON,
        "density": hand.density,
        "mass_damping": 0.0,
        "stiffness_damping": hands.STIFFNESS_DAMPING,
        "nodes": hand.nodes.tolist(),
        "tets": hand.tets.tolist(),
        "node_masses": hand.masses().tolist(),
        "boundary": hand.boundary,
        "fixed": [],
        "node_forces": [],
        "ties": [{"node": n, "bone": b, "stiffness": k} for n, b, k in hand.ties],
        "tie_damping_time": hands.COUPLING_DAMPING_TIME,
        "bones": [
            {
                "pose": flat(hand.pose(i)),
                "mass": bone["mass"],
                "inertia": bone["inertia"],
            }
            for i, bone in enumerate(hand.bones)
        ],
        "kinematic": kinematic,
        "joints": [] if kinematic else [joint(j) for j in hand.joints],
        "drive": None if kinematic else DRIVE,
        "targets": [],
        "table": None,
    }


def joint(source):
    return {
        "kind": source["kind"],
        "parent": source["parent"],
        "child": source["child"],
        "pose_in_parent": flat(hands.pose_of(source["pose_in_parent"])),
        "pose_in_child": flat(hands.pose_of(source["pose_in_child"])),
        "axes": [
            {key: axis[key] for key in ("stiffness", "damping", "rest_angle")}
            for axis in source["axes"]
        ],
    }


def flesh_only(hand, step, seconds):
    """(a) Bones are moved: all joints flex by 10 degrees and back, once a second."""
    job = base(hand, step, seconds, kinematic=True)
    for i in range(job["steps"]):
        t = (i + 1) * step
        angle = np.radians(5.0) * (1.0 - np.cos(2.0 * np.pi * t))
        job["targets"].append([flat(pose) for pose in hand.bent(angle)])
    return job


def two_way(hand, step, seconds):
    """(b) All bones free, under their weight; the palm is led up and down by 20 mm, once a second."""
    job = base(hand, step, seconds, kinematic=False)
    job["gravity"] = GRAVITY
    position, rotation = hand.pose(0)
    for i in range(job["steps"]):
        lift = 0.02 * np.sin(2.0 * np.pi * (i + 1) * step)
        job["targets"].append([flat((position + [0.0, lift, 0.0], rotation))])
    return job


def sag(hand, step, seconds, factor):
    """All bones free, the palm held, weight suddenly there, ties stiffer by a factor."""
    job = base(hand, step, seconds, kinematic=False)
    job["gravity"] = GRAVITY
    for tie in job["ties"]:
        tie["stiffness"] *= factor
    job["targets"] = [[flat(hand.pose(0))]] * job["steps"]
    return job


PRESS_DOWN, PRESS_HELD, PRESS_DRAGGED = 0.4, 0.8, 1.2  # s: end of each phase
PRESS_DEPTH, PRESS_DRAG = 0.04, 0.05  # m


def press(hand, step, seconds=PRESS_DRAGGED):
    """(c) The palm is led down onto a table, held, and led sideways until the hand slides."""
    job = base(hand, step, seconds, kinematic=False)
    job["gravity"] = GRAVITY
    touching = np.unique(np.array(hand.boundary))
    job["table"] = {
        "height": float(hand.nodes[touching, 1].min()) - 0.002,
        "friction": hands.FRICTION,
    }
    position, rotation = hand.pose(0)
    for i in range(job["steps"]):
        t = (i + 1) * step
        down = -(PRESS_DEPTH + 0.002) * smooth(t / PRESS_DOWN)
        aside = PRESS_DRAG * min(max((t - PRESS_HELD) / (PRESS_DRAGGED - PRESS_HELD), 0.0), 1.0)
        job["targets"].append([flat((position + [aside, down, 0.0], rotation))])
    return job


def smooth(x):
    x = min(max(x, 0.0), 1.0)
    return x * x * (3.0 - 2.0 * x)


def cantilever(step, seconds, cells=(10, 2, 2)):
    """(d) A bar of 100 x 20 x 20 mm, one end held, 4 mN on the other, at rest after a while."""
    size = np.array([0.1, 0.02, 0.02])
    nodes, tets = kuhn(size, cells)
    density, force = 1000.0, 0.004
    volumes = tet_volumes(nodes, tets)
    masses = np.zeros(len(nodes))
    np.add.at(masses, tets, (density * volumes / 4.0)[:, None])
    faces = hands.boundary(tets)
    forces = np.zeros((len(nodes), 3))
    end = [f for f in faces if all(nodes[i, 0] > size[0] - 1e-9 for i in f)]
    for face in end:
        forces[list(face), 1] -= force / len(end) / 3.0
    # First bending at 3.2 Hz: this damping brings it to rest without overshoot.
    return {
        "time_step": step,
        "steps": max(1, round(seconds / step)),
        "gravity": [0.0, 0.0, 0.0],
        "young": 100e3,
        "poisson": 0.3,
        "density": density,
        "mass_damping": 40.0,
        "stiffness_damping": 1e-3,
        "nodes": nodes.tolist(),
        "tets": tets.tolist(),
        "node_masses": masses.tolist(),
        "boundary": faces,
        "fixed": [int(i) for i in np.flatnonzero(nodes[:, 0] < 1e-9)],
        "node_forces": forces.tolist(),
        "ties": [],
        "tie_damping_time": 0.0,
        "bones": [],
        "kinematic": True,
        "joints": [],
        "drive": None,
        "targets": [],
        "table": None,
    }


def kuhn(size, cells):
    """Each cube split into the six tetrahedra that share its (0,0,0)-(1,1,1) diagonal."""
    nx, ny, nz = cells
    index = np.arange((nx + 1) * (ny + 1) * (nz + 1)).reshape(nx + 1, ny + 1, nz + 1)
    grid = np.stack(np.meshgrid(*(np.arange(n + 1) for n in cells), indexing="ij"), axis=-1)
    nodes = grid.reshape(-1, 3) * (size / np.array(cells))
    tets = []
    paths = [(0, 1, 2), (1, 2, 0), (2, 0, 1), (0, 2, 1), (2, 1, 0), (1, 0, 2)]
    for corner in np.ndindex(nx, ny, nz):
        for path in paths:
            at = list(corner)
            tet = [index[tuple(at)]]
            for axis in path:
                at[axis] += 1
                tet.append(index[tuple(at)])
            tets.append([int(i) for i in tet])
    tets = np.array(tets)
    flipped = tet_volumes(nodes, tets) < 0
    tets[flipped] = tets[flipped][:, [0, 2, 1, 3]]
    return nodes, tets


def tet_volumes(nodes, tets):
    edges = nodes[tets[:, 1:]] - nodes[tets[:, :1]]
    return np.linalg.det(edges) / 6.0
