# SPDX-License-Identifier: Apache-2.0
"""A cocotb simulation with the Verilator of the environment, its assertions and, on wish, waves.

It also works where the project's path has spaces: files go through `sim.harness.plain.plain`.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any
from unittest.mock import patch

import cocotb_tools.config
from cocotb_tools.runner import get_runner

from sim.harness import waves
from sim.harness.assertions import assertions_of
from sim.harness.build import verilator_driver
from sim.harness.plain import plain, workshop
from tests.bench.self_running import linked

FLAGS = ["--x-initial", "unique", "--x-assign", "unique", "--assert", "-Wno-fatal"]
RUNTIME = ("verilated", "verilated_threads", "verilated_dpi", "verilated_vpi")


class Simulation:
    """Module `top` Verilated in `folder`, or with WAVES=1 in a folder beside it.

    `sources` are in compile order; the assertions of their modules are added. Raises RuntimeError
    with the end of the log if the build fails.
    """

    def __init__(
        self,
        top: str,
        sources: Sequence[Path],
        folder: Path,
        parameters: Mapping[str, int] | None = None,
        flags: Sequence[str] = (),
    ) -> None:
        traced = waves.wanted()
        self.top = top
        self.folder = folder.with_name(f"{folder.name}_waves") if traced else folder
        self.folder.mkdir(parents=True, exist_ok=True)
        self.log = self.folder / "log.txt"
        os.environ["PATH"] = os.pathsep.join((str(verilator_driver().parent), os.environ["PATH"]))
        for name in ("share_dir", "libs_dir"):  # go into makefiles
            setattr(cocotb_tools.config, name, plain(Path(getattr(cocotb_tools.config, name))))
        self.runner = get_runner("verilator")
        objects, variables = linked(*RUNTIME)
        try:
            with patch.dict(os.environ, GNUMAKEFLAGS=variables):
                self.runner.build(
                    sources=[plain(path) for path in (*sources, *assertions_of(sources))],
                    hdl_toplevel=top,
                    parameters=dict(parameters or {}),
                    build_dir=workshop(self.folder),
                    build_args=[*FLAGS, *flags, *objects, *waves.flags()],
                    waves=traced,
                    log_file=self.log,
                )
        except RuntimeError as error:
            raise RuntimeError(f"building {top} failed:\n{self.log.read_text()[-3000:]}") from error

    def run(self, module: str, environment: Mapping[str, str], **options: Any) -> Path:
        """Run cocotb tests of a Python module; returns the results. `options` go to cocotb.

        Raises AssertionError with the end of the log if the simulator fails.
        """
        results = self.folder / "results.xml"
        if waves.wanted():
            arguments = ["--trace-file", str(waves.new_file(self.top))]
            options |= {"waves": True, "test_args": arguments}
        try:
            self.runner.test(
                test_module=module,
                hdl_toplevel=self.top,
                build_dir=workshop(self.folder),
                test_dir=self.folder,
                results_xml=str(results),
                extra_env=dict(environment),
                log_file=self.log,
                **options,
            )
        except (RuntimeError, SystemExit) as error:
            text = f"{error}\n{self.top}, {module}:\n{self.log.read_text()[-3000:]}"
            raise AssertionError(text) from error
        return results
