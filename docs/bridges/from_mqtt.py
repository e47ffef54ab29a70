"""Send the messages of an MQTT topic to a run; needs paho-mqtt 2.

python3 from_mqtt.py BROKER TOPIC /run/user/1000/pirate_sm.detector
"""

import socket
import sys

import paho.mqtt.client as mqtt


def main(broker: str, topic: str, path: str) -> None:
    """Send each message, one line of JSON, as soon as it comes; an old, retained one is not."""
    with socket.socket(socket.AF_UNIX) as link:
        link.connect(path)
        client = mqtt.Client(mqtt.CallbackAPIVersion.VERSION2)
        client.on_connect = lambda client, *_: client.subscribe(topic)
        client.on_message = lambda _client, _data, message: (
            message.retain or link.sendall(message.payload + b"\n")
        )
        client.connect(broker)
        client.loop_forever()


if __name__ == "__main__":
    main(*sys.argv[1:])
