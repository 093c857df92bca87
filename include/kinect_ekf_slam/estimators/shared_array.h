#pragma once

#include <memory>
#include <optional>
#include <utility>

namespace kinect_ekf_slam {

/// An array whose copies share what they have in common: a copy is O(1), reading or changing an entry O(log
/// n).
///
/// A binary tree whose node i has the children 2 i + 1 and 2 i + 2: the indices of a map's landmarks are
/// dense, so it is balanced without any work. A node that a copy shares is copied when the way to a change
/// leads through it (path copying: Driscoll et al., "Making data structures persistent", 1989). An entry may
/// be missing.
template <class Value>
class SharedArray {
 public:
  /// The entry, null: missing. It lives until the next change.
  const Value* find(int index) const {
    const Node* node = root_.get();
    for (int level = top_level(index); node != nullptr && level > 0; --level) {
      node = node->children[turn(index, level)].get();
    }
    return node != nullptr && node->value ? &*node->value : nullptr;
  }

  void set(int index, Value value) { own(index)->value = std::move(value); }
  void erase(int index) {
    if (find(index) != nullptr) own(index)->value.reset();
  }
  void clear() { root_.reset(); }

 private:
  struct Node {
    std::optional<Value> value;
    std::shared_ptr<Node> children[2];
  };

  /// The binary digits of index + 1 below the leading one are the way from the root, 0: left.
  static int top_level(int index) {
    int level = 0;
    while ((index + 1) >> (level + 1) != 0) ++level;
    return level;
  }
  static int turn(int index, int level) { return ((index + 1) >> (level - 1)) & 1; }

  /// The node of an entry, after every node on the way was made this array's own.
  Node* own(int index) {
    std::shared_ptr<Node>* link = &root_;
    for (int level = top_level(index);; --level) {
      if (!*link) {
        *link = std::make_shared<Node>();
      } else if (link->use_count() > 1) {
        *link = std::make_shared<Node>(**link);
      }
      if (level == 0) return link->get();
      link = &(*link)->children[turn(index, level)];
    }
  }

  std::shared_ptr<Node> root_;
};

}  // namespace kinect_ekf_slam
