"""Runs the package's programs, of the build or of one with sanitizers."""
import os
import re
import subprocess

from node_process import ROOT, executable
from row import Row, number


def build_folder(sanitizer, quick):
    """The build with that sanitizer ("address", "thread"), made if need be; --quick does without: None."""
    if quick:
        return None
    folder = os.path.join(ROOT, "build", sanitizer)
    subprocess.run([os.path.join(ROOT, "scripts", "build_sanitized.sh"), sanitizer], check=True, stdout=subprocess.DEVNULL)
    return folder


def run(program, *arguments, build=None, **variables):
    """The program's exit code, negative for a signal, and what it wrote."""
    path = [os.path.join(build, "devel", "env.sh"), program] if build else [executable(program)]
    done = subprocess.run([*path, *arguments], cwd=ROOT, env=dict(os.environ, **variables), check=False, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True, errors="replace")
    return done.returncode, done.stdout


def fuzz(fault, how_many, must_hold, program, tests, rounds, build):
    """The row of a fuzz target's tests, of that build (None: the ordinary one); `how_many` says what {} rounds are."""
    if build is None:  # the fuzz targets are tests, which scripts/build.sh leaves out
        subprocess.run(["cmake", "--build", os.path.join(ROOT, "build"), "--target", program], check=True, stdout=subprocess.DEVNULL)
    code, text = run(program, "--gtest_filter=" + tests, build=build, FUZZ_ROUNDS=str(rounds), ASAN_OPTIONS="detect_leaks=0",
                     UBSAN_OPTIONS="print_stacktrace=1")
    holds = code == 0 and "[  PASSED  ]" in text
    result = "AddressSanitizer and UndefinedBehaviorSanitizer silent" if build else "they hold, without sanitizers"
    if not holds:
        faults = re.findall(r"^.*(?:ERROR: AddressSanitizer|runtime error|Failure).*$", text, re.MULTILINE)
        result = f"exit code {code}; " + " ".join((faults or text.splitlines() or ["no output"])[0].split())
        if len(faults) > 1:
            result += f" (the first of {number(len(faults))})"
    return Row(fault, how_many.format(number(rounds)), must_hold, result, holds)
