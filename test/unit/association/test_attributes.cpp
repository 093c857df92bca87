/// What a sighting tells besides its place: label, radius, descriptor.
#include <gtest/gtest.h>

#include <cmath>

#include "kinect_ekf_slam/association/nearest_neighbor.h"
#include "test/support/fake_map.h"

namespace kinect_ekf_slam {
namespace {

using testing::FakeMap;
using testing::sighting;

Observation<Planar> labelled(const Eigen::Vector2d& point_in_base, const std::string& label) {
  Observation<Planar> observation = sighting(point_in_base);
  observation.signature.label = label;
  return observation;
}

LandmarkInfo known(const std::string& label, double radius = 0.0) {
  LandmarkInfo info;
  Signature signature;
  signature.label = label;
  signature.radius = radius;
  info.add(1, signature);
  return info;
}

Signature signature_of(const std::string& label, double radius = 0.0) {
  Signature signature;
  signature.label = label;
  signature.radius = radius;
  return signature;
}

TEST(AttributeDistance, WhatEitherSideDoesNotKnowAddsNothing) {
  AssociationOptions options;
  options.radius_sigma = 0.01;
  options.descriptor_sigma = 1.0;
  Signature full = signature_of("red", 0.1);
  full.descriptor = {1.0F, 2.0F};
  EXPECT_EQ(attribute_distance(full, LandmarkInfo(), options), 0.0);
  LandmarkInfo rich = known("red", 0.1);
  rich.descriptor = {5.0F, 2.0F};
  EXPECT_EQ(attribute_distance(Signature(), rich, options), 0.0);
  Signature other_size;
  other_size.descriptor = {1.0F, 2.0F, 3.0F};
  EXPECT_EQ(attribute_distance(other_size, rich, options), 0.0) << "descriptors that cannot be compared";
}

TEST(AttributeDistance, AnotherLabelCostsWhatItsMisreadingIsLikely) {
  AssociationOptions options;
  options.label_error = 0.05;
  EXPECT_EQ(attribute_distance(signature_of("red"), known("red"), options), 0.0);
  EXPECT_NEAR(attribute_distance(signature_of("blue"), known("red"), options), 2.0 * std::log(19.0), 1e-12);
  options.label_error = 0.5;  // a coin tells as much
  EXPECT_NEAR(attribute_distance(signature_of("blue"), known("red"), options), 0.0, 1e-12);
}

TEST(AttributeDistance, RadiiAreComparedInTheirSigmas) {
  AssociationOptions options;
  EXPECT_EQ(attribute_distance(signature_of("", 0.2), known("", 0.1), options), 0.0) << "not asked for";
  options.radius_sigma = 0.02;
  EXPECT_NEAR(attribute_distance(signature_of("", 0.14), known("", 0.1), options), 0.04 * 0.04 / (2 * 4e-4),
              1e-9)
      << "one sighting each";
  LandmarkInfo often = known("", 0.1);
  for (int i = 0; i < 99; ++i) often.add(1, signature_of("", 0.1));
  EXPECT_NEAR(attribute_distance(signature_of("", 0.14), often, options), 4.0 / 1.01, 1e-9)
      << "the map's mean is known better";
}

TEST(AttributeDistance, DescriptorsAreComparedByTheirDifference) {
  AssociationOptions options;
  LandmarkInfo info;
  info.descriptor = {1.0F, 2.0F};
  Signature seen;
  seen.descriptor = {4.0F, 6.0F};
  EXPECT_EQ(attribute_distance(seen, info, options), 0.0) << "not asked for";
  options.descriptor_sigma = 2.5;
  EXPECT_NEAR(attribute_distance(seen, info, options), 4.0, 1e-6);
}

class Gating : public ::testing::Test {
 protected:
  Gating() { map_.known_of(0) = known("red"); }
  Assignment associate(const Observation<Planar>& observation) const {
    return NearestNeighbor<Planar>(options_).associate({observation}, map_)[0];
  }
  FakeMap map_ = FakeMap().add({1.0, 0.0});
  AssociationOptions options_;
};

TEST_F(Gating, AMisreadLabelMakesAMatchLessLikelyNotImpossible) {
  const Assignment right = associate(labelled({1.02, 0.0}, "red"));
  const Assignment misread = associate(labelled({1.02, 0.0}, "blue"));
  EXPECT_EQ(right.verdict, Verdict::kMatched);
  EXPECT_EQ(misread.verdict, Verdict::kMatched);
  EXPECT_GT(misread.squared_distance, right.squared_distance + 5.0);
}

TEST_F(Gating, TheLabelDecidesBetweenTwoThatAreNear) {
  map_.add({1.1, 0.0});
  map_.known_of(1) = known("blue");
  EXPECT_EQ(associate(labelled({1.04, 0.0}, "blue")).landmark, 1);
  EXPECT_EQ(associate(labelled({1.06, 0.0}, "red")).landmark, 0);
  EXPECT_EQ(associate(sighting({1.06, 0.0})).landmark, 1);
}

TEST_F(Gating, AVetoedPairIsAmbiguousAndNotNew) {
  options_.label_error = 1e-6;
  const Assignment vetoed = associate(labelled({1.0, 0.0}, "blue"));
  EXPECT_EQ(vetoed.verdict, Verdict::kAmbiguous);
  EXPECT_EQ(vetoed.landmark, 0);
}

TEST_F(Gating, NoAttributeBringsAPairInsideTheGate) {
  options_.radius_sigma = 0.01;
  map_.known_of(0) = known("red", 0.1);
  Observation<Planar> alike = labelled({1.25, 0.0}, "red");
  alike.signature.radius = 0.1;
  EXPECT_EQ(associate(alike).verdict, associate(sighting({1.25, 0.0})).verdict);
  EXPECT_EQ(associate(alike).verdict, Verdict::kAmbiguous);
  alike.position_in_base.x() = 2.0;
  EXPECT_EQ(associate(alike).verdict, Verdict::kCreated);
}

}  // namespace
}  // namespace kinect_ekf_slam
