#pragma once

#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "kinect_ekf_slam/estimators/kalman_slam.h"
#include "kinect_ekf_slam/mapping/life_cycle_options.h"

namespace kinect_ekf_slam {

/// Decides which landmarks are real: confirms, forgets, merges, and takes off what is not there.
///
/// Knows each landmark by its id, and how often it was seen and should have been. (docs/theory.md,
/// section 10.)
template <class Space>
class LifeCycle {
 public:
  explicit LifeCycle(const LifeCycleOptions& options);

  /// After an update: the report says what was seen, and then what became of the map.
  void keep(TimeNs stamp, const std::vector<Observation<Space>>& observations, KalmanSlam<Space>* filter,
            UpdateReport* report);
  /// Of a map that was loaded nothing is known but that its landmarks are there.
  void clear() {
    records_.clear();
    seen_together_.clear();
    last_merged_ = 0;
  }

 private:
  struct Record {
    typename Space::Pose first_seen_from;
    TimeNs first_seen = 0;
    bool confirmed = false;
    TimeNs last_seen = 0;
    int sightings = 0;
    int visits = 1;  ///< with sightings, far apart in time
    int misses = 0;  ///< looks that should have shown it and did not
    // The same since it was last seen.
    TimeNs last_missed = 0;
    int misses_of_visit = 0;
    bool is_in_vain = false;  ///< the present visit
    int visits_in_vain = 0;
    /// While it is provisional: frames with sightings of others since it was first seen, by their ids.
    std::map<int, int> company;

    double detection_rate() const { return static_cast<double>(sightings) / (sightings + misses); }
    void start_visit() {
      misses_of_visit = 0;
      is_in_vain = false;
    }
    /// Whether a landmark that is there is missed in so many looks in a row with more than this probability:
    /// by its detection rate before, of which few looks tell little (Laplace's rule of succession).
    bool may_be_chance(double probability) const {
      const int before = misses - misses_of_visit;
      return std::pow((before + 1.0) / (sightings + before + 2.0), misses_of_visit) > probability;
    }
  };

  void count_sightings(TimeNs stamp, KalmanSlam<Space>* filter, UpdateReport* report);
  void count_misses(TimeNs stamp, const std::vector<Observation<Space>>& observations,
                    KalmanSlam<Space>* filter, UpdateReport* report);
  void remove_unlikely(TimeNs stamp, KalmanSlam<Space>* filter, UpdateReport* report);
  /// What was known of a landmark that turned out to be another one.
  void take_over(int dropped_id, int kept_id);
  void merge_duplicates(KalmanSlam<Space>* filter, UpdateReport* report);
  void take_over_company(int dropped, int kept);
  bool is_in_view(const typename Space::Point& point_in_base) const;
  bool is_hidden(const typename Space::Point& point_in_base,
                 const std::vector<Observation<Space>>& observations,
                 const std::vector<Assignment>& assignments) const;
  bool is_twin(int id, const Record& record, const KalmanSlam<Space>& filter) const;
  bool deserves_belief(const Record& record, const typename Space::Pose& map_from_base) const;

  LifeCycleOptions options_;
  double merge_gate_;
  std::map<int, Record> records_;                     ///< by landmark id; landmarks of a loaded map have none
  std::map<std::pair<int, int>, int> seen_together_;  ///< frames, by the lower and the higher id
  TimeNs last_merged_ = 0;
};

}  // namespace kinect_ekf_slam
