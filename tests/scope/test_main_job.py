# SPDX-License-Identifier: Apache-2.0
"""make run SCOPE=1: the main job with a scope; the guide docs/tune_a_gain.md, step by step."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Awaitable, Callable
from pathlib import Path

import pytest

from asip_asm.project import ROOT
from tests.scope.page_link import LIMIT, Page, talk

CIRCLE = ROOT / "sim/paths/circle.ngc"
GUIDE = (ROOT / "docs/tune_a_gain.md").read_text(encoding="utf-8")


def job(out: Path, *arguments: str) -> list[str]:
    common = ["--platforms", "fpga3", "--no-plots", "--output", str(out)]
    return [sys.executable, "-m", "sim.bench.run", *arguments, *common]


def scoped_job(
    out: Path, act: Callable[[Page], Awaitable[None]], *arguments: str
) -> tuple[int, str]:
    """Exit status and output of the job; `act` has a page open while it runs."""
    process = subprocess.Popen(
        job(out, *arguments, "--scope"),
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    head = ""
    try:
        while not (found := re.search(r"scope: (http://127\.0\.0\.1:\S+/)", head)):
            line = process.stdout.readline()
            assert line, head
            head += line

        talk(found[1], act)
        rest, _ = process.communicate(timeout=LIMIT)
        return process.returncode, head + rest
    finally:
        process.kill()
        print(process.stdout.read() if not process.stdout.closed else "")  # of a failure


def test_main_job__only_watched__has_the_results_of_one_without_a_scope(tmp_path):
    async def act(page: Page) -> None:
        assert (await page.hear("state", lambda m: m["ended"]))["tick"] == 250

    status, text = scoped_job(tmp_path / "watched", act, str(CIRCLE), "--ticks", "250")
    assert status == 0, text
    alone = job(tmp_path / "alone", str(CIRCLE), "--ticks", "250")
    subprocess.run(alone, cwd=ROOT, check=True, capture_output=True)
    watched, alone = (
        json.loads((tmp_path / name / "results.json").read_text()) for name in ("watched", "alone")
    )
    del watched["simulation"], alone["simulation"]  # wall time, clock cycles of the extra reads
    assert watched == alone


def test_main_job__scope_without_the_asip__says_what_to_add(tmp_path):
    command = job(tmp_path, str(CIRCLE), "--ticks", "10", "--scope")
    command[command.index("fpga3")] = "fpga2"
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 1
    assert "error: the scope looks at the ASIP: add fpga3 to the platforms" in done.stderr


@pytest.mark.full
def test_guide__its_steps_in_order(tmp_path):
    """Numbers and names are those of the page; it hears what was done, nothing is compared."""
    command = re.search(r"^make run (.*)$", GUIDE, re.M)[1]
    assert dict(word.split("=") for word in command.split()) == {"SCOPE": "1", "PLATFORMS": "fpga3"}
    name, size, ticks = re.search(
        r"`(\w+)`, size `([\d.]+)`, for `(\d+)` ticks", " ".join(GUIDE.split())
    ).groups()
    gain, value = re.search(r"`(\w+)` to `([\d.]+)`", GUIDE).groups()
    seen: list[dict] = []

    async def act(page: Page) -> None:
        page.say(type="pace", paused=False, rate=2000)
        step = {"type": "step", "name": name, "amplitude": float(size), "ticks": int(ticks)}
        page.say(**step)
        await page.hear("state", lambda m: len(m["responses"]) == 1)
        page.say(type="pace", paused=True, rate=2000)
        page.say(type="stage", name=gain, value=float(value))
        await page.hear("state", lambda m: m["staged"] == {gain: float(value)})
        page.say(type="commit")
        await page.hear("state", lambda m: m["version"] == 1 and m["gains"][gain] == float(value))
        page.say(type="pace", paused=False, rate=2000)
        page.say(**step)
        seen.extend((await page.hear("state", lambda m: len(m["responses"]) == 2))["responses"])

    status, text = scoped_job(tmp_path, act, str(CIRCLE), "--ticks", "8000")
    first, second = (response["figures"] for response in seen)
    assert second["rise"] < 0.8 * first["rise"]  # as the page says
    assert status == 0
    said = re.findall(r"```text\n(.*?)```", GUIDE, re.S)[-1].strip().splitlines()
    told = [re.sub(r"tick \d+", "tick N", line.strip()) for line in text.splitlines()]
    for line in said:
        assert re.sub(r"tick \d+", "tick N", line.strip()) in told, line
    assert not (tmp_path / "results.json").exists()


@pytest.mark.parametrize(
    "word", [word for word in re.findall(r"\*\*([^*]+)\*\*", GUIDE) if not word[0].isdigit()]
)
def test_guide__what_it_points_at__is_on_the_page(word):
    folder = ROOT / "sim/debug/scope/page"
    page = "".join(file.read_text(encoding="utf-8") for file in folder.iterdir())
    assert word in page
