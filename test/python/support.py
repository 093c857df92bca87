"""What the tests of the offline tools share."""
import math
import os
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.realpath(__file__))))
SCRIPTS = os.path.join(ROOT, "scripts")
sys.path.insert(0, SCRIPTS)

SLAM_DATA = os.environ.get("SLAM_DATA", os.path.join(ROOT, "..", "shared", "data"))


def data(*parts):
    """A path in the folder of real data, or None when it is not there."""
    path = os.path.join(SLAM_DATA, *parts)
    return path if os.path.exists(path) else None


def run_script(name, *arguments):
    """The finished process of a script, with its output as text."""
    command = [sys.executable, os.path.join(SCRIPTS, name)] + [str(argument) for argument in arguments]
    return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True,
                          check=False)


def assert_one_line_error(test, process, *expected_parts):
    """The script said what is wrong in one line and ended with exit code 2."""
    test.assertEqual(process.returncode, 2, process.stderr)
    test.assertEqual(process.stderr.count("\n"), 1, process.stderr)
    for part in expected_parts:
        test.assertIn(part, process.stderr)


def write(folder, name, text):
    path = os.path.join(folder, name)
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)
    return path


def tum_line(stamp, x, y, yaw):
    return f"{stamp:.9f} {x:.12f} {y:.12f} 0 0 0 {math.sin(yaw / 2):.15f} {math.cos(yaw / 2):.15f}\n"
