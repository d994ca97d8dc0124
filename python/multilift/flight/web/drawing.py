"""All that a page shows, drawn with viser."""

from __future__ import annotations

from collections.abc import Callable

import viser

from multilift.flight.snapshot import Snapshot
from multilift.flight.web import words
from multilift.flight.web.buttons import Buttons
from multilift.flight.web.gate import Gate
from multilift.flight.web.history import History
from multilift.flight.web.plots import Plots
from multilift.flight.web.space import Space
from multilift.flight.web.stage import Stage

#: Widths of the panels, px.
_RIGHT, _LEFT = 470, 400


class Drawing:
    """A page.

    Attributes:
        gate: who may press buttons.
    """

    def __init__(
        self, server: viser.ViserServer, stage: Stage, gate: Gate, say: Callable[..., None]
    ) -> None:
        """Lays it out.

        Args:
            server: that shows it.
            stage: what does not change.
            gate: who may press buttons.
            say: takes what is to be told to the command.
        """
        gui = server.gui
        gui.configure_theme(dark_mode=True, show_logo=False, show_share_button=False)
        gui.set_panel_label(stage.title)
        gui.main_panel.dock_right()
        gui.main_panel.set_width(_RIGHT)
        self.gate = gate
        self._history = History()
        self._head = gui.add_html(words.waiting(), order=0)
        self._rest = gui.add_html("", order=2)
        self._space = Space(server, stage)
        self._buttons: dict[int, Buttons] = {}
        self._plots: dict[int, Plots] = {}
        self._shown: Snapshot | None = None

        @server.on_client_connect
        async def _(client: viser.ClientHandle) -> None:
            self._buttons[client.client_id] = Buttons(client, gate, say, self._now)
            self._plots[client.client_id] = _plots(client, len(stage.rotors))

        @server.on_client_disconnect
        async def _(client: viser.ClientHandle) -> None:
            self._buttons.pop(client.client_id, None)
            self._plots.pop(client.client_id, None)

    def space(self, shown: Snapshot, age: float) -> None:
        """Draws the view in space.

        Args:
            shown: the newest snapshot.
            age: since it came, s.
        """
        if shown is not self._shown:
            self._shown = shown
            self._history.add(shown)
        self._space.draw(shown, self._history, stale=words.is_stale(age))

    def words(self, shown: Snapshot, age: float) -> None:
        """Writes numbers and texts, and offers what may be said."""
        self._head.content = words.head(shown, age)
        self._rest.content = words.rest(shown, age)
        for buttons in list(self._buttons.values()):
            buttons.offer(shown)

    def plots(self, shown: Snapshot, age: float) -> None:
        """Draws the curves."""
        for plots in list(self._plots.values()):
            plots.draw(self._history)

    def _now(self) -> Snapshot | None:
        return self._shown


def _plots(client: viser.ClientHandle, count: int) -> Plots:
    """The plots of one browser: left of the view in space; on a narrow screen below the rest."""
    panel = client.gui.add_panel()
    with panel.add_tab("last 30 s"):
        plots = Plots(client.gui, count)
    if client.camera.image_width < client.camera.image_height:
        panel.dock_below(client.gui.main_panel)
    else:
        panel.dock_left()
        panel.set_width(_LEFT)
    return plots
