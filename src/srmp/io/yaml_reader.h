#pragma once

// Internal (not installed: no public header includes yaml-cpp).

#include <yaml-cpp/yaml.h>

#include <span>
#include <string>
#include <vector>

namespace srmp::io {

/// A YAML file with one document. Every error is a FileError that names file and line.
class YamlFile {
 public:
  /// `language`: of the file, for errors about its syntax (all JSON is YAML).
  explicit YamlFile(const std::string& path, const std::string& language = "YAML");

  const YAML::Node& root() const { return root_; }
  const std::string& path() const { return path_; }

  /// "path:line", or "path" for a node without a position.
  std::string where(const YAML::Node& node) const;
  [[noreturn]] void fail(const YAML::Node& node, const std::string& what) const;
  /// Throws NotSupported, for what is valid but not supported.
  [[noreturn]] void unsupported(const YAML::Node& node, const std::string& what) const;

  /// Requires that `node` is a map of known keys, each once. `what` names it in errors.
  void require_map(const YAML::Node& node, const std::string& what, std::span<const std::string> known) const;
  void require_list(const YAML::Node& node, const std::string& what) const;
  /// The value of a required key.
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
