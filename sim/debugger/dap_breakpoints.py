# SPDX-License-Identifier: Apache-2.0
"""Breakpoints of a client of the Debug Adapter Protocol, which always sends whole sets."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from sim.debugger.dap_views import Body, Views
from sim.debugger.locations import LocationError, line_location
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

        def add(item: Body, condition: str) -> Breakpoint:
            place = line_location(self.session.program, path, int(item["line"]))
            return self.session.add_breakpoint(place, condition)

        return self._replace(f"source {path}", wanted, add)

    def functions(self, wanted: Iterable[Body]) -> list[Body]:
        """Breakpoints at equations '(28)', labels, values by name."""

        def add(item: Body, condition: str) -> Breakpoint:
            place = self.session.location(str(item["name"]))
            return self.session.add_breakpoint(place, condition)

        return self._replace("functions", wanted, add)

    def instructions(self, wanted: Iterable[Body]) -> list[Body]:
        """Breakpoints at bundles."""

        def add(item: Body, condition: str) -> Breakpoint:
            bundle = int(str(item["instructionReference"]), 0) + int(item.get("offset", 0))
            return self.session.add_breakpoint(self.session.location(f"*{bundle}"), condition)

        return self._replace("instructions", wanted, add)

    def data(self, wanted: Iterable[Body]) -> list[Body]:
        """Watches of values by name."""

        def add(item: Body, condition: str) -> Breakpoint:
            return self.session.add_watch(str(item["dataId"]), condition)

        return self._replace("data", wanted, add)

    def _replace(
        self, name: str, wanted: Iterable[Any], add: Callable[[Body, str], Breakpoint]
    ) -> list[Body]:
        for number in self._sets.pop(name, []):
            if number in self.session.breakpoints:
                self.session.remove_breakpoint(number)
        kept = self._sets.setdefault(name, [])
        found = []
        for item in wanted:
            try:
                point = add(item, str(item.get("condition") or ""))
            except (SessionError, LocationError, ValueMissing) as error:
                found.append({"verified": False, "message": str(error)})
                continue
            kept.append(point.number)
            found.append(self._told(point))
        return found

    def _told(self, point: Breakpoint) -> Body:
        place = point.location
        body: Body = {"id": point.number, "verified": True, "message": place.text}
        if place.bundles:
            body["instructionReference"] = f"0x{place.bundles[0]:x}"
        if place.line:
            body |= {"line": place.line, "source": self.views.source(place.file)}
        return body
