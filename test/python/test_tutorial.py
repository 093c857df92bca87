"""The commands of docs/tutorial.md that are marked as tested do what it says."""
import os
import re
import subprocess
import tempfile
import unittest

from support import ROOT


class Tutorial(unittest.TestCase):
    def test_its_commands_work_one_after_the_other(self):
        with open(os.path.join(ROOT, "docs", "tutorial.md"), encoding="utf-8") as file:
            blocks = re.findall(r"<!-- tested -->\n```\n(.*?)```", file.read(), flags=re.DOTALL)
        self.assertEqual(len(blocks), 4)
        with tempfile.TemporaryDirectory() as folder:
            os.symlink(os.path.join(ROOT, "config"), os.path.join(folder, "config"))
            process = subprocess.run(["bash", "-euo", "pipefail", "-c", "".join(blocks)], cwd=folder, text=True,
                                     stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
            self.assertEqual(process.returncode, 0, process.stdout)
            for name in ("runs/first/report.html", "runs/first/map.yaml", "runs/comparison.png", "runs/localized/evaluation.json"):
                self.assertTrue(os.path.isfile(os.path.join(folder, name)), name)
        self.assertEqual(re.findall(r"missed +(\d+)", process.stdout), ["0", "0"])


if __name__ == "__main__":
    unittest.main()
