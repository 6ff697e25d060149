# SPDX-License-Identifier: Apache-2.0
"""Built files: what they depend on, damage that is found, folders that only their owner enters."""

from __future__ import annotations

import ctypes
import os
import random
import shutil
import subprocess
from pathlib import Path

import pytest

from sim.report import provenance
from sim.rtl import build, plain, runtime
from sim.rtl.sources import sources_of
from tests.bench.seed import SEED
from tests.security.campaign_caches import damaged


@pytest.fixture
def models(monkeypatch, tmp_path):
    """The folder of built files, empty."""
    monkeypatch.setattr(runtime, "MODELS", tmp_path / "model")
    return tmp_path / "model"


def test_key__names_compiler_processor_and_verilator(monkeypatch, tmp_path):
    def key() -> str:
        runtime.toolchain.cache_clear()
        return runtime.toolchain()

    found = {key()}
    compiler = tmp_path / "g++"
    compiler.write_text("#!/bin/sh\necho 'g++ 99'\n")
    compiler.chmod(0o755)
    monkeypatch.setenv("CXX", str(compiler))
    found.add(key())
    compiler.write_text("#!/bin/sh\necho 'g++ 100'\n")
    found.add(key())
    processor = tmp_path / "cpuinfo"
    processor.write_text("processor : 0\nflags : fpu sse2\n")
    monkeypatch.setattr(runtime, "CPU", processor)
    found.add(key())
    monkeypatch.setattr(runtime, "version", lambda name: "0.0")
    found.add(key())
    runtime.toolchain.cache_clear()
    assert len(found) == 5


def test_damaged_model__is_built_again_with_a_message(models, tmp_path, capfd, monkeypatch):
    """The compiler's part is a copy: what is tested is what happens to a file that is damaged."""
    whole = tmp_path / "whole.so"
    source = tmp_path / "x.cpp"
    source.write_text('extern "C" int answer() { return 42; }\n')
    subprocess.run(["g++", "-shared", "-fPIC", source, "-o", whole], check=True)
    built = []

    def compile_(library, harness, flags, jobs, folder) -> None:
        built.append(library)
        shutil.copy(whole, folder / library)

    monkeypatch.setattr(build, "_verilate", lambda *arguments: None)
    monkeypatch.setattr(build, "_compile", compile_)

    def library() -> Path:
        return build.build_library("fp_cmp", sources_of("fp_cmp"), source)

    file, rng = library(), random.Random(SEED)
    assert library() == file and len(built) == 1
    data = file.read_bytes()
    for n in range(100):
        file.write_bytes(damaged(data, rng))
        assert library() == file and len(built) == n + 2, f"seed {SEED}, damage {n}"
        assert f"{file} is damaged; it is built again" in capfd.readouterr().err
        assert file.read_bytes() == data
    assert ctypes.CDLL(str(file)).answer() == 42


def test_workshop__of_another_user_or_open_to_others_is_refused(monkeypatch, tmp_path):
    monkeypatch.setattr(plain.tempfile, "gettempdir", lambda: str(tmp_path))
    odd = tmp_path / "an odd name"
    (odd / "build").mkdir(parents=True)
    monkeypatch.setattr(plain, "ROOT", odd)
    monkeypatch.setattr(plain, "BUILD", odd / "build")
    shop = plain.workshop(odd / "build/x")
    base = shop.parent
    assert shop.is_dir() and base.stat().st_mode & 0o777 == 0o700
    base.chmod(0o777)
    with pytest.raises(OSError, match="other users may write into it"):
        plain.workshop(odd / "build/x")
    base.chmod(0o700)
    if os.getuid() == 0:
        os.chown(base, 12345, 12345)
        with pytest.raises(OSError, match="belongs to the user 12345"):
            plain.workshop(odd / "build/x")


def test_provenance__below_another_repository_is_unknown(monkeypatch, tmp_path):
    git = ["git", "-c", "user.name=x", "-c", "user.email=x@x", "-C", tmp_path]
    (tmp_path / "inner").mkdir()
    (tmp_path / "inner/core.sv").write_text("one")
    for command in (["init", "-q"], ["add", "."], ["commit", "-q", "-m", "x"]):
        subprocess.run([*git, *command], check=True)
    monkeypatch.setattr(provenance, "ROOT", tmp_path)
    assert not provenance.commit().startswith("unknown")
    monkeypatch.setattr(provenance, "ROOT", tmp_path / "inner")
    assert provenance.commit() == provenance.UNKNOWN
