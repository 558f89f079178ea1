#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tinyxml2 {
class XMLDocument;
class XMLElement;
}  // namespace tinyxml2

namespace srmp::xml {

/// The whole file. Throws FileError, where `kind` says what was to be read.
std::string read_text(const std::string& path, const std::string& kind);

/// A parsed XML text that knows where it came from. Every refusal is a FileError "<label>:<line>: <sentence>".
class Document {
 public:
  static Document read_file(const std::string& path, const std::string& kind, const char* root_tag);
  static Document parse(const std::string& text, const std::string& label, const char* root_tag);
  ~Document();
  Document(Document&&) noexcept;

  const tinyxml2::XMLElement& root() const { return *root_; }
  const std::string& label() const { return label_; }

  [[noreturn]] void fail(int line, const std::string& sentence) const;
  [[noreturn]] void fail(const tinyxml2::XMLElement& at, const std::string& sentence) const;

  std::optional<std::string> attribute(const tinyxml2::XMLElement& element, const char* name) const;
  std::string required(const tinyxml2::XMLElement& element, const char* name) const;
  /// Finite numbers only.
  std::optional<double> number(const tinyxml2::XMLElement& element, const char* name) const;
  double required_number(const tinyxml2::XMLElement& element, const char* name) const;
  std::optional<Eigen::Vector3d> vector3(const tinyxml2::XMLElement& element, const char* name) const;
  /// The numbers in a text of `element`, whatever their count.
  std::vector<double> numbers(const tinyxml2::XMLElement& element, const char* name, const std::string& text) const;

  /// Refuses child tags and attributes that look like misspelt known ones. Names in `extensions`, and names that
  /// resemble nothing known, belong to somebody else's tool and pass.
  void check_spelling(const tinyxml2::XMLElement& element, std::span<const std::string> tags,
                      std::span<const std::string> attributes, std::span<const std::string> extensions = {}) const;

 private:
  Document();
  std::unique_ptr<tinyxml2::XMLDocument> document_;
  const tinyxml2::XMLElement* root_{};
  std::string label_;
};

}  // namespace srmp::xml
