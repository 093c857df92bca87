"""A simulated run as messages, to be played to a node."""
import os
import subprocess
import tempfile

import rosbag
import yaml

import scenario
from node_process import ROOT, executable
from waiting import wait_until

INPUTS = ("/imu", "/landmarks", "/odom", "/global_position")


def positions(landmark_map, key="source_id"):
    return {getattr(item, key): (item.position.x, item.position.y, item.position.z) for item in landmark_map.landmarks}


class Recording:
    """A run through a world of config/worlds, by topic; `overrides`: {group: {name: value}} of the world."""

    def __init__(self, world, seconds=None, overrides=None):
        with tempfile.TemporaryDirectory() as folder:
            bag, path = os.path.join(folder, "run.bag"), os.path.join(folder, "world.yaml")
            with open(os.path.join(ROOT, "config", "worlds", world), encoding="utf-8") as file:
                options = yaml.safe_load(file)
            for group, values in (overrides or {}).items():
                options[group].update(values)
            with open(path, "w", encoding="utf-8") as file:
                yaml.safe_dump(options, file)
            duration = [] if seconds is None else ["--duration", str(seconds)]
            subprocess.run([executable("slam_simulate"), "--world", path, *duration, "--out", bag],
                           check=True, stdout=subprocess.DEVNULL)
            with rosbag.Bag(bag) as file:
                self.messages = [(topic, message) for topic, message, _ in file.read_messages()]

    def of(self, topic):
        return [message for name, message in self.messages if name == topic]

    @property
    def mountings(self):
        return self.of("/tf_static")[0].transforms

    @property
    def true_landmarks(self):
        """{identity: (x, y, z)} in the world."""
        return positions(self.of("/ground_truth/landmarks")[0], "id")

    def play(self, run):
        """Sends all to the node; one odometry in ten is waited for, so that no queue runs over and nothing is lost."""
        odometry = self.of("/odom")
        awaited = {message.header.stamp for message in [*odometry[::10], odometry[-1]]}
        for topic, message in self.messages:
            if topic in INPUTS:
                run.publish(topic[1:], message)
            if topic == "/odom" and message.header.stamp in awaited:
                stamp = scenario.to_ns(message.header.stamp)
                wait_until(lambda: run.pose_stamp() == stamp,
                           lambda: "the pose of %d ns came; the node says:\n%s" % (stamp, run.process.said()))

    def wait_for_the_map(self, run):
        wait_until(lambda: run.map.last and len(run.map.last.landmarks) == len(self.true_landmarks),
                   lambda: "all landmarks are mapped; there are %d" % len(run.map.last.landmarks))
