#pragma once

#include <functional>
#include <string>
#include <vector>

#include "kinect_ekf_slam/core/compatibility.h"

namespace kinect_ekf_slam {

/// The words that a tool was started with, one after the other. What is wrong with them ends the program with
/// one line and exit code 2.
class CommandLine {
 public:
  CommandLine(const char* program, const char* usage, int argc, char** argv)
      : program_(program), usage_(usage), words_(argv + 1, argv + argc) {}

  /// Goes to the next word; false at the end. `--help` prints the usage and ends the program.
  bool next();
  const std::string& word() const { return words_[position_ - 1]; }
  bool is_option() const { return word().size() > 1 && word().front() == '-'; }

  /// The word that belongs to the present one.
  std::string value();
  /// The words of the form `name=value` that belong to the present one, at least one.
  std::vector<std::string> assignments();
  /// The number that belongs to the present word, from `low` to `high`.
  template <class Number>
  Number number(Number low, Number high, const std::string& allowed);

  [[noreturn]] void fail(const std::string& line) const;
  [[noreturn]] void fail_at_word(const std::string& what) const {
    fail(word() + ": " + what + "; see --help");
  }

 private:
  std::string program_;
  std::string usage_;
  std::vector<std::string> words_;
  std::size_t position_ = 0;
};

/// Shows the share done, 0 to 1, as a bar on a terminal; empty where there is none.
std::function<void(double)> progress_bar();
void clear_progress_bar();

template <class Number>
Number CommandLine::number(Number low, Number high, const std::string& allowed) {
  const std::string option = word();
  const std::string text = value();
  Number number{};
  if (!read_number(text, &number) || !(number >= low && number <= high)) {
    fail(std::string(option).append(": '").append(text).append("' given, allowed: ").append(allowed));
  }
  return number;
}

}  // namespace kinect_ekf_slam
