"""Send the lines of the standard input to a run: the other end of a bridge over ssh.

tail -f words.jsonl | ssh robot python3 send_lines.py /run/user/1000/pirate_sm.detector
"""

import socket
import sys


def main(path: str) -> None:
    """Send each line, with a word or a number, as soon as it comes."""
    with socket.socket(socket.AF_UNIX) as link:
        link.connect(path)
        for line in sys.stdin:
            link.sendall(line.encode())


if __name__ == "__main__":
    main(sys.argv[1])
