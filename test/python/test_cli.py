import os
import tempfile
import unittest

import support  # noqa: F401  (makes the tools importable)

from slam_tools.cli import InputError, atomic_output


def read(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


class AtomicOutput(unittest.TestCase):
    def test_replaces_on_success(self):
        with tempfile.TemporaryDirectory() as folder:
            path = support.write(folder, "out", "old")
            with atomic_output(path) as temporary_path:
                support.write(folder, os.path.basename(temporary_path), "new")
                self.assertEqual(read(path), "old")
            self.assertEqual(read(path), "new")
            self.assertEqual(os.listdir(folder), ["out"])

    def test_leaves_the_old_file_and_nothing_else_on_failure(self):
        with tempfile.TemporaryDirectory() as folder:
            path = support.write(folder, "out", "old")
            with self.assertRaises(InputError):
                with atomic_output(path) as temporary_path:
                    support.write(folder, os.path.basename(temporary_path), "half")
                    raise InputError("stop")
            self.assertEqual(os.listdir(folder), ["out"])
            self.assertEqual(read(path), "old")


if __name__ == "__main__":
    unittest.main()
