"""Send a word for each text of a ROS 2 topic to a run; needs rclpy, which ROS installs.

python3 from_ros2.py /detector /run/user/1000/pirate_sm.detector
"""

import json
import socket
import sys

import rclpy
from std_msgs.msg import String


def main(topic: str, path: str) -> None:
    """Send the text of each message as a word, as soon as it comes."""
    with socket.socket(socket.AF_UNIX) as link:
        link.connect(path)
        rclpy.init()
        node = rclpy.create_node("pirate_sm_detector")

        def send(message: String) -> None:
            link.sendall(json.dumps({"word": message.data}).encode() + b"\n")

        node.create_subscription(String, topic, send, 10)
        rclpy.spin(node)


if __name__ == "__main__":
    main(*sys.argv[1:])
