import json
import os
import shutil
import unittest

import support
from straight_run import StraightRun

from slam_tools.comparison import ComparedRun, differing_parameters, short_names
from slam_tools.provenance import Provenance


def run_with(parameters):
    return ComparedRun("", "", None, Provenance({}, parameters), None)


class Naming(unittest.TestCase):
    def test_the_shortest_ends_that_tell_runs_apart(self):
        self.assertEqual(short_names(["/a/ekf", "/a/ukf/"]), ["ekf", "ukf"])
        self.assertEqual(short_names(["/a/ekf/1", "/a/ukf/1", "/a/ukf/2"]), ["ekf/1", "ukf/1", "2"])
        self.assertEqual(short_names(["/x/run", "/run"]), ["x/run", "run"])


class Differences(unittest.TestCase):
    def test_only_what_is_not_alike(self):
        runs = [run_with({"a/x": "1.0", "a/y": "1", "a/z": "q"}), run_with({"a/x": "1", "a/y": "2"}), run_with(None)]
        self.assertEqual(differing_parameters(runs), {"a/y": ["1", "2", None], "a/z": ["q", None, None]})
        self.assertEqual(differing_parameters([run_with(None), run_with(None)]), {})


class Comparing(StraightRun):
    def setUp(self):
        super().setUp()
        self.top = os.path.dirname(self.folder)
        self.other = os.path.join(self.top, "other")
        shutil.copytree(self.folder, self.other)
        os.remove(os.path.join(self.other, "trajectory_covariance.csv"))
        shutil.copy(os.path.join(self.folder, "dead_reckoning.tum"), os.path.join(self.other, "trajectory.tum"))
        support.write(self.folder, "summary.json", json.dumps({"update_ms_mean": 0.25, "cpu_seconds": 1234.5}))
        support.write(self.folder, "parameters.yaml", "estimator: {type: ekf, seed: 1}\n")
        support.write(self.other, "parameters.yaml", "estimator: {type: ukf, seed: 1.0}\n")
        self.picture = os.path.join(self.top, "picture.png")
        self.json = os.path.join(self.top, "figures.json")

    def compare(self, *arguments):
        return support.run_script("compare.py", *arguments, "--truth", self.bag, "--picture", self.picture)

    def test_figures_are_those_of_evaluate(self):
        process = self.compare(self.folder, self.other, "--json", self.json)
        self.assertEqual(process.returncode, 0, process.stderr)
        with open(self.json, encoding="utf-8") as file:
            comparison = json.load(file, parse_constant=self.fail)
        self.assertEqual(support.run_script("evaluate.py", self.folder, "--truth", self.bag).returncode, 0)
        with open(os.path.join(self.folder, "evaluation.json"), encoding="utf-8") as file:
            evaluation = json.load(file)
        self.assertEqual(comparison["align"], evaluation.pop("align"))
        first, second = comparison["runs"]
        self.assertEqual({name: first[name] for name in evaluation}, evaluation)
        self.assertEqual((first["name"], second["name"]), ("run", "other"))
        self.assertAlmostEqual(second["ate_rmse_m"], 0.4, places=6)
        self.assertIsNone(second["pose_nees_start_mean"])
        self.assertEqual(first["parameters_that_differ"], {"estimator/type": "ekf"})
        self.assertEqual(first["update_ms_mean"], 0.25)
        self.assertIsNone(second["update_ms_mean"])

        lines = process.stdout.splitlines()
        self.assertEqual(lines[1].split()[:2], ["run", "0.100"])
        self.assertEqual(lines[1].split()[-2:], ["0.25", "1234"])
        self.assertEqual(lines[2].split()[:2], ["other", "0.400"])
        self.assertIn("dead reckoning: path ATE 0.400 m", lines)
        self.assertIn(["estimator/type", "ekf", "ukf"], [line.split() for line in lines])
        self.assertNotIn("estimator/seed", process.stdout)
        self.assertGreater(os.path.getsize(self.picture), 20000)

    def test_truth_of_landmarks_alone_names_and_spaces(self):
        """In space the straight path cannot be aligned; there is no true path anyway."""
        self.write_truth(with_path=False)
        process = self.compare(self.folder, self.other, "--align", "se3", "--name", "A b", "--name", "<C>")
        self.assertEqual(process.returncode, 0, process.stderr)
        self.assertTrue(process.stdout.splitlines()[1].startswith("A b  "), process.stdout)
        self.assertGreater(os.path.getsize(self.picture), 10000)

    def test_bad_input_is_one_line_and_leaves_nothing_behind(self):
        before = sorted(os.listdir(self.top))
        missing = os.path.join(self.top, "missing")
        for arguments, expected in [
                ((self.folder,), ("two or more",)),
                ((self.folder, self.other, self.folder + "/."), ("given twice",)),
                ((self.folder, missing), ("missing", "no such folder")),
                ((self.folder, self.other, "--name", "one"), ("--name", "2 different")),
                ((self.folder, self.other, "--name", "one", "--name", "one"), ("--name", "2 different")),
                ((self.folder, self.other, "--json", os.path.join(missing, "x")), ("does not exist",)),
                ((self.folder, self.other, "--picture", os.path.join(missing, "x")), ("does not exist",)),
                ((self.folder, self.other, "--truth", missing), ("missing", "No such file"))]:
            process = support.run_script("compare.py", "--truth", self.bag, "--picture", self.picture, *arguments)
            support.assert_one_line_error(self, process, *expected)
            self.assertEqual(sorted(os.listdir(self.top)), before)


if __name__ == "__main__":
    unittest.main()
