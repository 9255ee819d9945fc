"""A job as a scene of Thenar's, to the last number: the same hand for Thenar's own Python package."""


def scene(job):
    """The text. Bodies are `b0`, `b1`, … and `flesh`; the drive's target passes each step's target at its end."""
    step = job["time_step"]
    lines = ["version = 1", f"time_step = {number(step)}", f"duration = {number(job['steps'] * step)}"]
    lines += [f"gravity = {vector(job['gravity'])}", "", "[[rigid]]", 'name = "table"']
    lines += ['motion = "fixed"', f"position = [0, {number(job['table']['height'])}, 0]"]
    lines += [f"friction = {number(job['table']['friction'])}", 'shape = { kind = "plane" }']
    for index, bone in enumerate(job["bones"]):
        lines += rigid(job, index, bone)
    for joint in job["joints"]:
        lines += jointed(joint)
    return "\n".join([*lines, *soft(job)]) + "\n"


def rigid(job, index, bone):
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = bone["inertia"]
    lines = ["", "[[rigid]]", f'name = "b{index}"', f"mass = {number(bone['mass'])}"]
    lines.append(f"inertia = {vector([xx, yy, zz, xy, xz, yz])}")
    # The others are placed by their joints.
    if index == 0:
        lines += placed(bone["pose"])
        pairs = ", ".join(f"{key} = {number(value)}" for key, value in job["drive"].items())
        lines += [f"drive = {{ {pairs} }}", 'interpolation = "linear"', "keyframes = ["]
        poses = [bone["pose"], *(row[0] for row in job["targets"])]
        for k, pose in enumerate(poses):
            lines.append(f"  {{ time = {number(k * job['time_step'])}, position = {vector(pose[:3])} }},")
        lines.append("]")
    return lines


def jointed(joint):
    axes = joint["axes"][: 1 if joint["kind"] == "hinge" else 2]
    lines = ["", "[[joint]]", f'name = "j{joint["child"]}"', f'kind = "{joint["kind"]}"']
    lines += [f'parent = "b{joint["parent"]}"', f'child = "b{joint["child"]}"']
    frames = [("parent", joint["pose_in_parent"]), ("child", joint["pose_in_child"])]
    for side, pose in frames:
        lines.append(f"{side}_frame = {{ {', '.join(placed(pose))} }}")
    for key, ours in (("stiffness", "stiffness"), ("damping", "damping"), ("rest_angle", "rest_angles")):
        lines.append(f"{ours} = {vector([axis[key] for axis in axes])}")
    # The hand begins in the pose in which it was built, where every spring is relaxed.
    lines.append(f"angles = {vector([axis['rest_angle'] for axis in axes])}")
    return lines


def soft(job):
    lines = ["", "[[soft]]", 'name = "flesh"', f"stiffness_damping = {number(job['stiffness_damping'])}"]
    lines += [f"mass_damping = {number(job['mass_damping'])}", f"friction = {number(job['table']['friction'])}"]
    lines += [f"bind_damping_time = {number(job['tie_damping_time'])}"]
    lines += [f"material = {{ young = {number(job['young'])}, poisson = {number(job['poisson'])}, density = {number(job['density'])} }}"]
    nodes = ", ".join(vector(node) for node in job["nodes"])
    tets = ", ".join(str([int(i) for i in tet]) for tet in job["tets"])
    lines += [f'shape = {{ kind = "tets", nodes = [{nodes}], tets = [{tets}] }}', "bind = ["]
    for tie in job["ties"]:
        where = f'nodes = {{ indices = [{tie["node"]}] }}, bones = ["b{tie["bone"]}"]'
        lines.append(f"  {{ {where}, node_stiffness = {number(tie['stiffness'])} }},")
    return [*lines, "]"]


def placed(pose):
    return [f"position = {vector(pose[:3])}", f"rotation = {{ quaternion = {vector(pose[3:])} }}"]


def vector(values):
    return "[" + ", ".join(number(x) for x in values) + "]"


def number(value):
    """With all its digits."""
    return repr(float(value))
