#pragma once

// Internal (not installed: no header of ours shows yaml-cpp to users).

#include <yaml-cpp/yaml.h>

#include <span>
#include <string>
#include <vector>

namespace srmp::io {

/// A YAML file with one document. Every complaint is a FileError that names file and line.
class YamlFile {
 public:
  /// `language`: what the file is said to be written in, where it is not valid; all JSON is YAML.
  explicit YamlFile(const std::string& path, const std::string& language = "YAML");

  const YAML::Node& root() const { return root_; }
  const std::string& path() const { return path_; }

  /// "path:line", or "path" where the node has no place.
  std::string where(const YAML::Node& node) const;
  [[noreturn]] void fail(const YAML::Node& node, const std::string& what) const;
  /// For what is right but not done here: NotSupported.
  [[noreturn]] void unsupported(const YAML::Node& node, const std::string& what) const;

  /// `node` is a map with none but the known keys, each once. `what` names it in complaints.
  void require_map(const YAML::Node& node, const std::string& what, std::span<const std::string> known) const;
  void require_list(const YAML::Node& node, const std::string& what) const;
  /// The value of a key that must be there.
  YAML::Node require(const YAML::Node& map, const std::string& key, const std::string& what) const;

  double number(const YAML::Node& node, const std::string& what) const;  ///< finite
  std::vector<double> numbers(const YAML::Node& node, const std::string& what) const;
  std::vector<double> numbers(const YAML::Node& node, const std::string& what, std::size_t count) const;
  std::string text(const YAML::Node& node, const std::string& what) const;
  std::vector<std::string> texts(const YAML::Node& node, const std::string& what) const;
  bool boolean(const YAML::Node& node, const std::string& what) const;

 private:
  std::string path_;
  YAML::Node root_;
};

/// Absent, null, "", [] or {}.
bool is_empty(const YAML::Node& node);

}  // namespace srmp::io
