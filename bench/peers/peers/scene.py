"""A press as a scene of Thenar's, with the hand of the jobs as a model file, for Thenar's own Python package."""


def press(job, model):
    """The text. The palm is led by the caller step by step; the other bones have no drives."""
    return f"""
version = 1
time_step = {job["time_step"]!r}
gravity = [{", ".join(repr(float(x)) for x in job["gravity"])}]

[[rigid]]
name = "table"
motion = "fixed"
position = [0, {job["table"]["height"]!r}, 0]
friction = {job["table"]["friction"]!r}
shape = {{ kind = "plane" }}

[[hand]]
name = "hand"
model = '{model}'
coupling = "uniform"
coupling_damping_time = {job["tie_damping_time"]!r}
elements = "tetrahedra"
bones = "none"
self_contact = false
friction = {job["table"]["friction"]!r}
bone_drive = {{ stiffness = 0 }}

[hand.palm_drive]
{"".join(f"{key} = {float(value)!r}" + chr(10) for key, value in job["drive"].items())}
"""
