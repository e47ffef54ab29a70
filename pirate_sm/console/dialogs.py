"""What lies over the console for a moment. The stop works above all of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar, NamedTuple

from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.content import Content
from textual.screen import ModalScreen
from textual.widgets import Button, OptionList, Static
from textual.widgets.option_list import Option

from pirate_sm.console.themed import line
from pirate_sm.showing.styled import MUTED


class Confirm(ModalScreen[bool]):
    """Asks for a yes; anything else is a no."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("y", "answer(True)", "Yes"),
        Binding("n,escape", "answer(False)", "No"),
    ]

    def __init__(self, question: str, yes: str) -> None:
        super().__init__()
        self._question = question
        self._yes = yes

    def compose(self) -> ComposeResult:
        """The question and two buttons; the careful one has the focus."""
        with Vertical(classes="dialog"):
            yield Static(self._question, markup=False, classes="question")
            with Horizontal(classes="buttons"):
                yield Button(f"{self._yes} (y)", variant="warning", id="yes")
                yield Button("No (n)", variant="default", id="no")

    def on_mount(self) -> None:
        """Enter alone says no."""
        self.query_one("#no").focus()

    def on_button_pressed(self, event: Button.Pressed) -> None:
        """The button answers."""
        self.dismiss(event.button.id == "yes")

    def action_answer(self, yes: bool) -> None:
        """The key answers."""
        self.dismiss(yes)


class Choice(NamedTuple):
    """One line of a list; with a reason it cannot be chosen."""

    name: str
    label: str
    detail: str = ""
    reason: str = ""


class Pick(ModalScreen[str | None]):
    """A list to choose one of."""

    BINDINGS: ClassVar[list[BindingType]] = [Binding("escape,q", "dismiss(None)", "Cancel")]

    def __init__(self, title: str, choices: Sequence[Choice], wide: int = 24) -> None:
        super().__init__()
        self._title = title
        self._wide = wide
        self._choices = list(choices)

    def compose(self) -> ComposeResult:
        """The list, and what one can do with it."""
        with Vertical(classes="dialog pick"):
            options = [
                Option(self._text(each), each.name, bool(each.reason)) for each in self._choices
            ]
            listed = OptionList(*options)
            listed.border_title = self._title
            listed.border_subtitle = "↑ ↓ Enter chooses   Esc leaves"
            yield listed

    def _text(self, choice: Choice) -> Content:
        label = f"{choice.label:<{self._wide}} "
        if choice.reason:
            return line((f"✕ {label}{choice.reason}", MUTED))
        return line("  ", (label, "bold"), (choice.detail, MUTED))

    def replace(self, choices: Sequence[Choice]) -> None:
        """Reasons have become known."""
        listed = self.query_one(OptionList)
        for index, choice in enumerate(choices):
            if choice != self._choices[index]:
                listed.replace_option_prompt_at_index(index, self._text(choice))
                (
                    listed.disable_option_at_index
                    if choice.reason
                    else listed.enable_option_at_index
                )(index)
        self._choices = list(choices)

    def on_option_list_option_selected(self, event: OptionList.OptionSelected) -> None:
        """It is chosen."""
        self.dismiss(event.option.id)


class Help(ModalScreen[None]):
    """Every key, and what the signs mean."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape,q,question_mark,enter", "dismiss", "Close")
    ]

    def __init__(self, lines: Sequence[Content]) -> None:
        super().__init__()
        self._lines = lines

    def compose(self) -> ComposeResult:
        """A page that scrolls."""
        with VerticalScroll(classes="dialog help") as page:
            page.border_title = "Help"
            page.border_subtitle = "Esc leaves"
            yield Static(Content("\n").join(self._lines))
