"""The rosserial protocol, revision 1, for both ends of a serial link; needs no ROS.

``frames`` converts between payloads and bytes, and has the reserved topics and their payloads.
``messages`` has the types that ``.msg`` texts define (rosbags). Nothing here reads a clock or a
port.
"""
