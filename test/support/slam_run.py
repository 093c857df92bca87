"""One slam_node in a namespace of its own, fed by hand."""
import copy
import itertools
import os
import shutil
import tempfile
import time

import rospy
import yaml
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseWithCovarianceStamped
from kinect_ekf_slam.msg import AssociationArray, BeaconRanges, LandmarkDetectionArray, LandmarkMap
from kinect_ekf_slam.srv import LoadMap, SaveMap, SetMode
from nav_msgs.msg import Odometry, Path
from sensor_msgs.msg import Imu
from std_srvs.srv import SetBool, Trigger
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import MarkerArray

import scenario
from node_process import ROOT, NodeProcess, Recorder
from waiting import wait_until

_numbers = itertools.count()
_diagnostics = []  # the one subscription that all runs share


def default_parameters():
    with open(os.path.join(ROOT, "config", "slam.yaml"), encoding="utf-8") as file:
        return yaml.safe_load(file)


def read_yaml(path):
    """By libyaml: yaml's own reader takes seconds for a map."""
    with open(path, encoding="utf-8") as file:
        return yaml.load(file, Loader=yaml.CSafeLoader)


def with_overrides(parameters, overrides):
    """`overrides`: {"group/key": value}; None takes the key away."""
    result = copy.deepcopy(parameters)
    for key, value in overrides.items():
        *groups, name = key.split("/")
        group = result
        for entry in groups:
            group = group.setdefault(entry, {})
        if value is None:
            group.pop(name, None)
        else:
            group[name] = value
    return result


class SlamProcess(NodeProcess):
    """slam_node: config/slam.yaml in its private namespace, and what differs."""

    def __init__(self, namespace, overrides, build=None):
        super().__init__("slam_node", namespace, with_overrides(default_parameters(), overrides),
                         ("/tf:=%s/tf" % namespace, "/tf_static:=%s/tf_static" % namespace), build)


class SlamRun:
    """A slam_node, the inputs that a scenario sends it and all that it has published."""

    # Markers and diagnostics come more often than a robot needs them, so that no test waits for them. The mountings,
    # which are sent once, may reach the node after the first data on a loaded machine: it waits for them. Scenarios
    # are short and their detections true: each is taken at its word.
    DEFAULTS = {"output/marker_rate": 50.0, "diagnostic_period": 0.1, "frames/tf_timeout": 5.0,
                "map/confirm_sightings": 1, "map/remove_after_visits": 0}

    def __init__(self, overrides=None, map_directory=None, start=None, mountings=None, build=None,
                 **scenario_options):
        self.namespace = "/run_%d" % next(_numbers)
        self._own_directory = None if map_directory else tempfile.mkdtemp(prefix="slam_maps_")
        self.map_directory = map_directory or self._own_directory
        self.scenario = scenario.Scenario(recent_start() if start is None else start, **scenario_options)
        self._inputs = {}
        self._recorders = {}
        self._publish_mountings(mountings or scenario.mountings())
        self.process = SlamProcess(self.namespace,
                                   {**self.DEFAULTS, "map/directory": self.map_directory, **(overrides or {})}, build)
        self._connect()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        try:
            self.process.stop()
        finally:
            for recorder in self._recorders.values():
                recorder.close()
            for publisher in [*self._inputs.values(), self._mountings]:
                publisher.unregister()
            if self._own_directory:
                shutil.rmtree(self._own_directory)

    # Inputs ------------------------------------------------------------------------------------------------------

    def publish(self, topic, message):
        self._inputs[topic].publish(message)

    def send(self, step):
        """One step of the scenario; returns when its odometry has moved the pose."""
        if step.detections:
            self.publish("landmarks", step.detections)
        if step.imu:
            self.publish("imu", step.imu)
        self.publish("odom", step.odometry)
        wait_until(lambda: self.pose_stamp() == step.stamp, lambda: "the pose came; the node says:\n" + self.process.said())

    def drive(self, seconds, look=True, expect_use=True):
        """The scenario goes on; each detection message is waited for, so that two runs are the same."""
        looked = None
        for _ in range(int(round(seconds * scenario.SECOND / scenario.PERIOD))):
            step = self.scenario.step()
            step.detections = step.detections if look else None
            self.send(step)
            if step.detections:
                looked = step.stamp
            elif looked and expect_use:  # the odometry that comes next brings a triple to its end
                self.wait_for_associations(looked)

    def wait_for_associations(self, stamp):
        """What became of the detections of that stamp."""
        return wait_until(lambda: next((message for message in reversed(self.associations.messages)
                                        if scenario.to_ns(message.header.stamp) == stamp), None),
                          "the detections of %d ns were used" % stamp)

    # Outputs -----------------------------------------------------------------------------------------------------

    def __getattr__(self, name):
        """The recorder of an output, for example `run.pose`."""
        try:
            return self.__dict__["_recorders"][name]
        except KeyError:
            raise AttributeError(name) from None

    def pose_stamp(self):
        return scenario.to_ns(self.pose.last.header.stamp) if self.pose.last else None

    def pose_in_map(self):
        """(x, y, heading) as published last."""
        pose = self.pose.last.pose.pose
        return pose.position.x, pose.position.y, scenario.heading_of(pose.orientation)

    def diagnostics(self, part):
        """{key: text} of the newest "inputs" or "estimate" status, with its level, message and stamp (ns)."""
        wanted = "%s: %s" % (self.process.name[1:], part)
        for message in reversed(list(_diagnostics[0].messages)):
            for status in message.status:
                if status.name == wanted:
                    return dict({item.key: item.value for item in status.values}, level=status.level,
                                message=status.message, stamp=scenario.to_ns(message.header.stamp))
        return {}

    def wait_for_count(self, part, key, count=1):
        """Until diagnostics have counted that often."""
        wait_until(lambda: int(self.diagnostics(part).get(key, 0)) >= count,
                   lambda: "'%s' is %d or more; it is\n%s" % (key, count, self.diagnostics(part)))

    def saved_map(self):
        """The map and its whole covariance at this moment, exactly."""
        reply = self.call("save_map", SaveMap, "snapshot_of_the_test.yaml")
        assert reply.success, reply.message
        return read_yaml(reply.message)

    # Services ----------------------------------------------------------------------------------------------------

    def call(self, name, kind, *arguments):
        return rospy.ServiceProxy(self.process.name + "/" + name, kind)(*arguments)

    def save_map(self, file_name=""):
        return self.call("save_map", SaveMap, file_name)

    def load_map(self, file_name="", keep_saved_pose=False):
        return self.call("load_map", LoadMap, file_name, keep_saved_pose)

    def reset(self):
        return self.call("reset", Trigger)

    def pause(self, paused):
        return self.call("pause", SetBool, paused)

    def set_mode(self, mode):
        return self.call("set_mode", SetMode, mode)

    # -------------------------------------------------------------------------------------------------------------

    def _publish_mountings(self, mountings):
        self._mountings = rospy.Publisher(self.namespace + "/tf_static", TFMessage, queue_size=1, latch=True)
        self._mountings.publish(TFMessage(mountings))

    def _connect(self):
        kinds = {"odom": Odometry, "imu": Imu, "landmarks": LandmarkDetectionArray,
                 "initialpose": PoseWithCovarianceStamped, "global_position": PoseWithCovarianceStamped,
                 "beacon_ranges": BeaconRanges}
        for topic, kind in kinds.items():
            self._inputs[topic] = rospy.Publisher(self.namespace + "/" + topic, kind, queue_size=1000, tcp_nodelay=True)
        outputs = {"pose": PoseWithCovarianceStamped, "odometry": Odometry, "path": Path, "map": LandmarkMap,
                   "markers": MarkerArray, "associations": AssociationArray}
        for topic, kind in outputs.items():
            self._recorders[topic] = Recorder(self.process.name + "/" + topic, kind)
        self._recorders["tf"] = Recorder(self.namespace + "/tf", TFMessage)
        if not _diagnostics:
            _diagnostics.append(Recorder("/diagnostics", DiagnosticArray))
        wait_until(lambda: not self.process.is_running() or not self._unconnected(),
                   lambda: "the node was connected; missing: %s; it says:\n%s" % (self._unconnected(), self.process.said()))
        assert self.process.is_running(), self.process.said()

    def _unconnected(self):
        """The topics that the node has not found yet; the mountings among them."""
        inputs = dict(self._inputs, tf_static=self._mountings)
        return ([topic for topic, publisher in inputs.items() if publisher.get_num_connections() == 0] +
                [topic for topic, recorder in self._recorders.items() if not recorder.is_connected()])


def recent_start():
    """ns; so long ago that a test's data, which come faster than real time, are never of the future."""
    return int(time.time() - 100.0) * scenario.SECOND
