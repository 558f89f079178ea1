#include "srmp/robot/xml.hpp"

#include <tinyxml2.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "srmp/core/error.hpp"
#include "srmp/core/spelling.hpp"
#include "srmp/core/utf8.hpp"

namespace srmp::xml {

namespace {

bool is_space(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

bool contains(std::span<const std::string> names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// An element of Xacro in the document, or nullptr.
const tinyxml2::XMLElement* find_xacro(const tinyxml2::XMLElement& root) {
  std::vector<const tinyxml2::XMLElement*> open{&root};
  while (!open.empty()) {
    const tinyxml2::XMLElement* element = open.back();
    open.pop_back();
    if (std::string_view(element->Name()).starts_with("xacro:")) return element;
    for (auto child = element->FirstChildElement(); child; child = child->NextSiblingElement()) open.push_back(child);
  }
  return nullptr;
}

constexpr const char* kExpandFirst = "; expand the file first (xacro FILE.xacro > FILE) and give the result";

/// People write their names in comments, in whatever encoding: what is no UTF-8 there becomes a question mark.
void fix_comments(std::string& text) {
  for (std::size_t bad = find_invalid_utf8(text); bad != std::string::npos; bad = find_invalid_utf8(text)) {
    const std::size_t open = text.rfind("<!--", bad), close = text.find("-->", bad);
    if (open == std::string::npos || close == std::string::npos || text.find("-->", open) != close) return;
    for (std::size_t i = bad; i < close; ++i)
      if (static_cast<unsigned char>(text[i]) >= 0x80) text[i] = '?';
  }
}

}  // namespace

std::string read_text(const std::string& path, const std::string& kind) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  if (!fs::exists(path, ignored)) throw FileError(kind + " file '" + path + "' does not exist");
  if (!fs::is_regular_file(path, ignored)) throw FileError(kind + " file '" + path + "' is not a file");
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  if (!file) throw FileError(kind + " file '" + path + "' cannot be read");
  std::string content = text.str();
  fix_comments(content);
  return content;
}

Document::Document() : document_(std::make_unique<tinyxml2::XMLDocument>()) {}
Document::~Document() = default;
Document::Document(Document&&) noexcept = default;

Document Document::read_file(const std::string& path, const std::string& kind, const char* root_tag) {
  return parse(read_text(path, kind), path, root_tag);
}

Document Document::parse(const std::string& text, const std::string& label, const char* root_tag, bool strict) {
  Document result;
  result.label_ = label;
  result.strict_ = strict;
  if (std::all_of(text.begin(), text.end(), is_space))
    throw FileError(label + " is empty; expected a <" + root_tag + ">");
  if (const std::size_t bad = find_invalid_utf8(text); bad != std::string::npos)
    result.fail(static_cast<int>(std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(bad), '\n')) + 1,
                "a byte is not UTF-8; save the file as UTF-8");
  if (result.document_->Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS)
    result.fail(result.document_->ErrorLineNum(), "broken XML (" +
                                                      std::string(result.document_->ErrorName()).substr(4) +
                                                      "); a tag is not closed, nested or quoted properly");
  result.root_ = result.document_->RootElement();
  if (!result.root_) throw FileError(label + " contains no XML element; expected a <" + root_tag + ">");
  if (std::string(result.root_->Name()) != root_tag)
    result.fail(*result.root_,
                "the outermost tag is <" + std::string(result.root_->Name()) + ">, expected <" + root_tag + ">");
  if (const auto* xacro = find_xacro(*result.root_))
    result.fail(*xacro, "<" + std::string(xacro->Name()) + "> is Xacro, which is not read" + kExpandFirst);
  return result;
}

void Document::fail(int line, const std::string& sentence) const {
  throw FileError(label_ + ":" + std::to_string(line) + ": " + sentence);
}

void Document::fail(const tinyxml2::XMLElement& at, const std::string& sentence) const {
  fail(at.GetLineNum(), sentence);
}

void Document::add_warning(int line, const std::string& sentence) {
  const auto same = std::find_if(warnings_.begin(), warnings_.end(),
                                 [&](const Warning& warning) { return warning.sentence == sentence; });
  if (same == warnings_.end())
    warnings_.push_back({line, sentence});
  else
    ++same->repeats;
}

void Document::warn(int line, const std::string& sentence) {
  if (strict_) fail(line, sentence);
  add_warning(line, sentence);
}

void Document::warn(const tinyxml2::XMLElement& at, const std::string& sentence) { warn(at.GetLineNum(), sentence); }

void Document::note(const tinyxml2::XMLElement& at, const std::string& sentence) {
  add_warning(at.GetLineNum(), sentence);
}

std::vector<std::string> Document::warnings() const {
  std::vector<std::string> texts;
  for (const auto& [line, sentence, repeats] : warnings_)
    texts.push_back(label_ + ":" + std::to_string(line) + ": " + sentence +
                    (repeats == 0   ? ""
                     : repeats == 1 ? " (and once more)"
                                    : " (and " + std::to_string(repeats) + " times more)"));
  return texts;
}

std::optional<std::string> Document::attribute(const tinyxml2::XMLElement& element, const char* name) const {
  const char* text = element.Attribute(name);
  if (!text) return std::nullopt;
  const std::string value(text);
  if (value.find("${") != std::string::npos || value.find("$(") != std::string::npos)
    fail(element, "attribute '" + std::string(name) + "' of <" + element.Name() + "> is '" + value +
                      "', an expression of Xacro" + kExpandFirst);
  if (!is_utf8(value))  // a reference to a character that does not exist
    fail(element, "attribute '" + std::string(name) + "' of <" + element.Name() + "> is not UTF-8: '" + value + "'");
  return value;
}

std::string Document::required(const tinyxml2::XMLElement& element, const char* name) const {
  const auto text = attribute(element, name);
  if (!text) fail(element, "<" + std::string(element.Name()) + "> has no attribute '" + name + "'");
  if (text->empty()) fail(element, "attribute '" + std::string(name) + "' of <" + element.Name() + "> is empty");
  return *text;
}

std::vector<double> Document::numbers(const tinyxml2::XMLElement& element, const char* name,
                                      const std::string& text) const {
  std::vector<double> values;
  const char *at = text.data(), *end = text.data() + text.size();
  while (true) {
    while (at != end && is_space(*at)) ++at;
    if (at == end) return values;
    const char* stop = std::find_if(at, end, is_space);
    const char* digits = *at == '+' ? at + 1 : at;  // from_chars does not accept a plus sign
    double value = 0.0;
    const auto [end_of_number, error] = std::from_chars(digits, stop, value);
    if (error != std::errc() || end_of_number != stop)
      fail(element, "attribute '" + std::string(name) + "' of <" + element.Name() + "> contains '" +
                        std::string(at, stop) + "', which is not a number");
    if (!std::isfinite(value))
      fail(element, "attribute '" + std::string(name) + "' of <" + element.Name() + "> is " + to_text(value) +
                        "; only finite numbers are allowed");
    values.push_back(value);
    at = stop;
  }
}

std::optional<double> Document::number(const tinyxml2::XMLElement& element, const char* name) const {
  const auto text = attribute(element, name);
  if (!text) return std::nullopt;
  const auto values = numbers(element, name, *text);
  if (values.size() != 1)
    fail(element,
         "attribute '" + std::string(name) + "' of <" + element.Name() + "> is '" + *text + "'; expected one number");
  return values[0];
}

double Document::required_number(const tinyxml2::XMLElement& element, const char* name) const {
  required(element, name);
  return *number(element, name);
}

std::optional<Eigen::Vector3d> Document::vector3(const tinyxml2::XMLElement& element, const char* name) const {
  const auto text = attribute(element, name);
  if (!text) return std::nullopt;
  const auto values = numbers(element, name, *text);
  if (values.size() != 3)
    fail(element, "attribute '" + std::string(name) + "' of <" + element.Name() + "> is '" + *text +
                      "'; expected three numbers");
  return Eigen::Vector3d(values[0], values[1], values[2]);
}

void Document::check_spelling(const tinyxml2::XMLElement& element, std::span<const std::string> tags,
                              std::span<const std::string> attributes, std::span<const std::string> extensions) {
  for (auto child = element.FirstChildElement(); child; child = child->NextSiblingElement()) {
    const std::string tag = child->Name();
    if (contains(tags, tag) || contains(extensions, tag) || tag.find(':') != std::string::npos) continue;
    const std::string* known = nearest_name(tag, tags);
    if (!known) continue;
    const std::string unknown = "unknown tag <" + tag + "> in <" + element.Name() + ">";
    if (is_typo(tag, *known)) fail(*child, unknown + ", did you mean '" + *known + "'?");
    warn(*child, unknown + " is not read; <" + *known + "> would be");
  }
  for (auto a = element.FirstAttribute(); a; a = a->Next()) {
    const std::string name = a->Name();
    if (contains(attributes, name) || name.find(':') != std::string::npos) continue;
    const std::string* known = nearest_name(name, attributes);
    if (!known) continue;
    const std::string unknown = "unknown attribute '" + name + "' of <" + element.Name() + ">";
    const bool given_too = element.Attribute(known->c_str()) != nullptr;
    if (!given_too && is_typo(name, *known)) fail(a->GetLineNum(), unknown + ", did you mean '" + *known + "'?");
    warn(a->GetLineNum(), unknown + " is not read; '" + *known + "' is" + (given_too ? "" : " missing"));
  }
}

}  // namespace srmp::xml
