# SPDX-License-Identifier: Apache-2.0
"""Recorded ticks as a file: CSV, Parquet, MCAP (Foxglove, PlotJuggler).

All hold the tick, the time [s] and every channel in full precision. CSV has the units in its head
(`name [unit]`), Parquet in the metadata of each column, MCAP in its schema. JSON has no NaN and no
infinity: messages of MCAP leave such values out.
"""

from __future__ import annotations

import io
import math
from collections.abc import Callable, Sequence

import msgspec

from sim.debug.scope.source import Block, Channel

TOPIC = "/asip"


def csv(channels: Sequence[Channel], period: float, block: Block) -> bytes:
    """A line per tick; numbers read back as the same double."""
    heads = ["tick", "time [s]", *(f"{channel.name} [{channel.unit}]" for channel in channels)]
    out = io.StringIO()
    out.write(",".join(heads) + "\n")
    for k, row in enumerate(block.values.tolist()):
        tick = block.first + k
        out.write(f"{tick},{tick * period!r},{','.join(map(repr, row))}\n")
    return out.getvalue().encode()


def parquet(channels: Sequence[Channel], period: float, block: Block) -> bytes:
    """A row per tick, a column per channel."""
    import numpy as np
    import pyarrow
    import pyarrow.parquet

    ticks = np.arange(block.first, block.first + len(block.values))
    fields = [pyarrow.field("tick", pyarrow.int64())]
    fields.append(pyarrow.field("time", pyarrow.float64(), metadata={"unit": "s"}))
    for channel in channels:
        about = {"unit": channel.unit, "group": channel.group, "meaning": channel.meaning}
        fields.append(pyarrow.field(channel.name, pyarrow.float64(), metadata=about))
    table = pyarrow.Table.from_arrays(
        [pyarrow.array(column) for column in (ticks, ticks * period, *block.values.T)],
        schema=pyarrow.schema(fields),
    )
    out = io.BytesIO()
    pyarrow.parquet.write_table(table, out, compression="zstd")
    return out.getvalue()


def mcap(channels: Sequence[Channel], period: float, block: Block) -> bytes:
    """A JSON message per tick on TOPIC; its time is that of the loop, from 0."""
    from mcap.writer import Writer

    properties: dict[str, dict[str, str]] = {"tick": {"type": "integer"}}
    for channel in channels:
        about = f"{channel.meaning} [{channel.unit}]".strip()
        properties[channel.name] = {"type": "number", "description": about}
    schema = {"type": "object", "title": "tick", "properties": properties}
    out = io.BytesIO()
    writer = Writer(out)
    writer.start(profile="", library="microtick asip-scope")
    kind = writer.register_schema("asip.tick", "jsonschema", msgspec.json.encode(schema))
    channel_id = writer.register_channel(TOPIC, "json", kind)
    names = [channel.name for channel in channels]
    for k, row in enumerate(block.values.tolist()):
        tick = block.first + k
        time = round(tick * period * 1e9)
        finite = {n: v for n, v in zip(names, row, strict=True) if math.isfinite(v)}
        data = msgspec.json.encode({"tick": tick, **finite})
        writer.add_message(channel_id, time, data, time, sequence=tick & 0xFFFFFFFF)
    writer.finish()
    return out.getvalue()


FORMATS: dict[str, Callable[[Sequence[Channel], float, Block], bytes]] = {
    "csv": csv,
    "parquet": parquet,
    "mcap": mcap,
}
