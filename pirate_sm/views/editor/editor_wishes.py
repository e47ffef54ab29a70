"""What an editor can do, and what its settings ask for."""

from __future__ import annotations

from typing import Any

from lsprotocol import types
from pygls.lsp.server import LanguageServer

from pirate_sm.views.editor.shown_findings import SOURCE


class EditorWishes:
    """The settings of the editor, and its abilities.

    Args:
        server: The server that it talks with.

    Attributes:
        hints: Whether hints are wanted next to the text.
    """

    def __init__(self, server: LanguageServer) -> None:
        self._server, self.hints = server, True

    @property
    def fills(self) -> bool:
        """Whether the editor lets people fill in snippets."""
        texts = self._server.client_capabilities.text_document
        item = texts and texts.completion and texts.completion.completion_item
        return bool(item and item.snippet_support)

    def take(self, settings: Any) -> None:
        """Use the settings, as far as there are any."""
        if isinstance(settings, dict):
            self.hints = settings.get("hints", self.hints) is not False

    def change(self, said: types.DidChangeConfigurationParams) -> None:
        """Use other settings."""
        self.take(said.settings.get(SOURCE) if isinstance(said.settings, dict) else None)
        self.refresh_hints()

    def refresh_hints(self) -> None:
        """Let the editor ask for hints again, if it can."""
        workspace = self._server.client_capabilities.workspace
        if workspace and workspace.inlay_hint and workspace.inlay_hint.refresh_support:
            self._server.workspace_inlay_hint_refresh(None)
