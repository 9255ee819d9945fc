"""A ROS 2 node between topics and ``thenar serve``. It needs ``rclpy``; the socket half needs nothing.

    thenar serve table-press --no-open &
    python3 thenar_bridge.py --ros-args -p host:=127.0.0.1 -p port:=8014 -p hand:=right

or, where ``thenar serve table-press --lan`` runs on another computer, with what it prints:

    python3 thenar_bridge.py --ros-args -p address:=https://192.168.1.5:8014/?token=… -p fingerprint:=AB:CD:…

| topic | type | |
|---|---|---|
| ``~/finger_forces`` | std_msgs/Float64MultiArray | normal and shear [N] of palm, thumb, index, middle, ring, little: 6 x 2 |
| ``~/objects`` | geometry_msgs/PoseArray | the rigid bodies, hands' bones included, in the frame ``thenar`` (+y up) |
| ``~/wrist`` (heard) | geometry_msgs/PoseStamped | where the wrist goes, in the frame ``thenar`` |
| ``~/joints`` (heard) | sensor_msgs/JointState | the twenty angles [rad], in the order of the protocol |
"""

from __future__ import annotations

import threading

import rclpy
from geometry_msgs.msg import Pose, PoseArray, PoseStamped
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray, MultiArrayDimension

from thenar_socket import LEFT, RIGHT, Snapshot, Thenar


class Bridge(Node):
    """Passes poses on to Thenar, and forces on to ROS."""

    def __init__(self) -> None:
        super().__init__("thenar")
        host = self.declare_parameter("host", "127.0.0.1").value
        port = self.declare_parameter("port", 8014).value
        address = self.declare_parameter("address", "").value
        fingerprint = self.declare_parameter("fingerprint", "").value
        side = self.declare_parameter("hand", "right").value
        self._hand = LEFT if side == "left" else RIGHT
        self._forces = self.create_publisher(Float64MultiArray, "~/finger_forces", 1)
        self._objects = self.create_publisher(PoseArray, "~/objects", 1)
        self.create_subscription(PoseStamped, "~/wrist", self._wrist, 1)
        self.create_subscription(JointState, "~/joints", self._joints, 1)
        self._angles = [0.0] * 20
        self._index: int | None = None
        self._thenar = Thenar.at(address, fingerprint) if address else Thenar(host, port)
        threading.Thread(target=self._listen, daemon=True).start()

    def _joints(self, message: JointState) -> None:
        if len(message.position) == 20:
            self._angles = list(message.position)
        else:
            self.get_logger().warning(f"expected 20 angles, got {len(message.position)}")

    def _wrist(self, message: PoseStamped) -> None:
        p, q = message.pose.position, message.pose.orientation
        clock = message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec
        self._thenar.follow(self._hand, clock, [p.x, p.y, p.z, q.x, q.y, q.z, q.w], self._angles)

    def _listen(self) -> None:
        for kind, message in self._thenar.messages():
            if kind == "model":
                sides = [hand["side"] for hand in message[1]["hands"]]
                side = "left" if self._hand == LEFT else "right"
                self._index = sides.index(side) if side in sides else None
            elif kind == "snapshot":
                self._publish(message)
            elif message.get("type") == "error":
                self.get_logger().warning(message["message"])

    def _publish(self, snapshot: Snapshot) -> None:
        if self._index is not None:
            forces = Float64MultiArray()
            forces.layout.dim = [
                MultiArrayDimension(label="part", size=6, stride=12),
                MultiArrayDimension(label="normal, shear", size=2, stride=2),
            ]
            forces.data = [x for part in snapshot.loads[self._index] for x in part[:2]]
            self._forces.publish(forces)
        objects = PoseArray()
        objects.header.frame_id = "thenar"
        objects.header.stamp = self.get_clock().now().to_msg()
        for x, y, z, i, j, k, w in snapshot.rigids:
            pose = Pose()
            pose.position.x, pose.position.y, pose.position.z = x, y, z
            pose.orientation.x, pose.orientation.y, pose.orientation.z, pose.orientation.w = i, j, k, w
            objects.poses.append(pose)
        self._objects.publish(objects)


def main() -> None:
    """Runs until it is interrupted."""
    rclpy.init()
    rclpy.spin(Bridge())


if __name__ == "__main__":
    main()
