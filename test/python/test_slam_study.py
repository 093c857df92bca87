import json
import os
import subprocess
import tempfile
import unittest

import support

from slam_tools.environment import executable


def run_study(folder, *arguments):
    return subprocess.run([executable("slam_study"), *arguments], cwd=folder, stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, universal_newlines=True, check=False, timeout=60)


class SlamStudy(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = temporary.name

    def test_finds_the_default_world_from_any_folder(self):
        process = run_study(self.folder, "room", "--seeds", "2", "--json", "figures.json")
        self.assertEqual(process.returncode, 0, process.stderr)
        self.assertEqual(os.listdir(self.folder), ["figures.json"])
        with open(os.path.join(self.folder, "figures.json"), encoding="utf-8") as file:
            json.load(file)

    def test_refuses_a_place_that_it_cannot_write_to_before_the_run(self):
        """A million runs would take longer than the time that is given."""
        for study in ("room", "chain", "robustness", "consistency", "global"):
            for path, expected in (("none/figures.json", "none/figures.json: cannot be created: No such file"),
                                   (".", "cannot be written: Is a directory"), ("", "empty name")):
                process = run_study(self.folder, study, "--seeds", "1000000", "--json", path)
                support.assert_one_line_error(self, process, "slam_study: ", expected)
        self.assertEqual(os.listdir(self.folder), [])


if __name__ == "__main__":
    unittest.main()
