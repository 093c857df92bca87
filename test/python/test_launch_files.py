"""Each launch file loads; its nodes, files and documentation are there."""
import glob
import os
import shlex
import unittest
import xml.etree.ElementTree
from unittest import mock

import roslaunch.config
import roslib.packages
import yaml

from support import ROOT

LAUNCH_FILES = sorted(glob.glob(os.path.join(ROOT, "launch", "*.launch")))
OTHER = os.path.join(ROOT, "launch", "record.launch")    # any launch file will do
BAG = os.path.join(ROOT, "bags", "room.bag")
WORLD = os.path.join(ROOT, "config", "worlds", "room_hard.yaml")

# Packages that Debian lacks are stood in for.
os.environ["ROS_PACKAGE_PATH"] = os.pathsep.join([os.path.join(ROOT, "test", "stand_ins"), os.environ["ROS_PACKAGE_PATH"]])

# What is to be given, and every branch taken once.
VARIANTS = {
    "robot_localization.launch": [{}, {"global_filter": "true", "rviz": "true"}],
    "replay.launch": [{"bag": BAG}, {"bag": BAG, "rviz": "true", "loop": "true", "rate": "2.5", "exit": "true"}],
    "simulation.launch": [{}, {"rviz": "true", "drive": "cmd_vel", "world": WORLD}, {"pictures": "true"}],
    "slam.launch": [{}, {"rviz": "true", "mode": "localization", "map_dir": "/tmp/maps", "map_file": "a.yaml",
                         "load_map": "true", "save_map": "true",
                         "config": os.path.join(ROOT, "config", "turtlebot3.yaml")}],
    "turtlebot.launch": [{}, {"rviz": "true", "kinect_tf": "false", "detector": OTHER}],
}


def load(path, arguments):
    """The launch file as roslaunch would run it: its nodes by name and its parameters."""
    words = [f"{name}:={value}" for name, value in arguments.items()]
    config = roslaunch.config.load_config_default([(path, words)], None, verbose=False, assign_machines=False)
    return {node.name: node for node in config.nodes}, {name: param.value for name, param in config.params.items()}


def loaded():
    for path in LAUNCH_FILES:
        for arguments in VARIANTS.get(os.path.basename(path), [{}]):
            yield (path, arguments) + load(path, arguments)


class LaunchFiles(unittest.TestCase):
    def test_all_load_and_start_something(self):
        self.assertEqual({os.path.basename(path) for path in LAUNCH_FILES},
                         {"convert_detections.launch", "detect_aruco.launch", "detect_features.launch",
                          "detect_kinect_cylinder.launch", "detect_laser_cylinder.launch", "detect_stereo_features.launch",
                          "navigation.launch", "record.launch", "replay.launch", "robot_localization.launch", "rviz.launch",
                          "simulation.launch", "slam.launch", "turtlebot.launch"})
        for path, arguments, nodes, _ in loaded():
            with self.subTest(path=path, arguments=arguments):
                self.assertTrue(nodes)
                expected = arguments.get("rviz") == "true" or os.path.basename(path) == "rviz.launch"
                self.assertEqual("rviz" in nodes, expected)

    def test_every_node_exists(self):
        for path, _, nodes, _ in loaded():
            for node in nodes.values():
                with self.subTest(path=path, node=node.name):
                    self.assertTrue(roslib.packages.find_node(node.package, node.type), f"{node.package}/{node.type}")

    def test_every_argument_is_documented(self):
        for path in LAUNCH_FILES:
            for argument in xml.etree.ElementTree.parse(path).getroot().findall("arg"):
                with self.subTest(path=path, argument=argument.get("name")):
                    self.assertTrue(argument.get("doc"))

    def test_simulated_time_is_used_in_replay_and_simulation_only(self):
        for path, _, _, parameters in loaded():
            with self.subTest(path=path):
                expected = os.path.basename(path) in ("replay.launch", "simulation.launch")
                self.assertEqual(parameters.get("/use_sim_time", False), expected)

    def test_files_that_are_named_exist(self):
        for path, arguments, nodes, parameters in loaded():
            with self.subTest(path=path, arguments=arguments):
                files = [parameters[name] for name in ("/simulator_node/world",) if name in parameters]
                files += [nodes["rviz"].args.split()[-1]] if "rviz" in nodes else []
                files += [shlex.split(nodes["player"].args)[-1]] if "player" in nodes else []
                for file in files:
                    self.assertTrue(os.path.isfile(file), file)

    def test_relative_paths_start_where_roslaunch_was_started(self):
        environment = dict(os.environ, PWD="/somewhere")
        with mock.patch.dict(os.environ, environment):
            nodes, _ = load(os.path.join(ROOT, "launch", "replay.launch"), {"bag": "a.bag"})
            self.assertEqual(shlex.split(nodes["player"].args)[-1], "/somewhere/a.bag")
            _, parameters = load(os.path.join(ROOT, "launch", "simulation.launch"), {"world": "a.yaml"})
            self.assertEqual(parameters["/simulator_node/world"], "/somewhere/a.yaml")

    def test_a_bag_may_have_blanks_in_its_name(self):
        nodes, _ = load(os.path.join(ROOT, "launch", "replay.launch"), {"bag": "/some where/my run.bag"})
        self.assertEqual(shlex.split(nodes["player"].args)[-1], "/some where/my run.bag")

    def test_slam_starts_from_the_defaults_of_slam_yaml(self):
        with open(os.path.join(ROOT, "config", "slam.yaml"), encoding="utf-8") as file:
            defaults = yaml.safe_load(file)
        _, parameters = load(os.path.join(ROOT, "launch", "slam.launch"), {})
        found = {name[len("/slam_node/"):]: value for name, value in parameters.items()
                 if name.startswith("/slam_node/")}
        expected = {"mode": defaults.pop("mode")}
        for group, values in defaults.items():
            expected.update({f"{group}/{name}": value for name, value in values.items()})
        self.assertEqual(found, expected)

    def test_what_is_given_wins_over_the_configuration(self):
        _, parameters = load(os.path.join(ROOT, "launch", "slam.launch"), VARIANTS["slam.launch"][1])
        for name, value in (("mode", "localization"), ("map/directory", "/tmp/maps"), ("map/file_name", "a.yaml"),
                            ("map/load_at_start", True), ("map/save_at_exit", True),
                            ("input/max_linear_speed", 0.6)):
            self.assertEqual(parameters[f"/slam_node/{name}"], value, name)

    def test_a_missing_bag_is_said_clearly(self):
        with self.assertRaisesRegex(Exception, "'bag'"):
            load(os.path.join(ROOT, "launch", "replay.launch"), {})


if __name__ == "__main__":
    unittest.main()
