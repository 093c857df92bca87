"""scripts/faults.py: the table of faults."""
import json
import os
import subprocess
import tempfile
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.realpath(__file__))))


class Faults(unittest.TestCase):
    def test_a_node_that_is_killed_while_it_saves_leaves_a_whole_map(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "rows.json")
            done = subprocess.run([os.path.join(ROOT, "scripts", "faults.py"), "--quick", "--only", "kill", "--json", path],
                                  check=False, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=120)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            with open(path, encoding="utf-8") as file:
                row = json.load(file)["kill"]
        self.assertTrue(row["holds"])
        self.assertEqual(row["result"], "3 files whole, 3 resumed, 0 parts of files")
        self.assertIn(row["result"], done.stdout)


if __name__ == "__main__":
    unittest.main()
