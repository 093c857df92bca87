#include "kinect_ekf_slam/ros/parameter_server.h"

#include "kinect_ekf_slam/ros/names.h"
#include "kinect_ekf_slam/ros/parameters.h"

namespace kinect_ekf_slam {

YAML::Node to_yaml(XmlRpc::XmlRpcValue value) {
  YAML::Node node;
  switch (value.getType()) {
    case XmlRpc::XmlRpcValue::TypeBoolean:
      node = static_cast<bool>(value);
      break;
    case XmlRpc::XmlRpcValue::TypeInt:
      node = static_cast<int>(value);
      break;
    case XmlRpc::XmlRpcValue::TypeDouble:
      node = static_cast<double>(value);
      break;
    case XmlRpc::XmlRpcValue::TypeString:
      node = static_cast<std::string>(value);
      break;
    case XmlRpc::XmlRpcValue::TypeArray:
      node = YAML::Node(YAML::NodeType::Sequence);
      for (int i = 0; i < value.size(); ++i) node.push_back(to_yaml(value[i]));
      break;
    case XmlRpc::XmlRpcValue::TypeStruct:
      node = YAML::Node(YAML::NodeType::Map);
      for (auto& member : value) node[member.first] = to_yaml(member.second);
      break;
    default:
      throw ParameterError("the parameter server holds a value that is no number, text, list or group");
  }
  return node;
}

YAML::Node parameters_of(const ros::NodeHandle& private_handle) {
  XmlRpc::XmlRpcValue value;
  if (!private_handle.getParam("", value) || value.getType() != XmlRpc::XmlRpcValue::TypeStruct) {
    return YAML::Node(YAML::NodeType::Map);
  }
  YAML::Node yaml = to_yaml(value);
  for (const char* foreign : {names::kLive, "diagnostic_period"}) yaml.remove(foreign);
  return yaml;
}

}  // namespace kinect_ekf_slam
