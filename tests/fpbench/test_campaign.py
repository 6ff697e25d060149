# SPDX-License-Identifier: Apache-2.0
"""Command line, campaign and report: resuming, fingerprints, texts; and the whole campaign."""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path

import pytest

from sim.core.fpbench import campaign, native, plan, report
from sim.core.fpbench.__main__ import main, size
from sim.core.fpbench.native import BenchError, fingerprint
from sim.core.fpbench.plan import Part, Shard
from sim.report import cache
from sim.report.marks import MarksError
from sim.report.provenance import commit
from tests.bench.commands import output
from tests.bench.copies import edited_folder

BEGIN, END = "<!-- campaign: written by x -->", "<!-- end of campaign -->"
ANGLES = {"in_range": 4, "worst": 0.3, "worst_at": 0x3F800000, "not_nearest": 1, "beyond": 3}
ANGLES |= {"symmetric_pairs": 2, "reference_error": 1e-10, "histogram": [1] + 63 * [0] + [3]}
ROW = {"section": "s", "what": "w", "op": "add", "planned": 10, "covered": 5, "cases": 4}
ROW |= {"mismatches": 0, "seconds": 1e-6}
NOTHING = {"covered": 0, "cases": 0, "seconds": 0.0}
DATA = {"angles": {"sin": ANGLES}, "processor": "p", "seed": 1}
SHARDS = [
    Shard("add", "random", start, 50_000, 5, False, "fp_add") for start in (0, 50_000, 100_000)
]


def test_campaign__stopped_after_a_shard__goes_on_with_the_others(tmp_path: Path) -> None:
    tasks = [campaign.task_of(shard, tmp_path) for shard in SHARDS]
    cache.save(tasks[0], campaign.execute(tasks[0]))
    assert [cache.load(task) is not None for task in tasks] == [True, False, False]
    left = [task for task in tasks if cache.load(task) is None]
    assert left == tasks[1:]
    seen, failed = [], []
    campaign.run(left, lambda t, r: seen.append(r), lambda t, e: failed.append(e), jobs=1)
    assert not failed and [r["cases"] for r in seen] == [50_000, 50_000]
    assert all(cache.load(task)["mismatches"] == 0 for task in tasks)


def test_campaign__scheduler_given__runs_there_and_failures_do_not_stop_it(tmp_path: Path) -> None:
    from dask.distributed import LocalCluster

    task = campaign.task_of(SHARDS[0], tmp_path)
    stale = campaign.Task(SHARDS[1], task.unit, "0123456789abcdef", tmp_path / "stale.json")
    seen, failed = [], []
    with LocalCluster(
        n_workers=1, threads_per_worker=1, dashboard_address="127.0.0.1:0"
    ) as cluster:
        campaign.run(
            [stale, task],
            lambda t, r: seen.append(t),
            lambda t, text: failed.append(text),
            scheduler=cluster.scheduler_address,
        )
    assert seen == [task] and "its sources changed" in failed[0]
    assert cache.load(stale) is None


@pytest.mark.full
def test_campaign__no_scheduler_at_the_address__says_so(tmp_path: Path) -> None:
    task = campaign.task_of(SHARDS[0], tmp_path)
    with pytest.raises(BenchError, match="no Dask scheduler at tcp://127.0.0.1:9: "):
        campaign.run([task], print, print, scheduler="tcp://127.0.0.1:9")


def test_campaign__sources_changed_meanwhile__shard_is_refused_with_the_reason(
    tmp_path: Path,
) -> None:
    task = campaign.task_of(SHARDS[0], tmp_path)
    stale = campaign.Task(task.shard, task.unit, "0123456789abcdef", task.path)
    with pytest.raises(BenchError, match="fp_add: its sources changed after the campaign began"):
        campaign.execute(stale)


def test_fingerprint__own_rtl_and_latency_count__another_units_latency_does_not(
    tmp_path: Path,
) -> None:
    def changed(file: str, pattern: str, replacement: str) -> str:
        copy = edited_folder(native.RTL, tmp_path / "fpu", file, pattern, replacement)
        return fingerprint("fp_mul", copy)

    assert changed("fp_pkg.sv", r"(FP_ADD_LATENCY = )\d+", r"\g<1>99") == fingerprint("fp_mul")
    others = [
        changed("fp_pkg.sv", r"(FP_MUL_LATENCY = )\d+", r"\g<1>99"),
        changed("fp_pkg.sv", r"CANON_NAN = 32'h7fc0", "CANON_NAN = 32'hffc0"),
        changed("fp_round.sv", r"endmodule", "// changed\nendmodule"),
        changed("fp_mul.sv", r"endmodule", "// changed\nendmodule"),
    ]
    assert fingerprint("fp_mul") not in others and len(set(others)) == len(others)


def test_plan__shards_of_a_part__cover_it_once() -> None:
    part = Part("sqrt", "exhaustive", 0, plan.EVERY_WORD)
    shards = list(part.shards())
    assert sum(shard.count for shard in shards) == plan.EVERY_WORD
    ends = [shard.start + shard.count for shard in shards]
    assert [shard.start for shard in shards] == [0, *ends[:-1]]
    assert len({shard.name for shard in shards}) == len(shards)


def test_plan__all_sections__every_operation_and_more_than_a_billion_random_cases() -> None:
    sections = plan.sections(size)
    default = [part for section in plan.chosen(sections, [], False) for part in section.parts]
    assert {part.op for part in default} == set(native.operations())
    assert sum(part.count for part in default if part.kind == "random") >= 10**9
    angles = sorted(
        (part.start, part.start + part.count)
        for section in sections
        for part in section.parts
        if part.op == "sin" and part.kind == "exhaustive" and not part.instead
    )
    assert angles[0][0] == 0 and angles[-1][1] == plan.EVERY_WORD
    assert all(end == start for (_, end), (start, _) in zip(angles, angles[1:], strict=False))


def test_report__rows_and_angles__shown_in_the_page(tmp_path: Path) -> None:
    missing = ROW | NOTHING | {"section": "t"}
    page = tmp_path / "page.md"
    page.write_text(f"before\n{BEGIN}\nold\n{END}\nafter\n")
    data = DATA | {"rows": [ROW, missing]}
    report.update_page(data, page)
    text = page.read_text()
    here = commit()
    assert f"| s | w | `add` | 4 | 0 | 50.0 % | 4.00 | {here} |" in text
    assert "| t | w | `add` | 0 | not run | 0.0 % | - | - |" in text
    assert "| `sin` | 4 | 0.300000 ulp | 3f800000 (1.0 rad) | 1 | 2 | 3 | 1.0e-10 ulp |" in text
    assert "| `sin` | 25.0000 | 0.0000 |" in text and " 0.0000 | 75.0000 |" in text
    assert "old" not in text and text.startswith("before") and text.endswith("after\n")
    page.write_text("no marks")
    with pytest.raises(MarksError, match="0 pairs of marks `<!-- campaign"):
        report.update_page(data, page)


def test_report__sections_without_results__keep_their_lines(tmp_path: Path) -> None:
    later = ROW | {"section": "t", "what": "new", "cases": 7}
    page = tmp_path / "page.md"
    page.write_text(f"{BEGIN}\n{END}\n")
    data = DATA | {"rows": [ROW, later]}
    report.update_page(data, page)
    lines = page.read_text().splitlines()
    data |= {"rows": [ROW | NOTHING, later | {"cases": 8}], "angles": {"cos": ANGLES}}
    report.update_page(data, page)
    after = page.read_text().splitlines()
    assert [line for line in lines if line not in after] == [
        line for line in lines if line.startswith("| t |")
    ]
    assert sum(line.startswith("| `cos` |") for line in after) == 2
    report.update_page(data, page)
    assert page.read_text().splitlines() == after


def test_case__directed_pair__shows_operands_flags_and_verdict(capsys) -> None:
    assert main(["case", "mul", "00ffffff", "3f000000"]) == 0
    said = capsys.readouterr().out
    assert re.search(r"got   00800000 .* flags uf nx", said)
    assert re.search(r"want  00800000 .* flags uf nx", said)
    assert said.rstrip().endswith("PASS")


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["case", "mul", "1"], "operation 'mul' takes 2 operands (A B), not 1"),
        (["case", "power", "1"], "no operation 'power'; known are add, sub"),
        (["campaign", "--section", "roots"], "no section 'roots'; known are sign"),
    ],
)
def test_command__user_error__one_line_with_the_cure(capsys, words: list[str], text: str) -> None:
    assert main(words) == 1
    assert capsys.readouterr().err.startswith(f"fpbench: error: {text}")


def test_case__word_that_is_none__usage_error(capsys) -> None:
    with pytest.raises(SystemExit) as stopped:
        main(["case", "mul", "123456789", "0"])
    assert stopped.value.code == 2
    assert "'123456789' is not a word of up to 8 hexadecimal digits" in capsys.readouterr().err


@pytest.mark.full
def test_campaign__everything_but_the_extended_sections__no_mismatch() -> None:
    jobs = os.environ.get("JOBS", "2")
    output(sys.executable, "-m", "sim.core.fpbench", "campaign", "--jobs", jobs, cwd=native.ROOT)
