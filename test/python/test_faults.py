"""scripts/faults.py: the table of faults."""
import json
import os
import subprocess
import tempfile
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.realpath(__file__))))


def quick_rows(*names):
    """({name: row as JSON}, what was printed) of these rows, few of each; fails when one does not hold."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "rows.json")
        done = subprocess.run([os.path.join(ROOT, "scripts", "faults.py"), "--quick", "--only", *names, "--json", path],
                              check=False, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=120)
        assert done.returncode == 0, done.stdout + done.stderr
        with open(path, encoding="utf-8") as file:
            return json.load(file), done.stdout


class Faults(unittest.TestCase):
    def test_a_node_that_is_killed_while_it_saves_leaves_a_whole_map(self):
        rows, printed = quick_rows("kill")
        self.assertEqual(rows["kill"]["result"], "3 files whole, 3 resumed, 0 parts of files")
        self.assertIn(rows["kill"]["result"], printed)

    def test_sensors_clocks_and_transforms_that_fail_are_survived(self):
        names = ("clock", "transforms", "dropouts")
        rows, _ = quick_rows(*names)
        self.assertEqual(list(rows), list(name for name in rows if rows[name]["holds"]))
        self.assertCountEqual(rows, names)


if __name__ == "__main__":
    unittest.main()
