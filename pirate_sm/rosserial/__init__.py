"""The rosserial protocol, revision 1, for both ends of a serial link; needs no ROS.

``frames`` turns payloads into bytes and bytes into payloads, ``topics`` holds the reserved topics
and their payloads, ``messages`` the types that ``.msg`` texts define (rosbags). Nothing in here
reads a clock or a port.
"""
