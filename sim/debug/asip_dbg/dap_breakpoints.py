# SPDX-License-Identifier: Apache-2.0
"""Breakpoints of a client of the Debug Adapter Protocol, which always sends whole sets."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from sim.debug.asip_dbg.dap_fields import FieldError, refuse_others
from sim.debug.asip_dbg.dap_views import Body, Views
from sim.debug.asip_dbg.expressions import ExpressionError
from sim.debug.asip_dbg.locations import LocationError, line_location
from sim.debug.asip_dbg.points import Breakpoint
from sim.debug.asip_dbg.session import Session, SessionError
from sim.debug.asip_dbg.values import ValueMissing

REFUSED = (SessionError, LocationError, ValueMissing, ExpressionError, FieldError)
"""Reasons of a breakpoint that is not verified."""


class ClientBreakpoints:
    """Keeps the numbers of each set: a source's, functions', data and instructions."""

    def __init__(self, session: Session, views: Views) -> None:
        self.session = session
        self.views = views
        self._sets: dict[str, list[int]] = {}

    def lines(self, path: str, wanted: Iterable[Body], modified: bool = False) -> list[Body]:
        """Breakpoints of a source, in place of those it had. modified: the client's is newer."""

        def add(item: Body, condition: str, hits: str) -> Breakpoint:
            if modified:
                raise FieldError("the source is newer than the program; launch again to debug it")
            line = self.views.own_line(int(item["line"]))
            place = line_location(self.session.program, path, line)
            message = str(item.get("logMessage") or "")
            return self.session.add_breakpoint(place, condition, hits=hits, message=message)

        return self._replace(f"source {path}", "line breakpoint", wanted, add)

    def functions(self, wanted: Iterable[Body]) -> list[Body]:
        """Breakpoints at equations '(28)', labels, values by name."""

        def add(item: Body, condition: str, hits: str) -> Breakpoint:
            place = self.session.location(str(item["name"]))
            return self.session.add_breakpoint(place, condition, hits=hits)

        return self._replace("functions", "function breakpoint", wanted, add)

    def instructions(self, wanted: Iterable[Body]) -> list[Body]:
        """Breakpoints at bundles."""

        def add(item: Body, condition: str, hits: str) -> Breakpoint:
            bundle = int(str(item["instructionReference"]), 0) + int(item.get("offset", 0))
            place = self.session.location(f"*{bundle}")
            return self.session.add_breakpoint(place, condition, hits=hits)

        return self._replace("instructions", "instruction breakpoint", wanted, add)

    def data(self, wanted: Iterable[Body]) -> list[Body]:
        """Watches of values by name."""

        def add(item: Body, condition: str, hits: str) -> Breakpoint:
            if (kind := item.get("accessType", "write")) != "write":
                raise FieldError(f"accessType '{kind}' is not supported; a watch stops at writes")
            return self.session.add_watch(str(item["dataId"]), condition, hits)

        return self._replace("data", "data breakpoint", wanted, add)

    def _replace(
        self,
        name: str,
        what: str,
        wanted: Iterable[Any],
        add: Callable[[Body, str, str], Breakpoint],
    ) -> list[Body]:
        for number in self._sets.pop(name, []):
            if number in self.session.breakpoints:
                self.session.remove_breakpoint(number)
        kept = self._sets.setdefault(name, [])
        found = []
        for item in wanted:
            try:
                refuse_others(what, item)
                condition, hits = (str(item.get(n) or "") for n in ("condition", "hitCondition"))
                point = add(item, condition, hits)
            except REFUSED as error:
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
            body |= {"line": self.views.line(place.line), "source": self.views.source(place.file)}
        return body
