#include "kinect_ekf_slam/ros/bag_replay.h"

#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <tf2/buffer_core.h>
#include <tf2_msgs/TFMessage.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <memory>
#include <new>
#include <set>
#include <stdexcept>

#include "kinect_ekf_slam/mapping/map_file.h"
#include "kinect_ekf_slam/ros/bounded_landmarks.h"
#include "kinect_ekf_slam/ros/run_writer.h"
#include "kinect_ekf_slam/ros/slam_session.h"
#include "kinect_ekf_slam/ros/static_transforms.h"

namespace kinect_ekf_slam {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

double cpu_seconds() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

std::string absolute(const std::string& topic) {
  return topic.empty() || topic.front() == '/' ? topic : "/" + topic;
}

/// The bag's topics by what they are for.
class Topics {
 public:
  Topics(const rosbag::Bag& bag, const std::string& path, const SyncOptions& sync,
         const FusionOptions& fusion)
      : odometry(absolute(sync.odometry_topic)),
        imu(absolute(sync.imu_topic)),
        landmarks(absolute(sync.landmarks_topic)),
        positions(absolute(fusion.positions_topic)),
        fixes(absolute(fusion.fix_topic)),
        ranges(absolute(fusion.ranges_topic)) {
    rosbag::View everything(bag);
    std::map<std::string, std::string> types;
    std::map<std::string, std::string> checksums;
    for (const rosbag::ConnectionInfo* connection : everything.getConnections()) {
      types[absolute(connection->topic)] = connection->datatype;
      checksums[absolute(connection->topic)] = connection->md5sum;
      recorded_as_[absolute(connection->topic)].insert(connection->topic);
    }
    if (types.count(odometry) == 0) {
      std::string present;
      for (const auto& [topic, type] : types) present += (present.empty() ? "" : ", ") + topic;
      throw std::runtime_error(path + ": no odometry on '" + odometry +
                               "' (sync/odometry_topic); the bag has " +
                               (present.empty() ? "nothing" : present));
    }
    check_type(types, odometry, "nav_msgs/Odometry", "sync/odometry_topic", path);
    check_type(types, imu, "sensor_msgs/Imu", "sync/imu_topic", path);
    check_type(types, landmarks, "kinect_ekf_slam/LandmarkDetectionArray", "sync/landmarks_topic", path);
    check_type(types, positions, "geometry_msgs/PoseWithCovarianceStamped", "fusion/positions_topic", path);
    check_type(types, fixes, "sensor_msgs/NavSatFix", "fusion/fix_topic", path);
    check_type(types, ranges, "kinect_ekf_slam/BeaconRanges", "fusion/ranges_topic", path);
    check_version<BeaconRanges>(checksums, ranges, path);
    check_version<nav_msgs::Odometry>(checksums, odometry, path);
    check_version<sensor_msgs::Imu>(checksums, imu, path);
    check_version<LandmarkDetectionArray>(checksums, landmarks, path);
  }

  std::vector<std::string> all() const {
    std::vector<std::string> topics;
    for (const std::string& name : {odometry, imu, landmarks, positions, fixes, ranges, std::string("/tf"),
                                    std::string("/tf_static")}) {
      const auto recorded = recorded_as_.find(name);
      if (recorded != recorded_as_.end())
        topics.insert(topics.end(), recorded->second.begin(), recorded->second.end());
    }
    return topics;
  }

  const std::string odometry;
  const std::string imu;
  const std::string landmarks;
  const std::string positions;
  const std::string fixes;
  const std::string ranges;

 private:
  static void check_type(const std::map<std::string, std::string>& types, const std::string& topic,
                         const std::string& expected, const std::string& key, const std::string& path) {
    const auto type = types.find(topic);
    if (type != types.end() && type->second != expected) {
      throw std::runtime_error(path + ": '" + topic + "' (" + key + ") is " + type->second + ", expected " +
                               expected);
    }
  }

  /// A message of another version would be skipped without a word.
  template <class Message>
  static void check_version(const std::map<std::string, std::string>& checksums, const std::string& topic,
                            const std::string& path) {
    const auto checksum = checksums.find(topic);
    const std::string expected = ros::message_traits::md5sum<Message>();
    if (checksum != checksums.end() && checksum->second != expected) {
      throw std::runtime_error(path + ": '" + topic + "' was recorded with another version of " +
                               ros::message_traits::datatype<Message>() + " (checksum " + checksum->second +
                               ", expected " + expected + ")");
    }
  }

  std::map<std::string, std::set<std::string>> recorded_as_;
};

void add_transforms(const rosbag::MessageInstance& instance, bool is_static, tf2::BufferCore* buffer) {
  const auto message = instance.instantiate<tf2_msgs::TFMessage>();
  if (!message) return;
  for (const auto& transform : message->transforms) buffer->setTransform(transform, "bag", is_static);
}

std::string refined_folder(const ReplayRequest& request) { return request.output_directory + "/refined"; }
std::string global_folder(const ReplayRequest& request) { return request.output_directory + "/global"; }

/// One run through a bag that is open and understood.
class Replay {
 public:
  Replay(const ReplayRequest& request, const rosbag::Bag& bag, const Topics& topics)
      : request_(request), bag_(bag), topics_(topics), buffer_(ros::Duration(60.0)) {
    if (!request.output_directory.empty()) {
      writer_ = std::make_unique<RunWriter>(request.output_directory, request.options.output.trajectory_rate);
    }
    if (request.refine) {
      require_refining(request.options);
      recorder_ = std::make_unique<RunRecorder>(request.options.pipeline.input);
    }
    if (request.global) global_ = std::make_unique<GlobalRun>(request.options);
    make_session();
  }

  ReplayReport run() {
    const auto start = Clock::now();
    const double cpu_start = cpu_seconds();
    rosbag::View view(bag_, rosbag::TopicQuery(topics_.all()));
    report_.data_seconds = (view.getEndTime() - view.getBeginTime()).toSec();
    add_static_transforms(request_.options.frames.static_transforms, view.getBeginTime(), &buffer_);
    if (request_.options.map.load_at_start) {
      load_map();
    } else if (request_.options.pipeline.mode == Mode::kLocalization) {
      throw std::runtime_error("mode: localization needs a map: set map/load_at_start and map/file_name");
    }
    std::size_t done = 0;
    for (const rosbag::MessageInstance& instance : view) {
      if (request_.on_progress && ++done % 512 == 0) {
        request_.on_progress(static_cast<double>(done) / static_cast<double>(view.size()));
      }
      dispatch(instance);
    }
    session_->flush();
    report_.refusals = session_->input().refusals();
    require_odometry();
    report_.warnings = warnings();
    for (const Landmark3d& landmark : session_->pipeline().map()) {
      if (landmark.confirmed) ++report_.landmarks;
    }
    report_.wall_seconds = seconds_since(start);
    if (writer_) {
      summary_.bag = request_.bag;
      summary_.parameters = request_.options.text;
      summary_.warnings = request_.warnings;
      summary_.warnings.insert(summary_.warnings.end(), report_.warnings.begin(), report_.warnings.end());
      summary_.wall_seconds = report_.wall_seconds;
      summary_.cpu_seconds = cpu_seconds() - cpu_start;
      summary_.data_seconds = report_.data_seconds;
      summary_.refusals = session_->input().refusals();
      summary_.accepted = session_->input().accepted();
      remove_run(refined_folder(request_));
      remove_run(global_folder(request_));
      writer_->write_beacons(session_->pipeline().beacons());
      writer_->finish(session_->pipeline().map(), summary_);
      write_map(request_.output_directory + "/map.yaml", request_.options.frames.map,
                session_->pipeline().save(), request_.options.text);
    }
    if (recorder_) refine();
    if (global_) report_.global = global_->finish(global_folder(request_), summary_);
    return report_;
  }

 private:
  void make_session() {
    SlamSession::Handlers handlers;
    handlers.on_result = [this](const SensorFrame& frame, const SlamResult& result) {
      on_result(frame, result);
    };
    handlers.on_refusal = [this](const std::string& line) {
      first_refusals_.emplace(line.substr(0, line.find_first_of("0123456789")), line);
    };
    handlers.on_time_jump = [this] {
      ++report_.new_runs;
      buffer_.clear();  // mountings that are static stay
      if (writer_) writer_->restart();
      if (recorder_) recorder_->restart();
      if (global_) global_->restart();
    };
    session_ = std::make_unique<SlamSession>(
        request_.options,
        [this](const std::string& target, const std::string& source, const ros::Time& stamp) {
          return lookup_transform(buffer_, target, source, stamp);
        },
        std::move(handlers));
  }

  void refine() {
    const FinishedRun run{*recorder_, writer_->associations(), session_->pipeline().map(), summary_};
    report_.refinement = refine_run(run, request_.options, refined_folder(request_), request_.on_progress);
  }

  void add_position_warnings(std::vector<std::string>* lines) const {
    for (const auto& [verdict, count] : position_verdicts_) {
      if (verdict == PositionVerdict::kUsed || verdict == PositionVerdict::kAligning) continue;
      lines->push_back(std::to_string(count) + " positions or ranges not used: " + to_string(verdict));
    }
    if (position_verdicts_.count(PositionVerdict::kAligning) > 0 && !is_aligned_) {
      lines->push_back(
          "where the map lies in fusion/frame '" + request_.options.fusion.frame +
          "' was not found: the robot has not moved far enough, or the positions contradict its way");
    }
  }

  /// A run of which all odometry was refused says nothing; what has begun a second time is told as it is.
  void require_odometry() const {
    const std::map<std::string, std::uint64_t>& accepted = session_->input().accepted();
    const auto used = accepted.find("odometry");
    if (report_.new_runs > 0 || (used != accepted.end() && used->second > 0)) return;
    for (const auto& [kind, line] : first_refusals_) {
      if (kind.rfind("odometry", 0) != 0) continue;
      throw std::runtime_error(request_.bag + ": no odometry message could be used, the first: " + line);
    }
  }

  std::vector<std::string> warnings() const {
    std::vector<std::string> lines;
    if (report_.detection_frames == 0) {
      lines.push_back("no detections on '" + request_.options.sync.landmarks_topic +
                      "' (sync/landmarks_topic): odometry " +
                      (position_verdicts_.count(PositionVerdict::kUsed) > 0 ? "and positions" : "alone"));
    }
    if (report_.new_runs > 0) {
      lines.push_back("time went back " + std::to_string(report_.new_runs) +
                      " times; the results are of the last run");
    }
    if (lost_ > 0) {
      const std::string kinds = position_verdicts_.empty() ? " detection" : " detection, position and range";
      lines.push_back("lost for " + std::to_string(lost_) + " of " + std::to_string(told_) + kinds +
                      " messages, from " + std::to_string(to_seconds(first_lost_)) +
                      " s on: most of what was seen fitted no landmark, or what told the place contradicted");
    }
    add_position_warnings(&lines);
    if (without_room_ > 0) {
      lines.push_back(std::to_string(without_room_) +
                      " sightings of new landmarks refused, the map is full: estimator/max_landmarks is " +
                      std::to_string(request_.options.pipeline.estimator.max_landmarks));
    }
    for (const auto& [kind, line] : first_refusals_) lines.push_back(line);
    for (const auto& [reason, count] : report_.refusals)
      lines.push_back(std::to_string(count) + " messages refused, " + reason);
    return lines;
  }

  void load_map() {
    const MapOptions& map = request_.options.map;
    session_->load(read_map(MapDirectory(map.directory).resolve(map.file_name), request_.options.frames.map),
                   false);
  }

  void on_result(const SensorFrame& frame, const SlamResult& result) {
    if (writer_) writer_->add(frame, result);
    if (recorder_) recorder_->add(frame, result);
    if (global_) global_->add(frame, result);
    for (const PositionOutcome& outcome : result.positions) ++position_verdicts_[outcome.verdict];
    is_aligned_ = is_aligned_ || result.map_from_global;
    if (result.looked || !result.positions.empty()) {
      ++told_;
      if (result.localization == Localization::kLost && lost_++ == 0) first_lost_ = frame.stamp;
    }
    if (!result.looked) return;
    ++report_.detection_frames;
    without_room_ +=
        std::count_if(result.outcomes.begin(), result.outcomes.end(),
                      [](const DetectionOutcome& outcome) { return outcome.verdict == Verdict::kMapFull; });
    summary_.update_milliseconds.push_back(1e3 * seconds_since(message_start_));
  }

  void dispatch(const rosbag::MessageInstance& instance) {
    const std::string topic = absolute(instance.getTopic());
    const ros::Time now = instance.getTime();
    message_start_ = Clock::now();
    if (topic == topics_.odometry) {
      if (const auto message = instance.instantiate<nav_msgs::Odometry>())
        session_->input().add_odometry(message, now);
    } else if (topic == topics_.imu) {
      if (const auto message = instance.instantiate<sensor_msgs::Imu>())
        session_->input().add_imu(message, now);
    } else if (topic == topics_.landmarks) {
      if (const auto message = instance.instantiate<BoundedLandmarks>())
        session_->input().add_landmarks(message, now);
    } else if (topic == topics_.positions) {
      if (const auto message = instance.instantiate<geometry_msgs::PoseWithCovarianceStamped>())
        session_->input().add_position(*message, now);
    } else if (topic == topics_.fixes) {
      if (const auto message = instance.instantiate<sensor_msgs::NavSatFix>())
        session_->input().add_fix(*message, now);
    } else if (topic == topics_.ranges) {
      if (const auto message = instance.instantiate<BeaconRanges>())
        session_->input().add_ranges(*message, now);
    } else {
      add_transforms(instance, topic == "/tf_static", &buffer_);
    }
  }

  const ReplayRequest& request_;
  const rosbag::Bag& bag_;
  const Topics& topics_;
  tf2::BufferCore buffer_;
  std::unique_ptr<RunWriter> writer_;
  std::unique_ptr<RunRecorder> recorder_;  ///< for a refinement
  std::unique_ptr<GlobalRun> global_;
  std::unique_ptr<SlamSession> session_;
  Clock::time_point message_start_;
  RunWriter::Summary summary_;
  std::map<std::string, std::string> first_refusals_;  ///< of each kind: others differ in their stamps
  std::size_t told_ = 0;                               ///< messages that say where the robot is ...
  std::size_t lost_ = 0;  ///< ... those of them while it was not where it believed to be
  TimeNs first_lost_ = 0;
  std::map<PositionVerdict, std::size_t> position_verdicts_;
  bool is_aligned_ = false;
  std::ptrdiff_t without_room_ = 0;  ///< sightings that a full map refused
  ReplayReport report_;
};

}  // namespace

ReplayReport replay_bag(const ReplayRequest& request) {
  ros::Time::init();  // message_filters asks for a clock; none is used
  rosbag::Bag bag;
  try {
    bag.open(request.bag, rosbag::bagmode::Read);
    return Replay(request, bag, Topics(bag, request.bag, request.options.sync, request.options.fusion)).run();
  } catch (const rosbag::BagException& error) {
    throw std::runtime_error(request.bag + ": not a readable bag: " + error.what());
  } catch (const ros::Exception& error) {  // a message that is shorter than it says
    throw std::runtime_error(request.bag + ": not a readable bag: " + error.what());
  } catch (const std::bad_alloc&) {
    throw std::runtime_error(request.bag + ": not a readable bag: a length in it is beyond the memory");
  }
}

}  // namespace kinect_ekf_slam
