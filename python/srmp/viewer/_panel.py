"""The panel beside the viewer's scene: buttons, the clock and plots. What they do is said by the viewer."""

from __future__ import annotations

import html
from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np

from srmp.viewer._motion import Motion
from srmp.viewer._plots import Plot
from srmp.viewer._scene import ROBOT_KINDS

_SPEEDS = ("0.1×", "0.25×", "0.5×", "1×", "2×")
_CLOCK_PERIOD = 0.1  # [s] of the motion, between two moves of the slider
_CURSOR_PERIOD = 0.25  # and between two moves of the plots' cursors, each of which sends the plot again


class Actions(Protocol):
    """What the panel calls, in threads of the server."""

    def on_plan(self) -> None: ...
    def on_reset_goals(self) -> None: ...
    def on_stand_here(self) -> None: ...
    def on_play(self) -> None: ...
    def on_seek(self, moment: float) -> None: ...
    def on_switch(self, kind: str, visible: bool) -> None: ...
    def on_node(self, place: int) -> None: ...


class Panel:
    """The controls of a viewer."""

    def __init__(self, server: Any, kinds: Sequence[str], actions: Actions) -> None:
        self.status = ""
        self.notes: list[str] = []
        self._gui = gui = server.gui
        self._shown_time = -1.0
        self._status = gui.add_html("")
        with gui.add_folder("Plan"):
            gui.add_button("Plan", hint="To the goals of all handles that were moved.").on_click(
                lambda _: actions.on_plan()
            )
            gui.add_button("Stand here", hint="Plans begin where the robots are shown.").on_click(
                lambda _: actions.on_stand_here()
            )
            gui.add_button("Forget goals").on_click(lambda _: actions.on_reset_goals())
        with gui.add_folder("Motion"):
            self._play = gui.add_button("Play / pause", disabled=True)
            self._play.on_click(lambda _: actions.on_play())
            self._slider = gui.add_slider("time [s]", 0.0, 1.0, 0.01, 0.0, disabled=True)
            # The client is None where the program itself has moved the slider.
            self._slider.on_update(lambda event: event.client is None or actions.on_seek(self._slider.value))
            self._speed = gui.add_dropdown("speed", _SPEEDS, initial_value="1×")
        with gui.add_folder("Robots as"):
            for kind in ROBOT_KINDS:
                box = gui.add_checkbox(kind, kind in kinds[:1])
                box.on_update(lambda event, kind=kind: actions.on_switch(kind, event.target.value))
        self._plots = gui.add_folder("Limits and clearance", visible=False)
        self._shown_cursor = -1.0
        self._plot_handles: list[Any] = []
        self._certificates = gui.add_folder("Certificate", visible=False, expand_by_default=False)
        with self._certificates:
            self._claims = gui.add_html("")
        self._search = gui.add_folder("Constraint tree", visible=False)
        with self._search:
            self._tree = gui.add_html("")
            self._node = gui.add_slider("node", 0, 1, 1, 0)
        self._node.on_update(lambda event: event.client is None or actions.on_node(int(self._node.value)))

    @property
    def speed(self) -> float:
        """Seconds of the motion in a second."""
        return float(self._speed.value.removesuffix("×"))

    def say(self, text: str, failed: bool = False) -> None:
        """The sentence at the top."""
        self.status = text
        colour = "#b3201e" if failed else "inherit"
        self._status.content = (
            f'<div style="padding: 0.3em 1em; color: {colour}; overflow-wrap: anywhere">{html.escape(text)}</div>'
        )

    def show_panels(self, panels: Sequence[tuple[str, str]]) -> None:
        """Certificates of the motion: titles and HTML."""
        self._claims.content = _framed("".join(f"<b>{html.escape(title)}</b>{text}" for title, text in panels))
        self._certificates.visible = bool(panels)

    def show_tree(self, text: str, place: int, count: int) -> None:
        """A constraint tree as HTML, and which of its `count` nodes is chosen; "": there is none."""
        self._tree.content = _framed(text)
        self._search.visible = bool(text)
        self._node.max, self._node.value = max(count - 1, 1), place

    def show_motion(self, motion: Motion | None, plots: Sequence[Plot], notes: Sequence[str]) -> None:
        """The clock and the plots of a motion; None: there is none."""
        self._play.disabled = self._slider.disabled = motion is None
        self._slider.max = max(round(motion.duration, 2), 0.01) if motion else 1.0
        self.notes = list(notes)
        self.say("; ".join(notes))
        before, self._plot_handles = self._plot_handles, []
        for handle in before:
            handle.remove()
        with self._plots:
            self._plot_handles = [_added(self._gui, plot) for plot in plots]
        self._plots.visible = bool(plots)
        self._shown_time = self._shown_cursor = -1.0
        self.show_time(0.0)

    def show_time(self, moment: float) -> None:
        """Moves the slider, not more often than one can see."""
        if moment == 0.0 or moment >= self._slider.max or abs(moment - self._shown_time) >= _CLOCK_PERIOD:
            self._shown_time = moment
            self._slider.value = min(round(moment, 2), self._slider.max)
        if moment == 0.0 or moment >= self._slider.max or abs(moment - self._shown_cursor) >= _CURSOR_PERIOD:
            self._shown_cursor = moment
            for handle in self._plot_handles:
                handle.data = _with_cursor(handle.data[:-1], moment)


def _framed(text: str) -> str:
    return f'<div style="padding: 0 1em; font-size: 0.8em; overflow: auto; max-height: 24em">{text}</div>'


def _added(gui: Any, plot: Plot) -> Any:
    from viser import uplot

    lines = [uplot.Series(label=line.name, stroke=line.colour, width=1.5) for line in plot.series]
    values = [np.where(np.isfinite(line.values), line.values, np.nan) for line in plot.series]
    if plot.limit is not None:
        lines.append(uplot.Series(label="limit", stroke="#b3402e", width=1, dash=(4, 4)))
        values.append(np.full(len(plot.times), plot.limit))
    lines.append(uplot.Series(label="now", stroke="#26303a", width=0, points=uplot.Series_Points(show=True, size=9)))
    return gui.add_uplot(
        _with_cursor((plot.times, *values), 0.0),
        (uplot.Series(label="time [s]"), *lines),
        scales={"x": uplot.Scale(time=False, auto=True)},
        title=plot.title,
        legend=uplot.Legend(show=False),
        height=150,
    )


def _with_cursor(data: tuple[np.ndarray, ...], moment: float) -> tuple[np.ndarray, ...]:
    """The times and lines of a plot, and a line that has but one point: the highest value, now."""
    cursor = np.full(len(data[0]), np.nan)
    cursor[np.argmin(np.abs(data[0] - moment))] = np.nanmax(data[1:])
    return (*data, cursor)
