"""What is read off an outcome: always from node and bone places, by the same formulas."""

import numpy as np

from . import jobs, rigid

MM = 1e3


def nodes_of(outcome):
    return np.array([frame["nodes"] for frame in outcome["frames"]])


def bones_of(outcome):
    return np.array([frame["bones"] for frame in outcome["frames"]])


def rms(vectors):
    return float(np.sqrt(np.mean(np.sum(np.square(vectors), axis=-1))))


def step_times(outcomes):
    """Median and 99th percentile over the steps; of repeats of one step the quickest counts.

    All repeats do the same work, so what differs between them is what else the machine does.
    """
    length = min(len(outcome["step_ms"]) for outcome in outcomes)
    times = np.min([outcome["step_ms"][:length] for outcome in outcomes], axis=0)
    return {"median": float(np.median(times)), "p99": float(np.percentile(times, 99))}


def against(outcome, reference):
    """Distance of nodes and bones from the reference at the recorded moments [mm]."""
    found = {}
    ours, theirs = nodes_of(outcome), nodes_of(reference)
    if ours.shape != theirs.shape:
        return {"nodes_rms": None, "nodes_max": None, "bones_rms": None}
    gap = ours - theirs
    found["nodes_rms"] = rms(gap) * MM
    found["nodes_max"] = float(np.linalg.norm(gap, axis=-1).max()) * MM
    bones = bones_of(outcome)
    if bones.size:
        found["bones_rms"] = rms(bones[:, :, :3] - bones_of(reference)[:, :, :3]) * MM
    return found


def stretch(job, outcome):
    """How far tied nodes are from their place in the bone, over the recorded moments [mm]."""
    if not job["ties"]:
        return {}
    nodes, bones = nodes_of(outcome), bones_of(outcome)
    rest = np.array(job["nodes"])
    gaps = []
    for tie in job["ties"]:
        at = job["bones"][tie["bone"]]["pose"]
        local = rigid.rotate(rigid.conjugate(at[3:]), rest[tie["node"]] - np.array(at[:3]))
        for frame in range(len(nodes)):
            pose = bones[frame, tie["bone"]]
            anchor = rigid.rotate(pose[3:], local) + pose[:3]
            gaps.append(nodes[frame, tie["node"]] - anchor)
    return {
        "stretch_rms": rms(gaps) * MM,
        "stretch_max": float(np.linalg.norm(gaps, axis=1).max()) * MM,
    }


def joint_gap(job, outcome):
    """Largest distance between the two sides of a joint [mm]."""
    worst = 0.0
    for pose_list in bones_of(outcome) if job["joints"] else []:
        for joint in job["joints"]:
            ends = []
            for end, frame in (("parent", "pose_in_parent"), ("child", "pose_in_child")):
                pose = pose_list[joint[end]]
                ends.append(rigid.rotate(pose[3:], joint[frame][:3]) + pose[:3])
            worst = max(worst, float(np.linalg.norm(ends[0] - ends[1])))
    return {"joint_gap_max": worst * MM} if job["joints"] else {}


def contact(job, outcome, hand):
    """Of the table press: depth, load, friction, and how steady the force is."""
    step = job["time_step"]
    frame_times = np.array([frame["step"] for frame in outcome["frames"]]) * step
    nodes, bones = nodes_of(outcome), bones_of(outcome)
    touching = np.unique(np.array(job["boundary"]))
    depths = job["table"]["height"] - nodes[:, touching, 1].min(axis=1)
    forces = np.array(outcome["table_force"])
    times = (np.arange(len(forces)) + 1) * step
    held = (times > jobs.PRESS_HELD - 0.2) & (times <= jobs.PRESS_HELD)
    held_frames = (frame_times > jobs.PRESS_HELD - 0.2) & (frame_times <= jobs.PRESS_HELD + 1e-9)
    slid_frames = frame_times > jobs.PRESS_DRAGGED - 0.1

    # At rest the drive's spring and the weight are what the table must carry.
    lags = np.array(
        [
            np.array(job["targets"][frame["step"] - 1][0][:3]) - bones[k, 0, :3]
            for k, frame in enumerate(outcome["frames"])
        ]
    )
    pull = job["drive"]["stiffness"] * lags
    weight = hand.mass() * -jobs.GRAVITY[1]
    load = weight - pull[:, 1]
    friction = np.hypot(pull[:, 0], pull[:, 2]) / load
    reported = -forces[held, 1]
    contacts = np.array(outcome["contacts"])
    return {
        "penetration_max": float(depths.max()) * MM,
        "penetration_held": float(depths[held_frames].max()) * MM,
        "load": float(load[held_frames].mean()),
        "table_force": float(reported.mean()),
        "force_over_load": float(reported.mean() / load[held_frames].mean()),
        "force_unsteady": float(reported.std() / max(reported.mean(), 1e-9)),
        "friction_over_load": float(friction[slid_frames].mean()),
        "contacts": float(contacts[held].mean()),
        "palm_lag": float(np.linalg.norm(lags[held_frames], axis=1).mean()) * MM,
    }


def end_deflection(job, outcome):
    """Mean sinking of the bar's end [mm]."""
    rest = np.array(job["nodes"])
    end = rest[:, 0] > rest[:, 0].max() - 1e-9
    return float((rest[end, 1] - nodes_of(outcome)[-1][end, 1]).mean()) * MM
