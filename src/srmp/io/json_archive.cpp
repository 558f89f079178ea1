#include "srmp/io/json_archive.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "srmp/core/interruption.hpp"
#include "srmp/core/version.hpp"
#include "srmp/core/write_file.hpp"

namespace srmp::io {

namespace {

using YAML::Node;

constexpr int format_version = 1;
constexpr double inf = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();

bool is_quoted(const Node& node) { return node.Tag() == "!"; }

template <class Whole>
Whole whole_number(const YamlFile& file, const Node& node, const std::string& place) {
  const std::string text = file.text(node, place);
  Whole value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || is_quoted(node))
    file.fail(node, place + " must be a whole number" + (std::is_unsigned_v<Whole> ? ", 0 or above," : "") + " not '" +
                        text + "'");
  return value;
}

double real(const YamlFile& file, const Node& node, const std::string& place) {
  if (!node.IsScalar() || !is_quoted(node)) return file.number(node, place);
  if (node.Scalar() == "inf") return inf;
  if (node.Scalar() == "-inf") return -inf;
  if (node.Scalar() == "nan") return nan;
  file.fail(node,
            place + " must be a number, or one of the strings 'inf', '-inf' and 'nan', not '" + node.Scalar() + "'");
}

}  // namespace

// --- writing

JsonWriter::JsonWriter() {
  emitter_.SetOutputCharset(YAML::EscapeAsJson);
  emitter_.SetStringFormat(YAML::DoubleQuoted);
  emitter_.SetMapFormat(YAML::Flow);
  emitter_.SetSeqFormat(YAML::Flow);
  emitter_.SetIndent(1);
  begin_map();
}

JsonWriter::JsonWriter(const std::string& format) : JsonWriter() {
  operator()("format", format);
  operator()("format_version", format_version);
  operator()("srmp_version", std::string(version()));
}

std::string JsonWriter::text() {
  end_map();
  return {emitter_.c_str(), emitter_.size()};
}

void JsonWriter::save(const std::string& path) { write_file(path, text() + "\n"); }

void JsonWriter::write(double value) {
  if (std::isnan(value))
    emitter_ << "nan";
  else if (std::isinf(value))
    emitter_ << (value > 0 ? "inf" : "-inf");
  else if (value == 0.0 && std::signbit(value))
    emitter_ << YAML::Auto << "-0.0";  // many readers take "-0" for an integer, which has no negative zero
  else
    emitter_ << YAML::Auto << to_text(value);
}

void JsonWriter::write_numbers(std::span<const double> values) {
  begin_list();
  for (const double value : values) write(value);
  end_list();
}

void JsonWriter::write_key(const std::string& key) { emitter_ << YAML::Newline << YAML::Key << key << YAML::Value; }
void JsonWriter::begin_item() { emitter_ << YAML::Newline; }
void JsonWriter::begin_list() { emitter_ << YAML::BeginSeq; }
void JsonWriter::end_list() { emitter_ << YAML::EndSeq; }
void JsonWriter::begin_map() { emitter_ << YAML::BeginMap; }
void JsonWriter::end_map() { emitter_ << YAML::EndMap; }

// --- reading

JsonReader::JsonReader(const YamlFile& file, const Node& map, std::string place)
    : file_(file), map_(map), place_(std::move(place)) {
  if (!map.IsMap()) file.fail(map, (place_.empty() ? "the file" : place_) + " must be a map of keys and values");
}

void JsonReader::finish() const { file_.require_map(map_, place_.empty() ? "the file" : place_, known_); }

void JsonReader::fail(const std::string& what) const { file_.fail(map_, (place_.empty() ? "" : place_ + ": ") + what); }

Node JsonReader::child(const char* key) {
  known_.emplace_back(key);
  if (!has(key)) fail("it has no '" + std::string(key) + "'");
  return map_[key];
}

JsonReader JsonReader::inner(const char* key) { return {file_, child(key), place_of(key)}; }

std::vector<JsonReader> JsonReader::items(const char* key) {
  const Node list = child(key);
  file_.require_list(list, place_of(key));
  std::vector<JsonReader> readers;
  for (const Node& item : list)
    readers.emplace_back(file_, item, place_of(key) + "[" + std::to_string(readers.size()) + "]");
  return readers;
}

void JsonReader::read(const Node& node, const std::string& place, double& value) const {
  value = real(file_, node, place);
}

void JsonReader::read(const Node& node, const std::string& place, int& value) const {
  value = whole_number<int>(file_, node, place);
}

void JsonReader::read(const Node& node, const std::string& place, std::uint64_t& value) const {
  value = whole_number<std::uint64_t>(file_, node, place);
}

void JsonReader::read(const Node& node, const std::string& place, Eigen::VectorXd& value) const {
  const std::vector<double> read = numbers(node, place);
  value = Eigen::Map<const Eigen::VectorXd>(read.data(), static_cast<Eigen::Index>(read.size()));
}

void JsonReader::read(const Node& node, const std::string& place, Eigen::Vector3d& value) const {
  value = Eigen::Map<const Eigen::Vector3d>(numbers(node, place, 3).data());
}

void JsonReader::read(const Node& node, const std::string& place, Pose& value) const {
  const std::vector<double> v = numbers(node, place, 7);
  value = {{v[0], v[1], v[2]}, {v[6], v[3], v[4], v[5]}};  // not normalised, so that it reads back bit for bit
}

void JsonReader::read(const Node& node, const std::string& place, RowMatrix& value) const {
  std::vector<Eigen::VectorXd> rows;
  read(node, place, rows);
  value.resize(static_cast<Eigen::Index>(rows.size()), rows.empty() ? 0 : rows[0].size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].size() != value.cols())
      file_.fail(node[i], place + "[" + std::to_string(i) + "] is " + std::to_string(rows[i].size()) +
                              " numbers, but the row before it " + std::to_string(value.cols()) +
                              "; all rows have one length");
    value.row(static_cast<Eigen::Index>(i)) = rows[i].transpose();
  }
}

void JsonReader::read(const Node& node, const std::string& place, std::array<int, 3>& value) const {
  std::vector<int> read_numbers;
  read(node, place, read_numbers);
  if (read_numbers.size() != 3)
    file_.fail(node, place + " must be 3 numbers, not " + std::to_string(read_numbers.size()));
  std::copy(read_numbers.begin(), read_numbers.end(), value.begin());
}

void JsonReader::read(const Node& node, const std::string& place, std::vector<bool>& value) const {
  file_.require_list(node, place);
  value.clear();
  for (const Node& item : node) value.push_back(file_.boolean(item, place));
}

void JsonReader::read(const Node& node, const std::string& place, JsonValue& value) const {
  if (node.IsSequence())
    value = file_.texts(node, place);
  else if (is_quoted(node))
    value = node.Scalar();
  else if (node.IsScalar() && (node.Scalar() == "true" || node.Scalar() == "false"))
    value = node.Scalar() == "true";
  else
    value = file_.number(node, place);
}

std::vector<double> JsonReader::numbers(const Node& node, const std::string& place) const {
  file_.require_list(node, place);
  std::vector<double> values;
  values.reserve(node.size());
  for (const Node& item : node) {
    interruption_point();
    values.push_back(real(file_, item, place));
  }
  return values;
}

std::vector<double> JsonReader::numbers(const Node& node, const std::string& place, std::size_t count) const {
  std::vector<double> values = numbers(node, place);
  if (values.size() != count)
    file_.fail(node, place + " must be " + std::to_string(count) + " numbers, not " + std::to_string(values.size()));
  return values;
}

// --- files

JsonFile::JsonFile(YamlFile file, std::span<const std::string> formats) : file_(std::move(file)) {
  const Node& root = file_.root();
  std::string expected = "expected is a JSON map with \"format\": ";
  for (const std::string& format : formats) expected += (&format == &formats.front() ? "'" : " or '") + format + "'";
  if (!root.IsMap()) file_.fail(root, "this is no file of srmp; " + expected);
  if (!root["format"].IsDefined()) file_.fail(root, "it does not say its format; " + expected);
  format_ = file_.text(root["format"], "format");
  if (std::find(formats.begin(), formats.end(), format_) == formats.end())
    file_.fail(root["format"], "the format is '" + format_ + "'; " + expected);
  int number{};
  std::string wrote;
  JsonReader reader(file_, root, "");
  reader("format_version", number);
  reader("srmp_version", wrote);
  if (number > format_version)
    file_.fail(root["format_version"], "srmp " + wrote + " wrote version " + std::to_string(number) +
                                           " of the format '" + format_ + "', and srmp " + std::string(version()) +
                                           " reads version " + std::to_string(format_version) + "; use a newer srmp");
  if (number < 1) file_.fail(root["format_version"], "format_version is " + std::to_string(number) + "; it must be 1");
}

JsonReader JsonFile::root() const {
  JsonReader reader(file_, file_.root(), "");
  std::string text;
  int number{};
  reader("format", text);
  reader("format_version", number);
  reader("srmp_version", text);
  return reader;
}

}  // namespace srmp::io
