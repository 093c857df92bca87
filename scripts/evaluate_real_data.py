#!/usr/bin/python3
"""Runs the package on recorded data by others and prints how well it does, beside what it has to reach.

MRCLAM dataset 6 (five robots, known identities, one configuration), MRCLAM dataset 4 with the identities withheld,
a TurtleBot3 among nine cylinders, a truck among the trees of Victoria Park, a Husky by dead reckoning against GPS.
The data are not part of the package: --data, else the environment variable SLAM_DATA, names the folder; without it
there is nothing to do. --misread, --crops, --refine and --particles run their own studies instead.
"""
import argparse
import json
import os
import subprocess
import shutil
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
if __name__ == "__main__":
    from slam_tools.environment import use_system_python
    use_system_python()

from slam_tools.refinements import print_refinements

ROOT = os.path.dirname(os.path.dirname(os.path.realpath(__file__)))
PYTHON = "/usr/bin/python3"
ROBOTS = (1, 2, 3, 4, 5)
HEADING_SOURCES = ("odometry", "gyrodometry", "gyrodometry_report", "imu")
CROPS_S = (100, 200, 300, 400, 500, 600)   # s that a run of MRCLAM 4 begins later
MISREAD_SHARE, MISREAD_SEEDS = 0.035, (1, 2)
# A textbook's update: what has an identity is obeyed, with its full weight, wherever it says to be.
WITHOUT_CHECK = ("association/gate_probability=1.0",
                 "association/new_landmark_probability=1.0", "estimator/robust_threshold=0",
                 "estimator/replace_after=0")
ESTIMATORS = ("invariant_ekf", "ekf", "compressed_ekf", "ukf", "fastslam1", "fastslam2")

# Of --particles: estimator, estimator/draw_after (1: the authors' filter), particles, seeds from 1 on.
PARTICLES = (("fastslam1", 10, 100, 5), ("fastslam2", 10, 100, 5), ("fastslam1", 1, 100, 5), ("fastslam2", 1, 100, 5),
             ("fastslam1", 10, 1000, 1), ("fastslam1", 1, 1000, 1))


def default_data():
    """The data folder that the environment names, or the one beside the package's root."""
    return os.environ.get("SLAM_DATA") or os.path.join(os.path.dirname(ROOT), "shared", "data")


def script(name, *arguments):
    subprocess.run([PYTHON, os.path.join(ROOT, "scripts", name), *arguments], check=True, stdout=subprocess.DEVNULL)


def read_json(directory, name):
    with open(os.path.join(directory, name), encoding="utf-8") as file:
        return json.load(file)


def evaluate(directory, truth, align="se2"):
    """evaluation.json, with summary.json under "summary"."""
    script("evaluate.py", directory, "--truth", truth, "--align", align)
    return {**read_json(directory, "evaluation.json"), "summary": read_json(directory, "summary.json")}


def replay(bag, truth, config, directory, *settings, align="se2", refine=False):
    """Replays a bag and evaluates it; with refine, the evaluation of the refined run is under "refined", its
    refinement.json under "refinement"."""
    slam_replay = os.path.join(ROOT, "build", "devel", "lib", "kinect_ekf_slam", "slam_replay")
    command = [slam_replay, bag, "--config", os.path.join(ROOT, "config", config), "--out", directory]
    for setting in settings:
        command += ["--set", setting]
    subprocess.run(command + ["--refine"] * refine, check=True, stdout=subprocess.DEVNULL)
    result = evaluate(directory, truth, align)
    if refine:
        refined = os.path.join(directory, "refined")
        result["refined"] = evaluate(refined, truth, align)
        result["refinement"] = read_json(refined, "refinement.json")
    return result


def mrclam_bag(folder, robot, bag, *options):
    if not os.path.exists(bag):
        script("mrclam_to_bag.py", folder, str(robot), bag, *options)
    return bag


def of_robots(function):
    """The function's results for the five robots, two at a time."""
    with ThreadPoolExecutor(2) as pool:
        return list(pool.map(function, ROBOTS))


def mrclam(data, out, settings=(), name="mrclam6"):
    """Results of the five robots of MRCLAM 6."""
    def one(robot):
        bag = mrclam_bag(os.path.join(data, "mrclam6"), robot, os.path.join(out, f"mrclam6_{robot}.bag"))
        return replay(bag, bag, "mrclam.yaml", os.path.join(out, f"{name}_{robot}"), *settings)
    return of_robots(one)


def identities(bag_path):
    """{(stamp in ns, index in its message): identity} of the detections in a bag."""
    from slam_tools.bags import open_bag
    with open_bag(bag_path) as bag:
        return {(message.header.stamp.to_nsec(), i): detection.id
                for _, message, _ in bag.read_messages("/landmarks") for i, detection in enumerate(message.detections)}


def count_caught(directory, wrong):
    """How many of the wrong detections, {(stamp in ns, index)}, were not accepted at the end."""
    from slam_tools.runs import ACCEPTED, ASSOCIATION_COLUMNS
    from slam_tools.tables import read_csv
    rows = read_csv(os.path.join(directory, "associations.csv"), ASSOCIATION_COLUMNS, ("detection",))
    accepted = {(int(row["t"].replace(".", "")), int(row["detection"])) for row in rows if row["verdict"] in ACCEPTED}
    return len(wrong - accepted)


def misread(data, out, seed, settings=()):
    """Of each robot of MRCLAM 6 with misread identities: (number misread, {"clean", "checked", "obeyed": result});
    "caught" in the results of the latter two is how many of them were not accepted."""
    def one(robot):
        folder = os.path.join(data, "mrclam6")
        clean = mrclam_bag(folder, robot, os.path.join(out, f"mrclam6_{robot}.bag"))
        bag = mrclam_bag(folder, robot, os.path.join(out, f"misread{seed}_{robot}.bag"),
                         "--wrong-identities", str(MISREAD_SHARE), "--seed", str(seed))
        true, read = identities(clean), identities(bag)
        wrong = {key for key, identity in true.items() if read[key] != identity}
        results = {}
        for name, source, more in (("clean", clean, ()), ("checked", bag, ()), ("obeyed", bag, WITHOUT_CHECK)):
            directory = os.path.join(out, f"misread{seed}_{name}_{robot}")
            results[name] = replay(source, clean, "mrclam.yaml", directory, *settings, *more)
            results[name]["caught"] = count_caught(directory, wrong)
        return len(wrong), results
    return of_robots(one)


def refined(data, out, dataset, settings=(), share=0.0):
    """Results of the five robots with known identities, of which a share is wrong, by the filter and refined."""
    def one(robot):
        folder = os.path.join(data, dataset)
        clean = mrclam_bag(folder, robot, os.path.join(out, f"{dataset}_known_{robot}.bag"))
        bag = clean
        if share:
            bag = mrclam_bag(folder, robot, os.path.join(out, f"{dataset}_misread_{robot}.bag"),
                             "--wrong-identities", str(share), "--seed", "1")
        directory = os.path.join(out, f"{dataset}_refine{'_misread' if share else ''}_{robot}")
        result = replay(bag, clean, "mrclam.yaml", directory, *settings, refine=True)
        if share:
            true, read = identities(clean), identities(bag)
            wrong = {key for key, identity in true.items() if read[key] != identity}
            result["wrong"] = len(wrong)
            result["caught"] = count_caught(os.path.join(directory, "refined"), wrong)
        return result
    return of_robots(one)


def begin_later(folder, robot, seconds, target):
    """Copies what MRCLAM recorded of a robot without the rows of its first seconds."""
    for name in ("Barcodes.dat", "Landmark_Groundtruth.dat"):
        shutil.copy(os.path.join(folder, name), target)
    start = None
    for name in (f"Robot{robot}_Odometry.dat", f"Robot{robot}_Measurement.dat"):
        with open(os.path.join(folder, name), encoding="utf-8") as file:
            rows = [line for line in file if line.strip() and not line.startswith("#")]
        start = float(rows[0].split()[0]) if start is None else start
        with open(os.path.join(target, name), "w", encoding="utf-8") as file:
            file.writelines(row for row in rows if float(row.split()[0]) >= start + seconds)


def mrclam_unknown(data, out, settings=(), later=0):
    """Results of the five robots of MRCLAM 4, identities withheld, begun so many seconds later."""
    def one(robot):
        bag = os.path.join(out, f"mrclam4_{robot}_{later}.bag")
        with tempfile.TemporaryDirectory() as cut:
            folder = os.path.join(data, "mrclam4")
            if later:
                begin_later(folder, robot, later, cut)
            mrclam_bag(cut if later else folder, robot, bag)
        return replay(bag, bag, "mrclam_unknown.yaml", os.path.join(out, f"mrclam4_{robot}_{later}"), *settings)
    return of_robots(one)


def meets_unknown_goals(result):
    return (result["landmarks_estimated"] == 15 and result["landmarks_missed"] == 0
            and result["association_accuracy"] >= 0.99 and result["landmark_rmse_m"] <= 0.08
            and result["summary"]["times_real_time"] >= 20.0)


def turtlebot3(data, out, settings=()):
    bag = os.path.join(out, "turtlebot3.bag")
    if not os.path.exists(bag):
        script("turtlebot3_truth.py", os.path.join(data, "bags", "turtlebot3_world.bag"), bag)
    return replay(bag, bag, "turtlebot3.yaml", os.path.join(out, "turtlebot3"), *settings)


def victoria_park(data, out, settings=()):
    bag = os.path.join(out, "victoria_park.bag")
    if not os.path.exists(bag):
        script("victoria_park_to_bag.py", os.path.join(data, "victoria_park"), bag)
    return replay(bag, bag, "victoria_park.yaml", os.path.join(out, "victoria_park"), *settings, align="robust")


def husky(data, out):
    """Result of each heading source."""
    bag = os.path.join(data, "bags", "husky_outdoor.bag")
    return {source: replay(bag, bag, "husky.yaml", os.path.join(out, "husky_" + source),
                           "input/heading_source=" + source) for source in HEADING_SOURCES}


def mean(results, key):
    return sum(result[key] for result in results) / len(results)


def print_mrclam(results):
    print("MRCLAM 6, known identities, config/mrclam.yaml, aligned in SE(2)")
    print("  robot   path ATE (m)   dead reckoning (m)   landmarks (m)   pose NEES   times real time")
    for robot, result in zip(ROBOTS, results):
        print(f"  {robot:5d} {result['ate_rmse_m']:14.3f} {result['dead_reckoning_ate_rmse_m']:20.3f} "
              f"{result['landmark_rmse_m']:15.3f} {result['pose_nees_mean']:11.2f} "
              f"{result['summary']['times_real_time']:17.0f}")
    print(f"   mean {mean(results, 'ate_rmse_m'):14.3f} {mean(results, 'dead_reckoning_ate_rmse_m'):20.3f} "
          f"{mean(results, 'landmark_rmse_m'):15.3f} {mean(results, 'pose_nees_mean'):11.2f}")
    print("  goal    <= 0.20, worst <= 0.33                       <= 0.075     1.5 to 4             >= 500")


def print_estimators(results):
    best = min(mean(results[name], "ate_rmse_m") for name in ESTIMATORS if name.endswith("ekf"))
    print("MRCLAM 6, every estimator, the same configuration, means of the five robots")
    print("  estimator        path ATE (m)   to the best EKF's   landmarks (m)   pose NEES   times real time")
    for name, result in results.items():
        ate = mean(result, "ate_rmse_m")
        speed = min(robot["summary"]["times_real_time"] for robot in result)
        print(f"  {name:15s} {ate:13.3f} {ate / best:19.2f} {mean(result, 'landmark_rmse_m'):15.3f} "
              f"{mean(result, 'pose_nees_mean'):11.2f} {speed:17.0f}")
    print("  goal                             <= 1.15                         1.5 to 4")


def spread(values, digits):
    """Mean, smallest and largest, as text."""
    return " ".join(f"{value:.{digits}f}" for value in (sum(values) / len(values), min(values), max(values)))


def print_particles(data, out, settings):
    """MRCLAM 6 with FastSLAM over seeds: what a run is worth depends on the luck of the draw."""
    best = min(mean(mrclam(data, out, [*settings, "estimator/type=" + name], "mrclam6_" + name), "ate_rmse_m")
               for name in ESTIMATORS if name.endswith("ekf"))
    print("MRCLAM 6, FastSLAM, means of the five robots; over seeds their mean, the least and the largest")
    print("  estimator   draw_after   particles   seeds         path ATE (m)   to the best EKF's        landmarks (m)"
          "         pose NEES")
    for name, draw_after, particles, seeds in PARTICLES:
        runs = [mrclam(data, out, [*settings, f"estimator/type={name}", f"estimator/draw_after={draw_after}",
                                   f"estimator/particles={particles}", f"estimator/seed={seed}"],
                       f"mrclam6_{name}_{draw_after}_{particles}_{seed}")
                for seed in range(1, seeds + 1)]
        ate, landmarks, nees = ([mean(run, key) for run in runs]
                                for key in ("ate_rmse_m", "landmark_rmse_m", "pose_nees_mean"))
        print(f"  {name:9s} {draw_after:12d} {particles:11d} {seeds:7d} {spread(ate, 3):>20s} {sum(ate) / len(ate) / best:19.2f} "
              f"{spread(landmarks, 3):>20s} {spread(nees, 1):>17s}", flush=True)
    print("  goal                        <= 100                                           <= 1.15"
          "                                1.5 to 4")


def print_misread(data, out, settings):
    print(f"MRCLAM 6, {100 * MISREAD_SHARE:g} % of the identities wrong, config/mrclam.yaml;")
    print("  obeyed: with " + " ".join(WITHOUT_CHECK))
    print("                          caught                path ATE (m)               landmarks (m)")
    print("  seed   robot   wrong   checked  obeyed     clean checked  obeyed     clean checked  obeyed")
    wrong_of_all = caught_of_all = worse = 0
    for seed in MISREAD_SEEDS:
        for robot, (wrong, results) in zip(ROBOTS, misread(data, out, seed, settings)):
            caught = results["checked"]["caught"]
            figures = [[results[name][key] for name in ("clean", "checked", "obeyed")]
                       for key in ("ate_rmse_m", "landmark_rmse_m")]
            wrong_of_all, caught_of_all = wrong_of_all + wrong, caught_of_all + caught
            worse += any(checked > obeyed for _, checked, obeyed in figures)
            print(f"  {seed:4d} {robot:7d} {wrong:7d} {caught / wrong:9.0%} {results['obeyed']['caught'] / wrong:7.0%}  "
                  + "   ".join("".join(f"{figure:8.3f}" for figure in row) for row in figures))
    print(f"   all         {wrong_of_all:7d} {caught_of_all / wrong_of_all:9.0%}           {worse} of "
          f"{len(MISREAD_SEEDS) * len(ROBOTS)} worse checked than obeyed")
    print("  goal                    >= 50%             none worse checked than obeyed")


def print_refined(data, out, settings):
    """By the filter and refined: MRCLAM 6, MRCLAM 4, and MRCLAM 6 with misread identities."""
    print("slam_replay --refine, MRCLAM 6, known identities, config/mrclam.yaml; each unknown with its sigma")
    print_refinements(ROBOTS, refined(data, out, "mrclam6", settings))
    print("   goal           <= 0.10             <= 0.06     <= 60")
    print("MRCLAM 4, the same (no true path); goal: landmarks not worse than the filter's")
    print_refinements(ROBOTS, refined(data, out, "mrclam4", settings))
    results = refined(data, out, "mrclam6", settings, MISREAD_SHARE)
    print(f"MRCLAM 6, {100 * MISREAD_SHARE:g} % of the identities wrong: {sum(result['caught'] for result in results)} of "
          f"{sum(result['wrong'] for result in results)} not believed when refined")
    print_refinements(ROBOTS, results)


def print_mrclam_unknown(results, later=0):
    begun = f", begun {later} s later" if later else ""
    print(f"MRCLAM 4, identities withheld, config/mrclam_unknown.yaml, aligned in SE(2){begun}")
    print("  robot   landmarks   associations right   as told at once   landmarks (m)   times real time")
    for robot, result in zip(ROBOTS, results):
        print(f"  {robot:5d} {result['landmarks_estimated']:11d} {result['association_accuracy']:20.4f} "
              f"{result['association_accuracy_instant']:17.4f} {result['landmark_rmse_m']:15.3f} "
              f"{result['summary']['times_real_time']:17.0f}")
    print("   goal          15              >= 0.99                           <= 0.08             >= 20")


def print_crops(data, out, settings):
    met = 0
    for later in CROPS_S:
        results = mrclam_unknown(data, out, settings, later)
        print_mrclam_unknown(results, later)
        met += sum(map(meets_unknown_goals, results))
    print(f"{met} of {len(CROPS_S) * len(ROBOTS)} runs begun later meet all goals")


def print_turtlebot3(result):
    print("TurtleBot3, laser, unknown identities, config/turtlebot3.yaml, aligned in SE(2)")
    print(f"  landmarks {result['landmarks_estimated']} of {result['landmarks_true']}, largest error "
          f"{result['landmark_max_m']:.3f} m (goal: exactly 9, <= 0.05 m); path ATE {result['ate_rmse_m']:.3f} m")


def print_victoria_park(result):
    print("Victoria Park, laser, unknown identities, config/victoria_park.yaml, against GPS, robust alignment")
    print(f"  path error: median {result['path_error_median_m']:.2f} m (goal: <= 1.0), 95th percentile "
          f"{result['path_error_p95_m']:.2f} m (<= 3.5); {result['landmarks_estimated']} landmarks (< 300); "
          f"{result['summary']['times_real_time']:.0f} times real time (>= 20)")


def print_husky(results):
    print("Husky, dead reckoning against GPS, config/husky.yaml (goal: about 6.9 m by wheels, 3.2 m by gyro)")
    for source, result in results.items():
        print(f"  {source:20s} path ATE {result['ate_rmse_m']:.2f} m")


def run(arguments):
    """Runs and prints what was asked for."""
    if arguments.misread:
        print_misread(arguments.data, arguments.out, arguments.settings)
    if arguments.crops:
        print_crops(arguments.data, arguments.out, arguments.settings)
    if arguments.refine:
        print_refined(arguments.data, arguments.out, arguments.settings)
    if arguments.particles:
        print_particles(arguments.data, arguments.out, arguments.settings)
    if arguments.misread or arguments.crops or arguments.refine or arguments.particles:
        return
    print_mrclam(mrclam(arguments.data, arguments.out, arguments.settings))
    if arguments.estimators:
        print_estimators({name: mrclam(arguments.data, arguments.out,
                                       [*arguments.settings, "estimator/type=" + name], "mrclam6_" + name)
                          for name in ESTIMATORS})
    print_mrclam_unknown(mrclam_unknown(arguments.data, arguments.out, arguments.settings))
    print_turtlebot3(turtlebot3(arguments.data, arguments.out, arguments.settings))
    print_victoria_park(victoria_park(arguments.data, arguments.out, arguments.settings))
    print_husky(husky(arguments.data, arguments.out))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", default=default_data(),
                        help="folder of the recorded data (default: SLAM_DATA, else shared/data beside the package)")
    parser.add_argument("--out", default=os.path.join(ROOT, "runs", "real_data"), help="folder for bags and results")
    parser.add_argument("--set", nargs="+", default=[], metavar="group/key=value", dest="settings",
                        help="parameters to try, over the configurations")
    parser.add_argument("--estimators", action="store_true", help="also MRCLAM with every estimator (minutes)")
    parser.add_argument("--misread", action="store_true", help="MRCLAM 6 with misread identities, nothing else")
    parser.add_argument("--crops", action="store_true",
                        help="MRCLAM 4 with the identities withheld, begun 100 to 600 s later, nothing else")
    parser.add_argument("--refine", action="store_true",
                        help="MRCLAM with known identities, filter and batch optimum side by side, nothing else")
    parser.add_argument("--particles", action="store_true",
                        help="MRCLAM 6, FastSLAM over seeds, the authors' and ours, nothing else (half an hour)")
    arguments = parser.parse_args()
    if not os.path.isdir(arguments.data):
        print(f"evaluate_real_data.py: skipped: no recorded data in {arguments.data} (set SLAM_DATA)")
        return 0
    os.makedirs(arguments.out, exist_ok=True)
    try:
        run(arguments)
    except (OSError, subprocess.CalledProcessError) as error:
        print(f"evaluate_real_data.py: {error}", file=sys.stderr)
        return 2
    print(f"Pictures and files: {os.path.relpath(arguments.out)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
