# SPDX-License-Identifier: Apache-2.0
"""Work on bytes that a stranger may have written, in a child process that can do nothing else.

The child computes and writes to one pipe. The kernel (seccomp) ends it at an attempt to start a
program or a process, or to open a connection, and refuses every other system call that is not in
`CALLS`: no file can be opened, no page becomes executable, so no library can be loaded. Processor
time and memory have limits.
"""

from __future__ import annotations

import contextlib
import errno
import os
import resource
import signal
from collections.abc import Callable
from pathlib import Path

CALLS = (
    "brk clock_gettime clock_nanosleep close exit exit_group fstat futex getcpu getpid "
    "getrandom gettid gettimeofday lseek madvise membarrier mremap munmap "
    "nanosleep pread64 prctl read restart_syscall rseq rt_sigaction rt_sigprocmask rt_sigreturn "
    "sched_getaffinity sched_yield set_robust_list sigaltstack sysinfo uname write writev"
).split()
ENDED = (
    "execve execveat fork vfork clone clone3 socket socketpair connect bind ptrace "
    "process_vm_readv process_vm_writev kill tkill io_uring_setup bpf memfd_create"
).split()
"""Calls that end the child, so that the parent can say what the work tried."""
PROT_EXEC = 4
MAPPING = ("mmap", "mprotect")
"""Calls whose third argument must not make a page executable."""
SECONDS = 5
"""Processor time of a piece of work."""
BYTES = 1 << 29
"""Memory beyond what the process has."""
ANSWER = 1 << 28
"""Bytes of an answer at most."""
SAID = 400
"""Characters of an error's text."""


class Confined(RuntimeError):
    """The work failed, or was ended; the text says why."""


def confined(work: Callable[[], bytes], seconds: int = SECONDS, memory: int = BYTES) -> bytes:
    """Answer of `work`, run in a confined child. Raises Confined with the text of what it raised,
    or of the limit that it met.

    Everything that the work imports must be imported already.
    """
    seccomp = _seccomp()
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        _child(seccomp, work, seconds, memory, writer)
    os.close(writer)
    with os.fdopen(reader, "rb") as pipe:
        answer = pipe.read(ANSWER + 1)
    status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    if status == -signal.SIGSYS:
        raise Confined("tried to start a program or a process, or to open a connection")
    if status in (-signal.SIGXCPU, -signal.SIGKILL):
        raise Confined(f"takes more than {seconds} s of processor time")
    if len(answer) > ANSWER:
        raise Confined(f"gives more than {ANSWER >> 20} MiB")
    if status or not answer:
        raise Confined("damaged")
    if answer[:1] == b"!":
        raise Confined(answer[1:].decode(errors="replace") or "damaged")
    return answer[1:]


def _seccomp():
    """The package, loaded in the parent: the child cannot. Raises Confined."""
    try:
        import pyseccomp
    except (ImportError, RuntimeError, OSError) as error:
        raise Confined(
            f"cannot be opened safely here: {error}; install libseccomp (Debian: libseccomp2) and "
            "pip install 'microtick[model]'"
        ) from None
    return pyseccomp


def restrict(seccomp) -> None:
    """Leave this process the calls of `CALLS` alone, for good."""
    rules = seccomp.SyscallFilter(seccomp.ERRNO(errno.EPERM))
    for names, action in ((CALLS, seccomp.ALLOW), (ENDED, seccomp.KILL_PROCESS)):
        for name in names:
            if _known(seccomp, name):
                rules.add_rule(action, name)
    for name in MAPPING:
        rules.add_rule(seccomp.ALLOW, name, seccomp.Arg(2, seccomp.MASKED_EQ, PROT_EXEC, 0))
    rules.load()


def _known(seccomp, name: str) -> bool:
    """Whether this machine's libseccomp knows the call."""
    try:
        return seccomp.resolve_syscall(seccomp.Arch.NATIVE, name) != -1
    except ValueError:
        return False


def _child(seccomp, work, seconds: int, memory: int, writer: int) -> None:
    """Limits, filter, work; never returns."""
    text, failed = b"", True
    try:
        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
        _limit(resource.RLIMIT_AS, pages * resource.getpagesize() + memory)
        _limit(resource.RLIMIT_CPU, seconds)
        _limit(resource.RLIMIT_CORE, 0)
        signal.signal(signal.SIGXCPU, signal.SIG_DFL)
        _leave_only(writer)
        restrict(seccomp)
        text = work()
        failed = False
    except BaseException as error:  # damaged bytes raise errors of many kinds
        lines = str(error).strip().splitlines()
        text = (lines[-1] if lines else type(error).__name__)[:SAID].encode(errors="replace")
    finally:
        try:
            data = memoryview((b"!" if failed else b"=") + text)
            while data:
                data = data[os.write(writer, data) :]
        finally:
            os._exit(0)


def _leave_only(writer: int) -> None:
    """Close every other descriptor; what the work prints goes nowhere."""
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in range(3):
        os.dup2(nowhere, stream)
    for name in os.listdir("/proc/self/fd"):
        if int(name) > 2 and int(name) != writer:
            with contextlib.suppress(OSError):  # the listing's own descriptor
                os.close(int(name))


def _limit(which: int, value: int) -> None:
    _, hard = resource.getrlimit(which)
    most = value if hard == resource.RLIM_INFINITY else min(value, hard)
    resource.setrlimit(which, (most, hard if hard != resource.RLIM_INFINITY else most))
