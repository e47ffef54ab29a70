"""An editor that talks with the language server by its wire format, and blocks until it answers."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import IO, Any

Json = Mapping[str, Any]
CAPABILITIES = {"general": {"positionEncodings": ["utf-16"]}}
_ERROR = 1
"""The type of a message that is an error."""


class Client:
    """The client's end of a connection; texts are known by the paths of their files.

    Attributes:
        shown: The findings that are shown now, by file.
        versions_shown: The versions of texts of which findings were shown, one after the other.
        answers: What is answered when the server asks, by method.
    """

    def __init__(self, to_server: IO[bytes], from_server: IO[bytes]) -> None:
        self._to, self._from = to_server, from_server
        self._asked = 0
        self._versions: dict[Path, int] = {}
        self.shown: dict[Path, list[Json]] = {}
        self.versions_shown: list[int | None] = []
        self.answers: dict[str, Any] = {}
        self._messages: list[Json] = []

    def send(self, method: str, params: Json | None, number: int | None = None) -> None:
        """Send a notification, or a request if it has a number."""
        said = {"jsonrpc": "2.0", "method": method, "params": params}
        self._write(said if number is None else {**said, "id": number})

    def _write(self, message: Json) -> None:
        content = json.dumps(message).encode()
        self._to.write(b"Content-Length: %d\r\n\r\n%b" % (len(content), content))
        self._to.flush()

    def ask(self, method: str, params: Json | None) -> Any:
        """Ask, and return the answer; what else comes is taken."""
        self._asked += 1
        self.send(method, params, self._asked)
        while True:
            answer = self._take()
            if answer.get("id") == self._asked and "method" not in answer:
                assert "error" not in answer, answer
                return answer["result"]

    def begin(self, root: Path, capabilities: Json = CAPABILITIES) -> Json:
        """Open a folder; return what the server can do."""
        asked = {"processId": None, "rootUri": root.as_uri(), "capabilities": capabilities}
        result: Json = self.ask("initialize", asked)
        self.send("initialized", {})
        return result["capabilities"]  # type: ignore[no-any-return]

    def end(self) -> None:
        """End the server."""
        self.ask("shutdown", None)
        self.send("exit", None)

    def write(self, path: Path, text: str) -> list[Json]:
        """Open a file or change it, and return what is shown in it then."""
        return self.settle(path, self.put(path, text))

    def put(self, path: Path, text: str) -> int:
        """Open a file or change it, and return the version of its text."""
        version = self._versions[path] = self._versions.get(path, 0) + 1
        named = {"uri": path.as_uri(), "version": version}
        if version == 1:
            opened = {**named, "text": text, "languageId": "yaml"}
            self.send("textDocument/didOpen", {"textDocument": opened})
        else:
            changes = [{"text": text}]
            self.send("textDocument/didChange", {"textDocument": named, "contentChanges": changes})
        return version

    def close(self, path: Path) -> None:
        """Close a file, and wait until nothing is shown in it."""
        del self._versions[path]
        self.send("textDocument/didClose", {"textDocument": {"uri": path.as_uri()}})
        while self.shown[path]:
            self._published()

    def settle(self, path: Path, version: int | None) -> list[Json]:
        """Wait until findings of this version of a text are shown, and return them.

        What is withdrawn before the check has ended has no version.
        """
        while self._published() != (path.as_uri(), version):
            pass
        return self.shown[path]

    def about(self, method: str, path: Path, **more: Any) -> Any:
        """Ask about a file."""
        return self.ask(f"textDocument/{method}", {"textDocument": {"uri": path.as_uri()}, **more})

    def message(self, method: str) -> Json:
        """Return what the server says or asks by itself, once it has."""
        while True:
            for each in self._messages:
                if each["method"] == method:
                    self._messages.remove(each)
                    return each["params"]  # type: ignore[no-any-return]
            self._take()

    def _published(self) -> tuple[str, int | None]:
        """Take messages until one shows findings; return the file and the version of its text.

        Raises:
            AssertionError: The server shows an error, so that the findings may never come.
        """
        message: Json = {}
        while message.get("method") != "textDocument/publishDiagnostics":
            said = (each for each in self._messages if each["method"] == "window/showMessage")
            wrong = [each["params"]["message"] for each in said if each["params"]["type"] == _ERROR]
            assert not wrong, wrong
            message = self._take()
        return message["params"]["uri"], message["params"].get("version")

    def _take(self) -> Json:
        length = 0
        while line := self._from.readline().strip():
            name, _, value = line.partition(b": ")
            length = int(value) if name == b"Content-Length" else length
        if not length:
            raise EOFError("the server has ended")
        message: Json = json.loads(self._from.read(length))
        if message.get("method") == "textDocument/publishDiagnostics":
            uri = message["params"]["uri"]
            self.versions_shown.append(message["params"].get("version"))
            self.shown[Path(uri.removeprefix("file://"))] = message["params"]["diagnostics"]
        elif "method" in message:
            self._messages.append(message)
            if "id" in message and message["method"] in self.answers:
                result = self.answers[message["method"]]
                self._write({"jsonrpc": "2.0", "id": message["id"], "result": result})
        return message
