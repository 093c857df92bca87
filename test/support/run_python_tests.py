#!/usr/bin/python3
"""Runs the unittests of a folder and writes a JUnit file: run_python_tests.py FOLDER RESULTS.xml"""
import os
import sys
import time
import unittest
from xml.sax.saxutils import quoteattr


class RecordingResult(unittest.TextTestResult):
    """Keeps one line of XML a test."""

    def __init__(self, *arguments, **options):
        super().__init__(*arguments, **options)
        self.cases = []
        self.started = 0.0

    def startTest(self, test):
        self.started = time.monotonic()
        super().startTest(test)

    def record(self, test, inside=""):
        seconds = time.monotonic() - self.started
        self.cases.append(f"<testcase classname='python' name={quoteattr(test.id())} time='{seconds:.3f}'>{inside}</testcase>")

    def addSuccess(self, test):
        super().addSuccess(test)
        self.record(test)

    def addFailure(self, test, err):
        super().addFailure(test, err)
        self.record(test, "<failure/>")

    def addError(self, test, err):
        super().addError(test, err)
        self.record(test, "<error/>")

    def addSkip(self, test, reason):
        super().addSkip(test, reason)
        print(f"skipped: {test.id()}: {reason}")
        self.record(test, "<skipped/>")

    def addSubTest(self, test, subtest, err):
        super().addSubTest(test, subtest, err)
        if err is not None:
            self.record(subtest, "<failure/>")


def main():
    folder, results = sys.argv[1:]
    sys.path.insert(0, os.getcwd())
    suite = unittest.defaultTestLoader.discover(folder)
    result = unittest.TextTestRunner(resultclass=RecordingResult, verbosity=0, stream=sys.stdout).run(suite)
    os.makedirs(os.path.dirname(results), exist_ok=True)
    with open(results, "w", encoding="utf-8") as file:
        file.write("<testsuite name='python'>" + "".join(result.cases) + "</testsuite>\n")
    return 0 if result.wasSuccessful() else 1


if __name__ == "__main__":
    sys.exit(main())
