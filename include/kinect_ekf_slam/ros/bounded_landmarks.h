#pragma once

#include <kinect_ekf_slam/LandmarkDetectionArray.h>

#include <cstdint>

namespace kinect_ekf_slam {

/// Landmarks as they are received. ros::serialization makes room for as many elements as a list says that it
/// has before it looks for them: four damaged bytes would cost gigabytes. This message is read with its lists
/// held to what its bytes can hold; a longer one is a StreamOverrunException, as when any message ends early.
struct BoundedLandmarks : LandmarkDetectionArray {
  using Ptr = boost::shared_ptr<BoundedLandmarks>;
  using ConstPtr = boost::shared_ptr<const BoundedLandmarks>;
};

}  // namespace kinect_ekf_slam

namespace ros {
namespace message_traits {

template <>
struct MD5Sum<kinect_ekf_slam::BoundedLandmarks> : MD5Sum<kinect_ekf_slam::LandmarkDetectionArray> {};
template <>
struct DataType<kinect_ekf_slam::BoundedLandmarks> : DataType<kinect_ekf_slam::LandmarkDetectionArray> {};
template <>
struct Definition<kinect_ekf_slam::BoundedLandmarks> : Definition<kinect_ekf_slam::LandmarkDetectionArray> {};
template <>
struct HasHeader<kinect_ekf_slam::BoundedLandmarks> : TrueType {};

}  // namespace message_traits

namespace serialization {

template <>
struct Serializer<kinect_ekf_slam::BoundedLandmarks> {
  static void read(IStream& stream, kinect_ekf_slam::BoundedLandmarks& message) {
    stream.next(message.header);
    message.detections.resize(length_of_list<kinect_ekf_slam::LandmarkDetection>(stream));
    for (kinect_ekf_slam::LandmarkDetection& detection : message.detections) {
      stream.next(detection.id);
      stream.next(detection.label);
      stream.next(detection.position);
      stream.next(detection.covariance);
      stream.next(detection.radius);
      detection.descriptor.resize(length_of_list<float>(stream));
      for (float& number : detection.descriptor) stream.next(number);
      stream.next(detection.score);
    }
  }

 private:
  template <class Element>
  static std::uint32_t length_of_list(IStream& stream) {
    std::uint32_t length = 0;
    stream.next(length);
    if (length > stream.getLength() / serializationLength(Element()))
      throw StreamOverrunException("a list is longer than its message");
    return length;
  }
};

}  // namespace serialization
}  // namespace ros
