"""The buttons of one browser: none before it knows the token.

They are viser's elements of this client alone: no other browser sees them or what is typed, and
before the token was right there is nothing that a forged message could press.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import viser

from multilift.flight.screen import NAMES, kill_question
from multilift.flight.snapshot import Snapshot
from multilift.flight.supervisor import Word
from multilift.flight.web.gate import Gate

_COLOURS = {
    Word.START: (38, 132, 68),
    Word.GO: (38, 132, 68),
    Word.HOLD: (166, 112, 0),
    Word.LAND: (28, 100, 190),
    Word.KILL: (190, 36, 36),
}

_ORDER = 1.0


class Buttons:
    """What one browser may press."""

    def __init__(
        self,
        client: viser.ClientHandle,
        gate: Gate,
        say: Callable[..., None],
        now: Callable[[], Snapshot | None],
    ) -> None:
        """Asks for the token.

        Args:
            client: the browser.
            gate: that knows the token.
            say: takes what is pressed.
            now: gives the newest snapshot.
        """
        self._client, self._gate, self._say, self._now = client, gate, say, now
        self._buttons: dict[Word, viser.GuiButtonHandle] = {}
        self._end_question: Callable[[], None] | None = None
        gui = client.gui
        self._lock = gui.add_folder("Buttons", order=_ORDER)
        with self._lock:
            typed = gui.add_text("token", "", hint="The terminal of the flight shows it.")
            unlock = gui.add_button("unlock the buttons")

        @unlock.on_click
        async def _(_: object) -> None:
            if gate.opens(typed.value):
                self._open()
            else:
                client.add_notification(
                    "Wrong token", "The terminal of the flight shows the right one.", color="red",
                    auto_close_seconds=6.0,
                )  # fmt: skip

    def offer(self, shown: Snapshot) -> None:
        """Lets press what may be said now."""
        for word, button in list(self._buttons.items()):
            offered = word.value in shown.words
            if button.disabled is offered:
                button.disabled = not offered
        if self._end_question is not None and Word.KILL.value not in shown.words:
            self._close()

    def _open(self) -> None:
        self._lock.remove()
        gui = self._client.gui
        for place, word in enumerate(NAMES):
            button = gui.add_button(
                NAMES[word][1], color=_COLOURS[word], disabled=True, order=_ORDER + 0.01 * place
            )
            button.on_click(self._ask if word is Word.KILL else self._saying(word))
            self._buttons[word] = button
        shown = self._now()
        if shown is not None:
            self.offer(shown)

    def _saying(self, word: Word) -> Callable[[object], None]:
        def press(_: object) -> None:
            shown = self._now()
            if shown is not None:
                self._say(press=word.value, state=shown.state, time=time.monotonic())

        return press

    def _ask(self, _: object) -> None:
        shown = self._now()
        if shown is None or self._end_question is not None:
            return
        gui = self._client.gui
        question = gui.add_modal("Kill")
        self._end_question = question.close
        with question:
            gui.add_markdown(kill_question(shown))
            yes = gui.add_button("yes, motors off", color="red")
            no = gui.add_button("no", color="gray")
        yes.on_click(self._saying(Word.KILL))
        for answer in (yes, no):
            answer.on_click(lambda _: self._close())

    def _close(self) -> None:
        end, self._end_question = self._end_question, None
        if end is not None:
            end()
