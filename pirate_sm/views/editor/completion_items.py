"""Words that are possible at a place, as the editor lists them and writes them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from lsprotocol import types

from pirate_sm.core.expressions import FUNCTIONS
from pirate_sm.core.model_keys import written_keys
from pirate_sm.core.models import Mission
from pirate_sm.views.editor.completions import PossibleWord
from pirate_sm.views.editor.hover import detail
from pirate_sm.views.editor.known_mission import KnownMission

_KINDS = types.CompletionItemKind


def items(
    offered: Iterable[PossibleWord],
    place: types.Range,
    known: KnownMission | None,
    *,
    fills: bool,
    opening: str,
) -> Iterator[types.CompletionItem]:
    """Yield the items of a list, those first that are possible in the states at the place.

    Args:
        offered: The words.
        place: What they replace.
        known: The mission that it is, with a mark at the place.
        fills: Whether the editor lets people fill in snippets.
        opening: What the entry begins with.
    """
    words = [*offered]
    if known and any(each.word in known.loaded.robot.vocabulary.types for each in words):
        words += (PossibleWord(each, is_key=False) for each in sorted(FUNCTIONS))
    keys = {each.word for each in words if each.is_key} if known else set()
    written = written_keys(Mission, keys)
    words += (PossibleWord(each, is_key=True) for each in sorted(written.shared))
    for each in words:
        form = written.snippets.get(each.word) if each.is_key and fills else None
        item = types.CompletionItem(
            each.word, kind=_KINDS.Property if each.is_key else _KINDS.Value
        )
        text = f"{each.word}: " if each.is_key else each.word
        if form is not None:
            text, item.kind = form.text(opening), _KINDS.Snippet
            item.insert_text_format = types.InsertTextFormat.Snippet
        elif known is not None and not each.is_key:
            item.detail, item.sort_text = _described(known, each.word)
        item.text_edit = types.TextEdit(place, text)
        yield item


def _described(known: KnownMission, word: str) -> tuple[str | None, str | None]:
    """Return what a word is, and what it is sorted by; commands by the states at the mark."""
    loaded, said = known.loaded, detail(known, word)
    name = loaded.loaded_robot.profile.aliases.get(word, word)
    if not known.at_mark or name not in loaded.robot.table.command_index:
        return said or None, None
    taken, why = known.refusals(loaded.robot.table.command_index[name])
    if taken == len(known.at_mark):
        return said, f"0{word}"
    if taken:
        return f"{said}; in some of the states here", f"1{word}"
    return f"{said}; {min(why)}", f"2{word}"
