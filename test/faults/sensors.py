"""Sensors that fall silent, clocks that jump, transforms that are missing or doubled, and far too much of everything."""
import io
import math
import random
import struct
import time

import rospy
from tf2_msgs.msg import TFMessage

import scenario
from damaged_messages import START, goes_on, is_finite
from kill import LANDMARKS
from row import Row, number
from slam_run import SlamRun
from waiting import soon, wait_until

FARTHEST = 0.1  # m that the pose may be off at the end: the scenario's robot has perfect odometry
MOST_WAIT = 1.0  # s after a flood until the newest odometry has moved the pose
MOST_MEMORY = 20.0  # MB more after it


def _error(run, step):
    x, y, _ = run.pose_in_map()
    return math.hypot(x - step.pose[0], y - step.pose[1])


def _tell(run, condition, what):
    wait_until(lambda: condition(run.diagnostics("inputs")), lambda: f"{what}; diagnostics are {run.diagnostics('inputs')}")


def _drop_out(run, choice):
    """One input after the other is silent, each until diagnostics say so; returns how far the pose is off then."""
    silent = int(run.diagnostics("inputs").get("refused, imu: silent", 0))
    for _ in range(choice.randrange(15, 30)):  # the gyro
        step = run.scenario.step()
        step.imu = None
        run.send(step)
    _tell(run, lambda said: int(said.get("refused, imu: silent", 0)) > silent, "the IMU is missed")
    run.drive(choice.uniform(1.0, 5.0), look=False)  # the detector
    for _ in range(choice.randrange(2, 20)):  # the wheels, while the robot drives on
        run.scenario.step()
    _tell(run, lambda said: "odometry has stopped" in said["message"], "the odometry is missed")
    run.drive(21.0, expect_use=False)  # once round: it sees its landmarks again
    step = run.scenario.step()
    run.send(step)
    return _error(run, step)


def dropouts(quick):
    count = 1 if quick else 20
    choice = random.Random(11)
    with SlamRun(with_imu=True, speed=0.05, turn=0.3, start=START) as run:
        run.drive(2.0)
        worst = max(_drop_out(run, choice) for _ in range(count))
    return Row("gyro, detector and odometry fall silent for a while, one after the other", number(count),
               f"diagnostics say so each time; afterwards the pose is less than {FARTHEST} m off", f"at most {worst:.3f} m off", worst < FARTHEST)


def clock(quick):
    """All stamps jump together, as when a computer's clock is set."""
    count = 5 if quick else 100
    choice = random.Random(12)
    longest, went_on, finite = 0, 0, True
    with SlamRun({"estimator/max_landmarks": 60}, start=START, with_imu=True) as run:
        for _ in range(count):
            run.scenario.stamp += int(choice.choice((-1e5, -100.0, -2.0, -0.15, 0.15, 2.0, 100.0, 1e5)) * scenario.SECOND)
            steps = goes_on(run)
            went_on += steps > 0
            longest = max(longest, steps)
        finite = all(is_finite(message) for message in run.pose.messages)
    return Row("the clock of all sensors jumps, by 0.15 s to a day, ahead and back", number(count),
               "the node goes on, its output is finite", f"{went_on} times it went on, after at most {longest} odometry messages",
               went_on == count and finite)


def transforms(quick):
    """Without the camera's mounting, then with it from two nodes at once, again and again."""
    count = 3 if quick else 20
    right = 0
    for _ in range(count):
        with SlamRun({"frames/tf_timeout": 0.05}, mountings=scenario.mountings()[1:]) as run:
            run.drive(1.0, expect_use=False)
            _tell(run, lambda said: int(said.get("refused, landmarks: no transform", 0)) > 0, "the transform is missed")
            publishers = [rospy.Publisher(run.namespace + topic, TFMessage, queue_size=10, latch=True) for topic in ("/tf", "/tf_static", "/tf_static")]
            for _ in range(10):
                for publisher in publishers:
                    publisher.publish(TFMessage(_dated(scenario.mountings(), run.scenario.stamp)))
                run.drive(0.2, expect_use=False)
            run.drive(1.0)
            landmarks = {item["source_id"]: item["position"] for item in run.saved_map()["landmarks"]}
            right += set(landmarks) == set(scenario.LANDMARKS) and all(
                math.hypot(landmarks[i][0] - x, landmarks[i][1] - y) < FARTHEST for i, (_, x, y) in scenario.LANDMARKS.items())
            for publisher in publishers:
                publisher.unregister()
    return Row("the camera's transform is missing, then comes from three publishers at once, static and not", number(count),
               "refused as `no transform` until it comes; then the map is right", f"{right} maps right", right == count)


def _dated(mountings, stamp):
    for mounting in mountings:
        mounting.header.stamp = scenario.to_ros(stamp)
    return mountings


def _serialized(message):
    """The message, at the cost of its bytes alone however often it is sent: only its stamp and number are new each time."""
    buffer = io.BytesIO()
    message.serialize(buffer)
    after_stamp = buffer.getvalue()[12:]

    class Serialized(type(message)):
        def serialize(self, buff):
            buff.write(struct.pack("<3I", self.header.seq, self.header.stamp.secs, self.header.stamp.nsecs) + after_stamp)
    return Serialized()


def _flood(run, seconds, rates):
    """Messages as fast as `rates` (Hz, by topic) say, stamped now; returns the newest odometry's stamp and how many were sent."""
    messages = {"odom": _serialized(scenario.odometry_message(0, (0.0, 0.0, 0.0), 0.0, 0.0)),
                "imu": _serialized(scenario.imu_message(0, 0.0)), "landmarks": _serialized(run.scenario.detections())}
    sent = dict.fromkeys(rates, 0)
    begin = time.time()
    while time.time() < begin + seconds:
        due = [topic for topic, rate in rates.items() if sent[topic] < (time.time() - begin) * rate]
        for topic in due:
            messages[topic].header.stamp = scenario.to_ros(int(time.time() * scenario.SECOND))
            run.publish(topic, messages[topic])
            sent[topic] += 1
        if not due:
            time.sleep(1e-4)
    return scenario.to_ns(messages["odom"].header.stamp), sent


def rates(quick):
    """Ten times what a robot sends: odometry 50 Hz, IMU 100 Hz, detections 10 Hz."""
    seconds = 5 if quick else 60
    wanted = {"odom": 500, "imu": 1000, "landmarks": 100}
    with SlamRun({"association/type": "known"}, landmarks=LANDMARKS, with_imu=True, speed=0.0, turn=0.0,
                 start=int(time.time()) * scenario.SECOND) as run:
        for output in (run.odometry, run.path, run.markers, run.associations, run.tf):
            output.close()  # what this process does not hear leaves it time to send
        _flood(run, 1.0, wanted)  # the map is made
        before = run.process.memory()
        newest, sent = _flood(run, seconds, wanted)
        begin = time.monotonic()
        caught_up = soon(lambda: run.pose_stamp() == newest, MOST_WAIT)
        late = time.monotonic() - begin
        more = (run.process.memory() - before) / 1e6
        told = "odometry longest wait (s)" in run.diagnostics("inputs")
    achieved = ", ".join(f"{topic} {count / seconds:.0f} Hz" for topic, count in sent.items())
    fast_enough = all(sent[topic] > 0.95 * rate * seconds for topic, rate in wanted.items())
    return Row(f"ten times the usual rates, {len(LANDMARKS)} landmarks a message", f"{seconds} s: {achieved}",
               f"memory grows by less than {MOST_MEMORY:g} MB; {MOST_WAIT:g} s after the end the pose is of the newest odometry; diagnostics tell how long messages wait",
               f"{more:.1f} MB more, pose {'after %.2f s' % late if caught_up else 'NOT in time'}" + ("" if fast_enough else ", NOT ten times the rates"),
               bool(caught_up) and more < MOST_MEMORY and told and fast_enough)
