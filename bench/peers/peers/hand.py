"""The shipped hand, made into a body that all three engines can express without loss.

What is simplified, for all of them alike: one material throughout; each node is tied to one bone
(its dominant one) instead of a blend of two, and nodes halfway between bones are not tied; joints
have springs and dampers but no limits; what touches are the lattice's own boundary nodes.
"""

import json

import numpy as np

from . import rigid

YOUNG = 50e3  # Pa
POISSON = 0.43
STIFFNESS_DAMPING = 1e-3  # s
COUPLING_STIFFNESS = 2e9  # N/m per m3 of flesh, as in the shipped scenes
COUPLING_DAMPING_TIME = 1e-3  # s
FRICTION = 0.6
WEIGHT_TIED = 0.75  # a node nearer to the middle between two bones than this is left free


class Hand:
    """Arrays of the simplified hand, in its model frame (palm down: -y, fingers along -z)."""

    def __init__(self, path):
        with open(path, encoding="utf-8") as file:
            raw = json.load(file)
        flesh = raw["flesh"]
        self.nodes = np.array(flesh["nodes"])
        self.tets = np.array(flesh["tets"])
        self.volumes = np.array(flesh["tet_volumes"])
        self.density = sum(flesh["node_masses"]) / self.volumes.sum()
        self.bones = raw["bones"]
        self.joints = raw["joints"]
        for joint in self.joints:
            angles = rest_angles(joint, self.bones)
            for axis, angle in zip(joint["axes"], angles):
                axis["rest_angle"] = float(angle)
        self.ties = ties(flesh)
        self.boundary = boundary(self.tets)

    def pose(self, bone):
        pose = self.bones[bone]["pose"]
        return (np.array(pose["position"]), np.array(pose["rotation"]))

    def masses(self):
        """Mass of each node [kg], a quarter of each tetrahedron's."""
        masses = np.zeros(len(self.nodes))
        np.add.at(masses, self.tets, (self.density * self.volumes / 4.0)[:, None])
        return masses

    def mass(self):
        return self.masses().sum() + sum(bone["mass"] for bone in self.bones)

    def bent(self, angle):
        """Bone poses with every joint flexed by this much more than at rest [rad]."""
        poses = [self.pose(0)]
        for joint in self.joints:
            angles = [axis["rest_angle"] for axis in joint["axes"]]
            angles[-1] += angle
            turned = turn(joint["kind"], angles)
            frame = (np.zeros(3), turned)
            child = rigid.compose(pose_of(joint["pose_in_parent"]), frame)
            child = rigid.compose(child, rigid.inverse(pose_of(joint["pose_in_child"])))
            poses.append(rigid.compose(poses[joint["parent"]], child))
        return poses


def pose_of(table):
    return (np.array(table["position"]), np.array(table["rotation"]))


def turn(kind, angles):
    """Rotation of the child's joint frame in the parent's: Rx, or Ry then Rx."""
    if kind == "hinge":
        return rigid.about([1, 0, 0], angles[0])
    return rigid.multiply(rigid.about([0, 1, 0], angles[0]), rigid.about([1, 0, 0], angles[1]))


def rest_angles(joint, bones):
    """The joint's angles in the pose in which the hand was built."""
    parent = pose_of(bones[joint["parent"]]["pose"])
    child = pose_of(bones[joint["child"]]["pose"])
    frame = rigid.compose(parent, pose_of(joint["pose_in_parent"]))
    other = rigid.compose(child, pose_of(joint["pose_in_child"]))
    relative = rigid.multiply(rigid.conjugate(frame[1]), other[1])
    if joint["kind"] == "hinge":
        return [2.0 * np.arctan2(relative[0], relative[3])]
    # Ry(a) Rx(b) takes x to (cos a, 0, -sin a) and y to (.., cos b, ..).
    x = rigid.rotate(relative, [1, 0, 0])
    y = rigid.rotate(relative, [0, 1, 0])
    z = rigid.rotate(relative, [0, 0, 1])
    return [np.arctan2(-x[2], x[0]), np.arctan2(-z[1], y[1])]


def ties(flesh):
    """(node, bone, stiffness [N/m]) of every tied node."""
    found = []
    rows = zip(flesh["binding_bones"], flesh["binding_weights"], flesh["node_volumes"])
    for node, (bones, weights, volume) in enumerate(rows):
        first = int(np.argmax(weights))
        weight = sum(w for b, w in zip(bones, weights) if b == bones[first])
        if weight >= WEIGHT_TIED:
            found.append((node, bones[first], COUPLING_STIFFNESS * volume))
    return found


def boundary(tets):
    """Triangles that belong to one tetrahedron only, outward."""
    faces = {}
    for tet in tets:
        for corners in ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)):
            face = tuple(int(tet[c]) for c in corners)
            faces.setdefault(tuple(sorted(face)), []).append(face)
    return [found[0] for found in faces.values() if len(found) == 1]
