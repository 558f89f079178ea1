#pragma once

// Internal (not installed: no public header includes yaml-cpp).
//
// One function per struct, `describe(archive, value)`, lists its fields for both writing and reading:
//
//   template <class Archive>
//   void describe(Archive& archive, Ref<Archive, Sphere> sphere) {
//     archive("radius", sphere.radius);
//   }
//
// Numbers read back bit for bit. JSON has no infinity and no NaN: they are the strings "inf", "-inf" and "nan".

#include <Eigen/Core>
#include <array>
#include <concepts>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "srmp/core/error.hpp"
#include "srmp/core/matrix.hpp"
#include "srmp/core/pose.hpp"
#include "srmp/io/yaml_reader.h"

namespace srmp::io {

/// What `describe` takes: const T& to write it, T& to read it.
template <class Archive, class T>
using Ref = typename Archive::template Ref<T>;

/// What files now have for the name of an enum's value; specialised for enums of which some had other names.
template <class Enum>
std::string current_name(const std::string& name) {
  return name;
}

/// The value of an enum, whose values count from 0, with this name by to_string; nullopt: there is none, and `known`
/// holds all names.
template <class Enum>
std::optional<Enum> enum_of(const std::string& text, std::vector<std::string>& known) {
  const std::string required = current_name<Enum>(text);
  for (int i = 0;; ++i) {
    const std::string name(to_string(static_cast<Enum>(i)));
    if (name == "unknown") return std::nullopt;
    if (name == required) return static_cast<Enum>(i);
    known.push_back(name);
  }
}

/// A value of one of several types.
using JsonValue = std::variant<bool, double, std::string, std::vector<std::string>>;

/// Writes JSON with every key and every row of numbers on a line of its own, so that errors can name the line.
class JsonWriter {
 public:
  template <class T>
  using Ref = const T&;
  static constexpr bool reading = false;

  /// Begins a map.
  JsonWriter();
  /// Begins a file of this format.
  explicit JsonWriter(const std::string& format);
  /// Ends the map.
  std::string text();
  /// Ends the map and writes the file atomically. Throws FileError.
  void save(const std::string& path);

  template <class T>
  void operator()(const char* key, const T& value) {
    write_key(key);
    write(value);
  }
  template <class T>
  void operator()(const char* key, const std::optional<T>& value) {
    if (value) operator()(key, *value);
  }
  template <class T>
  void operator()(const char* key, const std::shared_ptr<const T>& value) {
    if (value) operator()(key, *value);
  }

 private:
  void write(double value);
  void write(bool value) { emitter_ << value; }
  void write(int value) { emitter_ << value; }
  void write(std::uint64_t value) { emitter_ << value; }
  void write(const std::string& value) { emitter_ << value; }
  void write(const Eigen::VectorXd& value) { write_numbers({value.data(), static_cast<std::size_t>(value.size())}); }
  void write(const Eigen::Vector3d& value) { write_numbers({value.data(), 3}); }
  void write(const Pose& value) { write_numbers(value.to_list()); }
  void write(const RowMatrix& value) {
    begin_list();
    for (Eigen::Index i = 0; i < value.rows(); ++i) {
      begin_item();
      write_numbers({value.data() + i * value.cols(), static_cast<std::size_t>(value.cols())});
    }
    end_list();
  }
  void write(const std::array<int, 3>& value) { write_items(value); }
  void write(const std::vector<bool>& value) { write_items(value); }
  template <class T>
  void write(const std::vector<T>& value) {
    write_items(value);
  }
  void write(const JsonValue& value) {
    std::visit([&](const auto& one) { write(one); }, value);
  }
  template <class T>
  void write(const std::map<std::string, T>& value) {
    begin_map();
    for (const auto& [key, item] : value) operator()(key.c_str(), item);
    end_map();
  }
  template <class T>
    requires std::is_enum_v<T>
  void write(const T& value) {
    write(std::string(to_string(value)));
  }
  template <class T>
    requires std::is_class_v<T>
  void write(const T& value) {
    begin_map();
    describe(*this, value);
    end_map();
  }

  template <class List>
  void write_items(const List& list) {
    using Item = typename List::value_type;
    begin_list();
    for (const Item& item : list) {
      if constexpr (!std::is_arithmetic_v<Item> && !std::same_as<Item, std::string>) begin_item();
      write(item);
    }
    end_list();
  }
  void write_numbers(std::span<const double> values);
  void write_key(const std::string& key);
  void begin_item();  // of a list, on a line of its own
  void begin_list();
  void end_list();
  void begin_map();
  void end_map();

  YAML::Emitter emitter_;
};

/// Reads one map of a file. Every error is a FileError that names file, line and place, such as
/// "scene.objects[2].pose".
class JsonReader {
 public:
  template <class T>
  using Ref = T&;
  static constexpr bool reading = true;

  JsonReader(const YamlFile& file, const YAML::Node& map, std::string place);
  /// To be called when all has been read: refuses keys that were not read.
  void finish() const;

  bool has(const std::string& key) const { return map_[key].IsDefined(); }
  /// The map under the key.
  JsonReader inner(const char* key);
  /// A reader for each map in the list under the key.
  std::vector<JsonReader> items(const char* key);
  [[noreturn]] void fail(const std::string& what) const;
  /// Runs `call`; errors that it throws are reported for this place.
  template <class Call>
  auto guarded(Call&& call) const {
    try {
      return call();
    } catch (const Error& error) {
      fail(error.what());
    }
  }

  template <class T>
  void operator()(const char* key, T& value) {
    read(child(key), place_of(key), value);
  }
  template <class T>
  void operator()(const char* key, std::optional<T>& value) {
    known_.emplace_back(key);
    value.reset();
    if (has(key)) read(map_[key], place_of(key), value.emplace());
  }
  template <class T>
  void operator()(const char* key, std::shared_ptr<const T>& value) {
    std::optional<T> read;
    operator()(key, read);
    value = read ? std::make_shared<const T>(std::move(*read)) : nullptr;
  }

 private:
  using Node = YAML::Node;

  Node child(const char* key);  // which must be there
  void read(const Node& node, const std::string& place, double& value) const;
  void read(const Node& node, const std::string& place, bool& value) const { value = file_.boolean(node, place); }
  void read(const Node& node, const std::string& place, int& value) const;
  void read(const Node& node, const std::string& place, std::uint64_t& value) const;
  void read(const Node& node, const std::string& place, std::string& value) const { value = file_.text(node, place); }
  void read(const Node& node, const std::string& place, Eigen::VectorXd& value) const;
  void read(const Node& node, const std::string& place, Eigen::Vector3d& value) const;
  void read(const Node& node, const std::string& place, Pose& value) const;
  /// Rows of one length.
  void read(const Node& node, const std::string& place, RowMatrix& value) const;
  void read(const Node& node, const std::string& place, std::array<int, 3>& value) const;
  void read(const Node& node, const std::string& place, std::vector<bool>& value) const;
  void read(const Node& node, const std::string& place, JsonValue& value) const;
  template <class T>
  void read(const Node& node, const std::string& place, std::vector<T>& value) const {
    file_.require_list(node, place);
    value.clear();
    value.reserve(node.size());
    for (const Node& item : node) {
      const std::string item_place = place + "[" + std::to_string(value.size()) + "]";
      read(item, item_place, value.emplace_back());
    }
  }
  template <class T>
  void read(const Node& node, const std::string& place, std::map<std::string, T>& value) const {
    if (!node.IsMap()) file_.fail(node, place + " must be a map of keys and values");
    value.clear();
    for (const auto& entry : node) {
      const std::string key = file_.text(entry.first, "a key of " + place);
      const auto [slot, is_new] = value.try_emplace(key);
      if (!is_new) file_.fail(entry.first, "key '" + key + "' appears twice in " + place);
      read(entry.second, place + "." + key, slot->second);
    }
  }
  template <class T>
    requires std::is_enum_v<T>
  void read(const Node& node, const std::string& place, T& value) const {
    std::vector<std::string> known;
    const auto found = enum_of<T>(file_.text(node, place), known);
    if (!found) file_.fail(node, place + " is '" + node.Scalar() + "'; known are " + quoted_list(known));
    value = *found;
  }
  template <class T>
    requires std::is_class_v<T>
  void read(const Node& node, const std::string& place, T& value) const {
    JsonReader inner(file_, node, place);
    describe(inner, value);
    inner.finish();
  }

  std::string place_of(const std::string& key) const { return place_.empty() ? key : place_ + "." + key; }
  std::vector<double> numbers(const Node& node, const std::string& place) const;
  std::vector<double> numbers(const Node& node, const std::string& place, std::size_t count) const;

  const YamlFile& file_;
  Node map_;
  std::string place_;
  std::vector<std::string> known_;
};

/// A file of this library, once it is known to be of one of these formats and of a version that is read here.
class JsonFile {
 public:
  JsonFile(YamlFile file, std::span<const std::string> formats);
  JsonFile(const std::string& path, std::span<const std::string> formats) : JsonFile(YamlFile(path, "JSON"), formats) {}

  const std::string& format() const { return format_; }
  /// Its outermost map, but for what the constructor has read.
  JsonReader root() const;

 private:
  YamlFile file_;
  std::string format_;
};

inline const std::string problem_format = "srmp problem", scene_format = "srmp scene",
                         trajectory_format = "srmp trajectory";

/// A value whose key is left out where there is none: older files have none either.
template <class Archive, class T>
void describe_if(Archive& archive, const char* key, T& value, bool is_there) {
  if constexpr (Archive::reading) {
    if (archive.has(key)) archive(key, value);
  } else {
    if (is_there) archive(key, value);
  }
}
template <class Archive, class List>
void describe_list(Archive& archive, const char* key, List& list) {
  describe_if(archive, key, list, !list.empty());
}

}  // namespace srmp::io
