"""Rotations as quaternions (x, y, z, w), poses as (position, quaternion)."""

import numpy as np


def multiply(a, b):
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return np.array(
        [
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
            aw * bw - ax * bx - ay * by - az * bz,
        ]
    )


def conjugate(q):
    return np.array([-q[0], -q[1], -q[2], q[3]])


def rotate(q, v):
    """Turns one vector, or each row of a list of vectors."""
    v = np.asarray(v, float)
    u = np.asarray(q[:3], float)
    t = 2.0 * np.cross(u, v)
    return v + q[3] * t + np.cross(u, t)


def about(axis, angle):
    half = 0.5 * angle
    return np.append(np.sin(half) * np.asarray(axis, float), np.cos(half))


def compose(a, b):
    return (rotate(a[1], b[0]) + a[0], multiply(a[1], b[1]))


def inverse(pose):
    back = conjugate(pose[1])
    return (-rotate(back, pose[0]), back)


def angle_between(a, b):
    """Angle of the rotation from a to b [rad]."""
    d = multiply(conjugate(a), b)
    return 2.0 * np.arctan2(np.linalg.norm(d[:3]), abs(d[3]))
