#include "srmp/io/yaml_reader.h"

#include <yaml-cpp/eventhandler.h>

#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "srmp/core/error.hpp"
#include "srmp/core/run_interruptibly.hpp"
#include "srmp/core/utf8.hpp"

namespace srmp::io {

namespace {

/// rostopic ends files with "---", which starts another, empty document.
YAML::Node only_document(const std::string& path, const std::vector<YAML::Node>& documents) {
  const YAML::Node* found = nullptr;
  for (const YAML::Node& document : documents) {
    if (document.IsNull()) continue;
    if (found)
      throw FileError(path + ":" + std::to_string(document.Mark().line + 1) +
                      ": a second document starts here; only one document per file is supported");
    found = &document;
  }
  if (!found) throw FileError(path + ": the file is empty");
  return *found;
}

std::string text_of(const std::string& path, const std::string& language) {
  std::error_code code;
  if (!std::filesystem::exists(path, code)) throw FileError(path + ": there is no such file");
  if (std::filesystem::is_directory(path, code)) throw FileError(path + ": this is a directory, not a file");
  if (!std::filesystem::is_regular_file(path, code)) throw FileError(path + ": this is not a file");
  std::ifstream file(path, std::ios::binary);
  std::ostringstream content;
  content << file.rdbuf();
  if (!file) throw FileError(path + ": the file cannot be read");
  std::string text = std::move(content).str();
  if (const std::size_t bad = find_invalid_utf8(text); bad != std::string::npos)
    throw FileError(
        path + ":" +
        std::to_string(std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(bad), '\n') + 1) +
        ": not valid " + language + ", a byte is not UTF-8");
  return text;
}

/// Refuses what yaml-cpp 0.8 reads as endlessly many empty documents: closing brackets that nothing opened.
class EndlessDocuments : public YAML::EventHandler {
 public:
  void OnDocumentStart(const YAML::Mark& mark) override {
    if (mark.pos == last_) throw YAML::ParserException(mark, "a bracket is closed that was not opened");
    last_ = mark.pos;
  }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark&, YAML::anchor_t) override {}
  void OnAlias(const YAML::Mark&, YAML::anchor_t) override {}
  void OnScalar(const YAML::Mark&, const std::string&, YAML::anchor_t, const std::string&) override {}
  void OnSequenceStart(const YAML::Mark&, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {}
  void OnSequenceEnd() override {}
  void OnMapStart(const YAML::Mark&, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {}
  void OnMapEnd() override {}

 private:
  int last_{-1};
};

YAML::Node load(const std::string& path, const std::string& language) {
  const std::string text = text_of(path, language);
  try {
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    for (EndlessDocuments events; parser.HandleNextDocument(events);) {
    }
    return only_document(path, YAML::LoadAll(text));
  } catch (const YAML::Exception& error) {
    throw FileError(path + ":" + std::to_string(error.mark.line + 1) + ": not valid " + language + ", " + error.msg);
  }
}

/// yaml-cpp throws where the type of a value that is not there is asked for.
bool is(const YAML::Node& node, YAML::NodeType::value type) { return node.IsDefined() && node.Type() == type; }

std::string kind(const YAML::Node& node) {
  if (!node.IsDefined() || node.IsNull()) return "nothing";
  if (node.IsSequence()) return "a list";
  if (node.IsMap()) return "a map";
  return "'" + node.Scalar() + "'";
}

}  // namespace

YamlFile::YamlFile(const std::string& path, const std::string& language)
    : path_(path), root_(run_interruptibly([path, language] { return load(path, language); })) {}

std::string YamlFile::where(const YAML::Node& node) const {
  if (!node.IsDefined() || node.Mark().is_null()) return path_;
  return path_ + ":" + std::to_string(node.Mark().line + 1);
}

void YamlFile::fail(const YAML::Node& node, const std::string& what) const {
  throw FileError(where(node) + ": " + what);
}

void YamlFile::unsupported(const YAML::Node& node, const std::string& what) const {
  throw NotSupported(where(node) + ": " + what);
}

void YamlFile::require_map(const YAML::Node& node, const std::string& what, std::span<const std::string> known) const {
  if (!is(node, YAML::NodeType::Map)) fail(node, what + " must be a map of keys and values, not " + kind(node));
  std::set<std::string> seen;
  for (const auto& entry : node) {
    const std::string key = text(entry.first, "a key of " + what);
    if (std::find(known.begin(), known.end(), key) == known.end()) {
      const std::string nearest = did_you_mean(key, known);
      fail(entry.first,
           "unknown key '" + key + "' in " + what + (nearest.empty() ? "; known are " + quoted_list(known) : nearest));
    }
    if (!seen.insert(key).second) fail(entry.first, "key '" + key + "' appears twice in " + what);
  }
}

void YamlFile::require_list(const YAML::Node& node, const std::string& what) const {
  if (!is(node, YAML::NodeType::Sequence)) fail(node, what + " must be a list, not " + kind(node));
}

YAML::Node YamlFile::require(const YAML::Node& map, const std::string& key, const std::string& what) const {
  const YAML::Node value = map[key];
  if (!value.IsDefined() || value.IsNull()) fail(map, what + " has no '" + key + "'");
  return value;
}

double YamlFile::number(const YAML::Node& node, const std::string& what) const {
  if (!is(node, YAML::NodeType::Scalar)) fail(node, what + " must be a number, not " + kind(node));
  const std::string& scalar = node.Scalar();
  const std::string lower = [&] {
    std::string result = scalar;
    for (char& c : result) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return result;
  }();
  if (lower == ".nan" || lower == ".inf" || lower == "-.inf" || lower == "+.inf")
    fail(node, what + " is " + scalar + "; only finite numbers are allowed");
  // Not yaml-cpp's conversion: it depends on the locale.
  const char* begin = scalar.data() + (scalar.starts_with('+') ? 1 : 0);
  const char* end = scalar.data() + scalar.size();
  double value{};
  const auto [rest, error] = std::from_chars(begin, end, value);
  if (error == std::errc::result_out_of_range) fail(node, what + " is " + scalar + ", which does not fit a double");
  if (error != std::errc() || rest != end) fail(node, what + " must be a number, not " + kind(node));
  if (!std::isfinite(value)) fail(node, what + " is " + scalar + "; only finite numbers are allowed");
  return value;
}

std::vector<double> YamlFile::numbers(const YAML::Node& node, const std::string& what) const {
  require_list(node, what);
  std::vector<double> values;
  for (const YAML::Node& entry : node) values.push_back(number(entry, what));
  return values;
}

std::vector<double> YamlFile::numbers(const YAML::Node& node, const std::string& what, std::size_t count) const {
  std::vector<double> values = numbers(node, what);
  if (values.size() != count)
    fail(node, what + " must be " + std::to_string(count) + " numbers, not " + std::to_string(values.size()));
  return values;
}

std::string YamlFile::text(const YAML::Node& node, const std::string& what) const {
  if (!is(node, YAML::NodeType::Scalar)) fail(node, what + " must be a text, not " + kind(node));
  return node.Scalar();
}

std::vector<std::string> YamlFile::texts(const YAML::Node& node, const std::string& what) const {
  require_list(node, what);
  std::vector<std::string> values;
  for (const YAML::Node& entry : node) values.push_back(text(entry, what));
  return values;
}

bool YamlFile::boolean(const YAML::Node& node, const std::string& what) const {
  if (is(node, YAML::NodeType::Scalar)) {
    const std::string& value = node.Scalar();
    if (value == "true" || value == "True" || value == "1") return true;
    if (value == "false" || value == "False" || value == "0") return false;
  }
  fail(node, what + " must be true or false, not " + kind(node));
}

bool is_empty(const YAML::Node& node) {
  if (!node.IsDefined() || node.IsNull()) return true;
  if (node.IsScalar()) return node.Scalar().empty();
  return node.size() == 0;
}

}  // namespace srmp::io
