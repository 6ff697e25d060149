# SPDX-License-Identifier: Apache-2.0
"""Breakpoints of a client of the Debug Adapter Protocol, which always sends whole sets."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from sim.debugger.dap_views import Body, Views
from sim.debugger.locations import Location, LocationError, find_location, line_location
from sim.debugger.session import Breakpoint, Session, SessionError
from sim.debugger.values import ValueMissing


class ClientBreakpoints:
    """Keeps the numbers of each set: a source's, functions', data and instructions."""

    def __init__(self, session: Session, views: Views) -> None:
        self.session = session
        self.views = views
        self._sets: dict[str, list[int]] = {}

    def lines(self, path: str, wanted: Iterable[Body]) -> list[Body]:
        """Breakpoints of a source, in place of those it had."""

        def place(item: Body) -> Location:
            return line_location(self.session.program, path, int(item["line"]))

        return self._replace(f"source {path}", wanted, lambda item: self._at(place(item), item))

    def functions(self, wanted: Iterable[Body]) -> list[Body]:
        """Breakpoints at equations '(28)', labels, values by name."""

        def place(item: Body) -> Location:
            position = self.session.position
            return find_location(self.session.program, str(item["name"]), position)

        return self._replace("functions", wanted, lambda item: self._at(place(item), item))

    def instructions(self, wanted: Iterable[Body]) -> list[Body]:
        """Breakpoints at bundles."""

        def place(item: Body) -> Location:
            bundle = int(str(item["instructionReference"]), 0) + int(item.get("offset", 0))
            return find_location(self.session.program, f"*{bundle}", 0)

        return self._replace("instructions", wanted, lambda item: self._at(place(item), item))

    def data(self, wanted: Iterable[Body]) -> list[Body]:
        """Watches of values by name."""

        def add(item: Body) -> Breakpoint:
            condition = str(item.get("condition") or "")
            return self.session.add_watch(str(item["dataId"]), condition)

        return self._replace("data", wanted, add)

    def _at(self, place: Location, item: Body) -> Breakpoint:
        return self.session.add_breakpoint(place, str(item.get("condition") or ""))

    def _replace(
        self, name: str, wanted: Iterable[Any], add: Callable[[Body], Breakpoint]
    ) -> list[Body]:
        for number in self._sets.pop(name, []):
            if number in self.session.breakpoints:
                self.session.remove_breakpoint(number)
        kept = self._sets.setdefault(name, [])
        found = []
        for item in wanted:
            try:
                point = add(item)
            except (SessionError, LocationError, ValueMissing) as error:
                found.append({"verified": False, "message": str(error)})
                continue
            kept.append(point.number)
            found.append(self._told(point))
        return found

    def _told(self, point: Breakpoint) -> Body:
        body: Body = {"id": point.number, "verified": True, "message": point.text}
        if point.bundles:
            body["instructionReference"] = f"0x{point.bundles[0]:x}"
        if point.line:
            body |= {"line": point.line, "source": self.views.source(point.file)}
        return body
